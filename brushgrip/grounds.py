"""What recordings stand on, as the command line says it."""

from collections.abc import Sequence
from dataclasses import replace

from brushgrip.console import say
from identification import FoundModel, Recording
from symbolic import InvalidInputError
from symbolic.errors import printable


def on_grounds(
    recordings: Sequence[Recording], given: Sequence[str] | None, *, bare: bool = False
) -> list[Recording]:
    """The recordings with the grounds that `--ground` names.

    Args:
        recordings: as read; what their files say of the ground holds where the command line is silent.
        given: texts such as "steel=fem1,fem3".
        bare: a text without "=" is allowed too: the ground of every recording.

    Raises:
        InvalidInputError: a text is none such, names no recording of these, or a recording twice.
    """
    grounds = grounds_by_name([recording.name for recording in recordings], given, bare=bare)
    return [replace(r, ground=grounds.get(r.name, r.ground)) for r in recordings]


def grounds_by_name(
    names: Sequence[str], given: Sequence[str] | None, *, bare: bool = False
) -> dict[str, str]:
    """The grounds that `--ground` names, by recording; see `on_grounds`."""
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


def say_ground(recording: Recording, found: FoundModel | None) -> None:
    """One line on the ground whose values are taken from a model, where it has any."""
    taken = found.ground_taken(recording.ground) if found else ""
    if taken:
        say(f"{recording.name}: {taken}")
