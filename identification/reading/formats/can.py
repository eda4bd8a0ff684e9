"""Logs of a CAN bus (BLF, ASC, candump) with the database of its signals, by python-can and cantools."""

import zlib
from array import array
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from pathlib import Path
from struct import error as StructError
from struct import unpack_from
from typing import Any

import numpy as np

from identification.reading.channels import ChannelFile, Samples
from identification.reading.files import LARGEST_FILE, read_text, require_readable
from identification.reading.formats.opening import library, require_size
from identification.reading.signal_map import SignalMap
from identification.reading.table import Array
from symbolic import InvalidInputError

LARGEST_DATABASE = 20_000_000
"""Of a DBC file [bytes]."""
_CONTAINER, _LARGEST_CONTAINER = 10, 64_000_000
_METHODS = {0: False, 2: True}
"""Whether a container is compressed, by its method."""
_OBJECT_HEADER = 16
"""Least length of an object [bytes]."""


@contextmanager
def open_can(path: Path, signals: SignalMap) -> Iterator[ChannelFile]:
    """Signals as `Message.Signal`; times are those of the frames.

    The database is `dbc` of the map, or the only .dbc file beside the log.
    """
    can, cantools = library("can", "can", path), library("cantools", "can", path)
    dbc = signals.dbc or database_beside(path)
    require_readable(dbc, LARGEST_DATABASE)
    try:
        database = cantools.database.load_string(read_text(dbc), "dbc", strict=False)
    except Exception as error:
        raise InvalidInputError(f"{dbc}: is no DBC file: {str(error).splitlines()[0]}") from None
    frames = {m.frame_id: m for m in database.messages}
    owners = {f"{m.name}.{s.name}": m for m in frames.values() for s in m.signals}
    units = {f"{m.name}.{s.name}": s.unit or "" for m in frames.values() for s in m.signals}
    if path.suffix.lower() == ".blf":
        require_bounded(path)

    @cache
    def decoded(identifier: int) -> tuple[Array, dict[str, Array]]:
        # A reader of BLF that finds its header damaged leaves a file that it opened itself open.
        blf = path.suffix.lower() == ".blf"
        with (
            path.open("rb") if blf else nullcontext() as raw,
            can.BLFReader(raw) if blf else can.LogReader(path) as log,
        ):
            return _decoded(path, log, frames[identifier])

    def read(name: str) -> Samples:
        times, values = decoded(owners[name].frame_id)
        return Samples(values=values[name.rpartition(".")[2]], unit=units[name], times=times)

    yield ChannelFile(names=list(owners), read=read)


def _decoded(path: Path, log: Iterable[Any], message: Any) -> tuple[Array, dict[str, Array]]:
    """Times of the frames of a message, and its signals; NaN where a frame lacks one."""
    times, columns = array("d"), {signal.name: array("d") for signal in message.signals}
    for frame in log:
        if frame.arbitration_id != message.frame_id or frame.is_error_frame or frame.is_remote_frame:
            continue
        content = message.decode(bytes(frame.data), decode_choices=False, allow_truncated=True)
        times.append(frame.timestamp)
        for name, values in columns.items():
            values.append(float(content.get(name, np.nan)))
        require_size(path, message.name, len(times))
    if not times:
        raise InvalidInputError(f"{path}: holds no frame {message.name} ({message.frame_id:#x})")
    return np.array(times), {name: np.array(values) for name, values in columns.items()}


def database_beside(path: Path) -> Path:
    """The only .dbc file beside a log.

    Raises:
        InvalidInputError: there is none, or more than one.
    """
    found = sorted(path.parent.glob("*.dbc"))
    if len(found) != 1:
        raise InvalidInputError(
            f"{path}: {len(found)} databases (.dbc) beside it; name one, such as --map dbc=car.dbc"
        )
    return found[0]


def require_bounded(path: Path) -> None:
    """Refuses a BLF file whose parts are larger than files may be, or that python-can reads for ever.

    Raises:
        InvalidInputError: they are, or the file is damaged.
    """
    total, rest = 0, b""
    try:
        for part, compressed in _containers(path.read_bytes()):
            inflater = zlib.decompressobj()
            unpacked = inflater.decompress(part, _LARGEST_CONTAINER) if compressed else part
            total += len(unpacked)
            if inflater.unconsumed_tail or total > LARGEST_FILE:
                raise InvalidInputError(f"{path}: holds more than {LARGEST_FILE / 1e6:.3g} MB unpacked")
            rest = _after_objects(path, rest + unpacked)
    except (StructError, zlib.error) as error:
        raise InvalidInputError(f"{path}: is damaged, or no .blf file: {error}") from None


def _after_objects(path: Path, data: bytes) -> bytes:
    """What follows the last whole object of some containers, and belongs to the next one.

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
