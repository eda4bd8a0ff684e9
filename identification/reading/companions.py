"""Files that are read along with a recording, though nobody named them."""

from collections.abc import Iterable
from pathlib import Path

from identification.reading.signal_map import SignalMap

CAN_LOGS = (".blf", ".asc", ".log")
ROS_2_BAGS = (".db3", ".mcap")


def read_along(paths: Iterable[Path], signals: SignalMap) -> list[Path]:
    """The database of CAN logs, named by the map or beside them, and the other files of a ROS 2 bag.

    Args:
        paths: recordings.
        signals: map of channels.
    """
    found = dict.fromkeys([] if signals.dbc is None else [signals.dbc])
    for path in paths:
        suffix = path.suffix.lower()
        if suffix in CAN_LOGS and signals.dbc is None:
            found |= dict.fromkeys(sorted(path.parent.glob("*.dbc")))
        elif suffix in ROS_2_BAGS:
            bag = [p for s in ROS_2_BAGS for p in sorted(path.parent.glob(f"*{s}")) if p != path]
            found |= dict.fromkeys([path.parent / "metadata.yaml", *bag])
        elif suffix == ".tdms":
            found |= dict.fromkeys([path.with_name(f"{path.name}_index")])
    return [path for path in found if path.is_file()]
