"""What recordings stand on, as the command line says it."""

from collections.abc import Sequence

from symbolic import InvalidInputError
from symbolic.errors import printable


def grounds_by_name(
    names: Sequence[str], given: Sequence[str] | None, *, bare: bool = False
) -> dict[str, str]:
    """The grounds that `--ground` names, by recording.

    Args:
        names: labels of all recordings.
        given: texts such as "steel=fem1,fem3".
        bare: a text without "=" is allowed too: the ground of every recording.

    Raises:
        InvalidInputError: a text is none such, names no recording of these, or a recording twice.
    """
    grounds: dict[str, str] = {}
    for text in given or ():
        ground, equals, listed = (printable(part.strip()) for part in text.partition("="))
        if not ground or not (equals or bare):
            form = "NAME, or NAME=REC,REC" if bare else "NAME=REC,REC"
            raise InvalidInputError(f"--ground {text}: expected {form}, such as steel=fem1,fem3")
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
