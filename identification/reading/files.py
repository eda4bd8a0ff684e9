"""Files as bytes and text, with every failure as one line."""

from pathlib import Path

from symbolic import InvalidInputError
from symbolic.parsing import naming, text_of


def read_bytes(path: Path) -> bytes:
    """The content of a file.

    Raises:
        InvalidInputError: no such file, a directory, or not readable.
    """
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InvalidInputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InvalidInputError(f"{path}: is a directory, expected a file") from None
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror or error}") from None


def read_text(path: Path) -> str:
    """The content of a UTF-8 text file, without its byte order mark.

    Raises:
        InvalidInputError: not readable, empty, or not UTF-8 text.
    """
    content = read_bytes(path)
    with naming(path):
        return text_of(content)
