"""Files as bytes and text, with every failure as one line."""

from pathlib import Path

from symbolic.errors import InvalidInputError

_LONGEST_EXCERPT = 40


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
    if not content.strip():
        raise InvalidInputError(f"{path}: is empty")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        raise InvalidInputError(
            f"{path}: row {row}: is not text, byte 0x{content[error.start]:02x} is not UTF-8; "
            "save the file as UTF-8"
        ) from None
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise InvalidInputError(f"{path}: row {row}: is not text, it holds a zero byte")
    return text


def excerpt(text: str) -> str:
    """The text, quoted on one line and cut where it is long, to show in a message."""
    return repr(text if len(text) <= _LONGEST_EXCERPT else text[:_LONGEST_EXCERPT] + "…")
