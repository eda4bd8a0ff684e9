"""Files as bytes and text, with every failure as one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from stat import S_ISREG

from symbolic import InvalidInputError
from symbolic.tables.toml_and_json_parsing import decode_text, prefix_errors

MAX_FILE_SIZE = 500_000_000
"""Largest file that is read [bytes]."""


def require_readable(path: Path, largest: int = MAX_FILE_SIZE) -> int:
    """The size of a file that may be read [bytes]; a pipe or a device may block or never end."""
    with convert_read_errors(path):
        status = path.stat()
        if path.is_dir():
            raise InvalidInputError(f"{path}: is a directory, expected a file")
        if not S_ISREG(status.st_mode):
            raise InvalidInputError(
                f"{path}: is a pipe or a device; allowed: a regular file, save it as one"
            )
        if status.st_size > largest:
            raise InvalidInputError(
                f"{path}: holds {status.st_size / 1e6:.3g} MB; allowed: up to {largest / 1e6:.3g} MB"
            )
        return status.st_size


def read_bytes(path: Path, largest: int = MAX_FILE_SIZE) -> bytes:
    """The content of a file that `require_readable` allows."""
    size = require_readable(path, largest)
    with convert_read_errors(path), path.open("rb") as file:
        return file.read(size)


@contextmanager
def convert_read_errors(path: Path) -> Iterator[None]:
    """Says in one line why a file cannot be read."""
    try:
        yield
    except FileNotFoundError:
        raise InvalidInputError(f"{path}: no such file") from None
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror or error}") from None


def read_text(path: Path) -> str:
    """The content of a UTF-8 text file, without its byte order mark."""
    content = read_bytes(path)
    with prefix_errors(path):
        return decode_text(content)
