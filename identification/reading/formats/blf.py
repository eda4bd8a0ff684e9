"""BLF files checked before python-can reads them, which trusts the lengths that they declare."""

import zlib
from collections.abc import Iterator
from pathlib import Path
from struct import error as StructError
from struct import unpack_from

from identification.reading.files import MAX_FILE_SIZE
from symbolic import InvalidInputError

_CONTAINER, _MAX_CONTAINER_SIZE = 10, 64_000_000
_METHODS = {0: False, 2: True}
"""Whether a container is compressed, by its method."""
_OBJECT_HEADER = 16
"""Least length of an object [bytes]."""


def require_bounded(path: Path) -> None:
    """Refuses a BLF file whose parts are larger than files may be, or that python-can reads for ever.

    Raises:
        InvalidInputError: they are, or the file is damaged.
    """
    total, rest = 0, b""
    try:
        for part, compressed in _containers(path.read_bytes()):
            inflater = zlib.decompressobj()
            unpacked = inflater.decompress(part, _MAX_CONTAINER_SIZE) if compressed else part
            total += len(unpacked)
            if inflater.unconsumed_tail or total > MAX_FILE_SIZE:
                raise InvalidInputError(f"{path}: holds more than {MAX_FILE_SIZE / 1e6:.3g} MB unpacked")
            rest = _after_objects(path, rest + unpacked)
    except (StructError, zlib.error) as error:
        raise InvalidInputError(f"{path}: is damaged, or no .blf file: {error}") from None


def _after_objects(path: Path, data: bytes) -> bytes:
    """Bytes behind the last whole object of some containers, which belong to the next one.

    Raises:
        InvalidInputError: an object is shorter than its header; it would be its own successor.
    """
    at = 0
    while (begin := data.find(b"LOBJ", at, at + 8)) >= 0 and begin + _OBJECT_HEADER <= len(data):
        (size,) = unpack_from("<I", data, begin + 8)
        if size < _OBJECT_HEADER:
            raise InvalidInputError(f"{path}: is damaged, an object of it has a length of {size}")
        if begin + size > len(data):
            break
        at = begin + size
    return data[at:]


def _containers(content: bytes) -> Iterator[tuple[bytes, bool]]:
    """Parts of a BLF file, as python-can walks them, and whether they are compressed."""
    (at,) = unpack_from("<I", content, 4)
    while at + 16 <= len(content):
        signature, _, _, size, kind = unpack_from("<4sHHII", content, at)
        if signature != b"LOBJ" or size < 16:
            return
        method = unpack_from("<H", content, at + 16)[0] if kind == _CONTAINER else -1
        if method in _METHODS:
            yield content[at + 32 : at + size], _METHODS[method]
        at += size + size % 4
