"""What recordings stand on, as the command line says it."""

from collections.abc import Sequence

from symbolic import InvalidInputError
from symbolic.errors import printable


def grounds_by_name(names: Sequence[str], given: Sequence[str] | None) -> dict[str, str]:
    """The grounds that `--ground` names, by recording.

    Args:
        names: labels of all recordings.
        given: texts such as "steel=fem1,fem3", or "steel": the ground of every recording.

    Raises:
        InvalidInputError: a text is none such, names no recording of these, or a recording twice.
    """
    grounds: dict[str, str] = {}
    for text in given or ():
        ground, equals, listed = (printable(part.strip()) for part in text.partition("="))
        if not ground:
            raise InvalidInputError(
                f"--ground {text}: expected NAME, or NAME=REC,REC such as steel=fem1,fem3"
            )
        for name in [one.strip() for one in listed.split(",")] if equals else names:
            if name not in names:
                raise InvalidInputError(
                    f"--ground {text}: no recording {name!r}; given are {', '.join(names)}"
                )
            if grounds.setdefault(name, ground) != ground:
                raise InvalidInputError(
                    f"--ground {text}: {name} stands on {grounds[name]} already; one ground each"
                )
    return grounds
