"""Logs of a CAN bus (BLF, ASC, candump) with the database of its signals, by python-can and cantools."""

import re
import zlib
from array import array
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import cache
from pathlib import Path
from struct import error as StructError
from struct import unpack_from
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.reading.channels_by_name import ChannelFile, ChannelSamples, match_channel
from identification.reading.checked_file_reading import MAX_FILE_SIZE, read_text, require_readable
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.signal_map import SignalMap, SignalSource
from identification.reading.units import is_unit
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

MAX_DATABASE_SIZE = 20_000_000
"""Largest DBC file that is read [bytes]."""
MAX_FRAME_LENGTH, MAX_TRANSPORT_LENGTH = 64, 1785
"""Longest message in one frame of CAN FD, and in the several extended frames of SAE J1939 [bytes]."""
_MAX_STANDARD_ID = 0x7FF
"""Largest identifier of a standard frame; larger ones are extended, whatever the DBC file declares."""
_BLANK = r"(?:\s|//.*)"
_MESSAGE = re.compile(rf"\bBO_{_BLANK}+(\d+){_BLANK}+(\w+){_BLANK}*:{_BLANK}*[-+]?(\d+)")
_SIGNAL = re.compile(
    rf"\bSG_{_BLANK}+(\w+)(?:{_BLANK}+\w+)?{_BLANK}*:{_BLANK}*[-+]?(\d+){_BLANK}*\|{_BLANK}*[-+]?(\d+)"
)
_ROUNDING = 1e-6
"""Relative rounding error of a float at the end of its range."""
NEAR_END = 0.98
"""Share of the range of a torque in the database from which on its sensor may end [1]."""


@contextmanager
def open_can(path: Path, signals: SignalMap) -> Iterator[ChannelFile]:
    """Signals as `Message.Signal`, or as `Bus/Message.Signal` in a map; times are those of the frames.

    The database is `dbc` of the map, or the only .dbc file beside the log.
    """
    can = import_library("can", "can", path)
    beside = sorted(path.parent.glob("*.dbc"))
    if signals.dbc is None and len(beside) != 1:
        raise InvalidInputError(
            f"{path}: {len(beside)} databases (.dbc) beside it; name one, such as --map dbc=car.dbc"
        )
    database = read_database(signals.dbc or beside[0])
    listed = [(f"{m.name}.{s.name}", ("", m, s)) for m in database.messages for s in m.signals]
    names, places = [name for name, _ in listed], dict(listed)
    for channel in dict.fromkeys(source.channel for source in signals.signals.values()):
        bus, on_bus, short = channel.partition("/")
        if on_bus and (name := match_channel(str(path), short, names)) is not None:
            places[channel] = (bus, *places[name][1:])
    is_blf = path.suffix.lower() == ".blf"
    if is_blf:
        require_bounded_blf_parts(path)

    @cache
    def decoded(message: Any, bus: str) -> tuple[Array, dict[str, Array]]:
        # A reader of BLF that finds its header damaged leaves a file that it opened itself open.
        with (
            path.open("rb") if is_blf else nullcontext() as raw,
            can.BLFReader(raw) if is_blf else can.LogReader(path) as log,
        ):
            times, values, found = _decoded(path, log, message, bus)
        if not bus and len(found) > 1:
            raise InvalidInputError(
                f"{path}: holds the frame {message.name} ({message.frame_id:#x}) from several buses,"
                f" {', '.join(found)}; say which, such as --map"
                f" {_map_option_with_bus(found[0], message, places, signals)}"
            )
        return times, values

    def read(name: str) -> ChannelSamples:
        bus, message, signal = places[name]
        times, values = decoded(message, bus)
        return _drop_out_of_range_values(path, name, signal, times, values[signal.name])

    names += [name for name, (bus, *_) in places.items() if bus]
    yield ChannelFile(names=names, read=read, own_clocks=True)


def read_database(dbc: Path) -> Any:
    """The messages of a DBC file; cantools takes minutes for one of absurd length, and is not asked."""
    cantools = import_library("cantools", "can", dbc)
    require_readable(dbc, MAX_DATABASE_SIZE)
    text = read_text(dbc)
    for identifier, name, size in _MESSAGE.findall(text):
        most = MAX_TRANSPORT_LENGTH if int(identifier[:20]) > _MAX_STANDARD_ID else MAX_FRAME_LENGTH
        if len(size) > 9 or int(size) > most:
            raise InvalidInputError(
                f"{dbc}: message {name[:40]} has {size[:20]} bytes; allowed: up to {most}"
            )
    for name, *place in _SIGNAL.findall(text):
        if any(len(number) > 9 or int(number) > 8 * MAX_TRANSPORT_LENGTH for number in place):
            raise InvalidInputError(
                f"{dbc}: signal {name[:40]} lies beyond the {MAX_TRANSPORT_LENGTH} bytes of any message"
            )
    try:
        return cantools.database.load_string(text, "dbc", strict=False)
    except Exception as error:
        raise InvalidInputError(f"{dbc}: is no DBC file: {str(error).splitlines()[0]}") from None


def _decoded(
    path: Path, log: Iterable[Any], message: Any, bus: str
) -> tuple[Array, dict[str, Array], list[str]]:
    """Times of a message on a bus, or the first that has it, its signals, and all buses that have it."""
    times, columns = array("d"), {signal.name: array("d") for signal in message.signals}
    extended = is_extended(message)
    buses: dict[str, None] = {}
    other_kind, counts = False, path.suffix.lower() != ".log"
    for frame in log:
        if frame.arbitration_id != message.frame_id or frame.is_error_frame or frame.is_remote_frame:
            continue
        if frame.is_extended_id != extended:
            other_kind = True
            continue
        # As the file calls it: python-can counts from 0 what BLF and ASC files count from 1.
        here = str(frame.channel + 1 if counts and isinstance(frame.channel, int) else frame.channel)
        buses[here] = None
        if here != (bus or next(iter(buses))):
            continue
        content = message.decode(bytes(frame.data), decode_choices=False, allow_truncated=True)
        times.append(frame.timestamp)
        for name, values in columns.items():
            values.append(float(content.get(name, np.nan)))
        require_allowed_size(path, message.name, len(times))
    if not times:
        kinds = ("extended ", "a standard") if extended else ("standard ", "an extended")
        there = f" on bus {bus}; it is on {', '.join(buses)}" if buses else ""
        there += f", but {kinds[1]} one of that identifier" if other_kind else ""
        frame = f"frame {message.name} ({message.frame_id:#x})"
        raise InvalidInputError(f"{path}: holds no {kinds[0] * other_kind}{frame}{there}")
    return np.array(times), {name: np.array(v) for name, v in columns.items()}, list(buses)


def is_extended(message: Any) -> bool:
    """Whether a message has an extended identifier, also where the database does not say so."""
    return bool(message.is_extended_frame or message.frame_id > _MAX_STANDARD_ID)


def _map_option_with_bus(bus: str, message: Any, places: dict[str, Any], signals: SignalMap) -> str:
    """A map of the signals of a message with their bus, as on the command line."""
    sources = {
        column: source
        for column, source in signals.signals.items()
        if any(
            m is message and f".{n}".endswith(f".{source.channel}") for n, (_, m, _) in places.items()
        )
    }
    if not sources:
        signal = message.signals[0].name
        sources = {signal: SignalSource(channel=f"{message.name}.{signal}")}
    return ",".join(
        replace(source, channel=f"{bus}/{source.channel}").map_option_text(column)
        for column, source in sources.items()
    )


def signal_range(signal: Any) -> tuple[float, float]:
    """The range of a signal in the database, infinite where it names none."""
    low = -np.inf if signal.minimum is None else float(signal.minimum)
    return low, np.inf if signal.maximum is None else float(signal.maximum)


def within_signal_range(signal: Any, values: Array) -> NDArray[np.bool_]:
    """Mask of the values within a signal's range, up to half a step; False for NaN."""
    low, high = signal_range(signal)
    step = 0.5 * abs(float(signal.scale))
    slack = [abs(end) * _ROUNDING if signal.is_float else step for end in (low, high)]
    return ~((values < low - slack[0]) | (values > high + slack[1]))


def _drop_out_of_range_values(
    path: Path, name: str, signal: Any, times: Array, values: Array
) -> ChannelSamples:
    """A signal without what lies outside the range of the database, as 0xFFFF for "not available"."""
    low, high = signal_range(signal)
    outside = ~within_signal_range(signal, values)
    unit = signal.unit or ""
    span = f"the range of the database, {low:g} to {high:g} {unit}".rstrip()
    if outside.any() and not np.isfinite(values[~outside]).any():
        raise InvalidInputError(f"{path}: every value of {name} lies outside {span}; correct the .dbc")
    remark = f"{outside.sum()} of {values.size} values lie outside {span}, and count as missing"
    near = (high > 0) & (values >= NEAR_END * high) | (low < 0) & (values <= NEAR_END * low)
    ends = is_unit("M_z", unit) and (near & ~outside).any()
    told = (
        f"comes within {100 * (1 - NEAR_END):.0f} % of the end of {span}: if its sensor ends there,"
        " friction may be higher than told; declare [sensor] range in the rig file"
    )
    return ChannelSamples(
        values=np.where(outside, np.nan, values),
        unit=unit,
        times=times,
        remark="; ".join([remark] * bool(outside.any()) + [told] * bool(ends)),
    )


_CONTAINER, _MAX_CONTAINER_SIZE = 10, 64_000_000
_METHODS = {0: False, 2: True}
"""Whether a container is compressed, by its method."""
_OBJECT_HEADER = 16
"""Least length of an object [bytes]."""


def require_bounded_blf_parts(path: Path) -> None:
    """Refuses a BLF file whose parts are larger than files may be, or that python-can reads for ever."""
    total, rest = 0, b""
    try:
        for part, compressed in _blf_containers(path.read_bytes()):
            inflater = zlib.decompressobj()
            unpacked = inflater.decompress(part, _MAX_CONTAINER_SIZE) if compressed else part
            total += len(unpacked)
            if inflater.unconsumed_tail or total > MAX_FILE_SIZE:
                raise InvalidInputError(f"{path}: holds more than {MAX_FILE_SIZE / 1e6:.3g} MB unpacked")
            rest = _bytes_after_last_object(path, rest + unpacked)
    except (StructError, zlib.error) as error:
        raise InvalidInputError(f"{path}: is damaged, or no .blf file: {error}") from None


def _bytes_after_last_object(path: Path, data: bytes) -> bytes:
    """Bytes behind the last whole object of some containers, which belong to the next one."""
    at = 0
    while (begin := data.find(b"LOBJ", at, at + 8)) >= 0 and begin + _OBJECT_HEADER <= len(data):
        (size,) = unpack_from("<I", data, begin + 8)
        if size < _OBJECT_HEADER:
            raise InvalidInputError(f"{path}: is damaged, an object of it has a length of {size}")
        if begin + size > len(data):
            break
        at = begin + size
    return data[at:]


def _blf_containers(content: bytes) -> Iterator[tuple[bytes, bool]]:
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
