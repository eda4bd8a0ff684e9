"""ROS 1 bags, and ROS 2 bags (SQLite or MCAP), by rosbags."""

from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.signal_map import SignalMap

_DEEPEST = 6


@contextmanager
def open_ros(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Numbers in messages as `/topic.field.field`; a vector's numbers as `/topic.field.0`.

    Times are those of the header where messages have one, else those at which they were recorded.
    """
    rosbags = import_library("rosbags.highlevel", "ros", path)
    stores = import_library("rosbags.typesys", "ros", path)
    folder = path if path.suffix.lower() == ".bag" else path.parent
    usual = stores.get_typestore(stores.Stores.LATEST)
    with rosbags.AnyReader([folder], default_typestore=usual) as bag:
        fields: dict[str, tuple[Any, str]] = {}
        for connection in bag.connections:
            for _, _, raw in bag.messages([connection]):
                message = bag.deserialize(raw, connection.msgtype)
                fields |= {
                    f"{connection.topic}.{n}": (connection, n) for n in _number_field_names(message)
                }
                break

        def read(name: str) -> ChannelSamples:
            connection, field = fields[name]
            require_allowed_size(path, name, connection.msgcount)
            times, values = array("d"), array("d")
            start = None
            for _, recorded, raw in bag.messages([connection]):
                message = bag.deserialize(raw, connection.msgtype)
                require_allowed_size(path, name, len(times) + 1)
                stamp = getattr(getattr(message, "header", None), "stamp", None)
                measured = 0 if stamp is None else stamp.sec * 1_000_000_000 + stamp.nanosec
                start = bag.start_time if start is None else start
                times.append(((measured or recorded) - start) * 1e-9)
                values.append(_value(message, field))
            return ChannelSamples(values=np.array(values), times=np.array(times))

        yield ChannelFile(names=list(fields), read=read, own_clocks=True)


def _number_field_names(value: Any, prefix: str = "", depth: int = 0) -> Iterator[str]:
    """Names of the numbers in a message."""
    if isinstance(value, bool | int | float | np.number):
        yield prefix
    elif isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= 64:
        yield from (f"{prefix}.{i}" for i in range(value.size))
    elif depth < _DEEPEST and hasattr(value, "__dataclass_fields__"):
        for name in value.__dataclass_fields__:
            if not name.startswith("__"):
                inner = f"{prefix}.{name}" if prefix else name
                yield from _number_field_names(getattr(value, name), inner, depth + 1)


def _value(message: Any, field: str) -> float:
    for part in field.split("."):
        if isinstance(message, np.ndarray):
            message = message[int(part)] if int(part) < message.size else np.nan
        else:
            message = getattr(message, part)
    return float(message)
