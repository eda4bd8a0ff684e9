"""The one tree of errors."""

_MAX_LENGTH, _END_LENGTH = 1000, 300
"""Length of a message, and of its end that stays where it is longer."""


class BrushgripError(Exception):
    """Root of every error that this project raises on purpose: one line of bounded length."""

    def __init__(self, message: str) -> None:
        """Put the message, which may quote a file, on one line."""
        super().__init__(cut_to_one_line(message))


class InvalidInputError(BrushgripError, ValueError):
    """Bad input from the user: one line that names file, row, the fault and what is allowed."""


def cut_to_one_line(text: str) -> str:
    """The text as `printable` has it, its middle cut out where it is long."""
    return _cut_in_the_middle(printable(_cut_in_the_middle(text)))


def printable(text: str) -> str:
    """The text as a screen can show it on one line.

    What a terminal takes for a command, turns the direction of writing or is half a character, as in a
    file name that is not UTF-8, stands as its escape sequence.
    """
    return "".join(map(_escaped_if_unprintable, text))


def _cut_in_the_middle(text: str) -> str:
    if len(text) <= _MAX_LENGTH:
        return text
    return f"{text[: _MAX_LENGTH - _END_LENGTH - 3]} … {text[-_END_LENGTH:]}"


def _escaped_if_unprintable(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else character.encode("unicode_escape").decode("ascii")
