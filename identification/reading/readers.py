"""Readers of recordings by the suffix of the file's name; a user may add to them."""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

from identification.reading.checked_file_reading import require_readable
from identification.reading.checked_sample_table import Table, require_valid_samples
from identification.reading.common_clock_and_units import apply_map
from identification.reading.formats.can import open_can
from identification.reading.formats.csvfile import read_csv
from identification.reading.formats.hdf5 import open_hdf5
from identification.reading.formats.matlab_5_file import is_hdf5, read_mat
from identification.reading.formats.mdf import open_mdf
from identification.reading.formats.optional_libraries import read_by_optional_library
from identification.reading.formats.parquet import open_parquet
from identification.reading.formats.ros import open_ros
from identification.reading.formats.tdms import open_tdms
from identification.reading.signal_map import NO_MAP, SignalMap
from symbolic import InvalidInputError

CAN_LOGS = (".blf", ".asc", ".log")
ROS_2_BAGS = (".db3", ".mcap")
_LOG = logging.getLogger(__name__)


class Reader(Protocol):
    """A format of recordings."""

    def __call__(self, path: Path, needed: Sequence[str], /) -> Table:
        """Read the table of a file.

        Args:
            path: the file.
            needed: names of columns without which the file is of no use.

        Raises:
            InvalidInputError: the file cannot be read as such a table, or lacks a column. Faults of
                single samples are in the result.
        """
        ...


def _read_matlab(path: Path, needed: Sequence[str], signals: SignalMap = NO_MAP) -> Table:
    """MATLAB 5 by our own parser, MATLAB 7.3 by that of HDF5."""
    if not is_hdf5(path):
        return read_mat(path, needed, signals)
    if find_spec("h5py") is None:
        raise InvalidInputError(
            f"{path}: is a MATLAB 7.3 (HDF5) file; save it as MATLAB 5, with save(..., '-v7'), or"
            " pip install 'brushgrip[hdf5]'"
        )
    return read_by_optional_library(open_hdf5, path, needed, signals)


_FORMATS = {
    "can": (open_can, CAN_LOGS),
    "hdf5": (open_hdf5, (".h5", ".hdf5")),
    "mdf": (open_mdf, (".mf4", ".mdf")),
    "parquet": (open_parquet, (".parquet",)),
    "ros": (open_ros, (".bag", *ROS_2_BAGS)),
    "tdms": (open_tdms, (".tdms",)),
}
"""Readers and suffixes of each format, by the package's extra that installs the library."""
PLAIN = (".csv", ".txt", ".tsv")
READERS: Mapping[str, Reader] = MappingProxyType(
    {
        ".mat": _read_matlab,
        **dict.fromkeys(PLAIN, read_csv),
        **{
            suffix: partial(read_by_optional_library, opener)
            for opener, suffixes in _FORMATS.values()
            for suffix in suffixes
        },
    }
)
"""Readers by suffix in lower case; `{**READERS, ".log": reader}` adds or replaces one."""


def read_table(
    path: Path, needed: Sequence[str], readers: Mapping[str, Reader], signals: SignalMap = NO_MAP
) -> Table:
    """The table by the reader of the file's suffix, CSV without one, after `require_valid_samples`."""
    reader: Callable[..., Table] | None = readers.get(path.suffix.lower() or ".csv")
    if reader is None:
        require_readable(path)  # A missing file has another remedy than an unknown format.
        extras = [f"pip install 'brushgrip[{e}]' for {', '.join(s)}" for e, (_, s) in _FORMATS.items()]
        others = {*readers} - {suffix for _, suffixes in _FORMATS.values() for suffix in suffixes}
        raise InvalidInputError(
            f"{path}: unknown format {path.suffix!r}; known are {', '.join(sorted(others))};"
            f" {'; '.join(extras)}"
        )
    if reader in READERS.values():  # These find the channels of a map themselves.
        table = reader(path, needed, signals)
    else:
        table = reader(path, needed)
        table = apply_map(table, needed, signals) if signals else table
    require_valid_samples(table, needed)
    for remark in table.remarks:
        _LOG.warning("brushgrip: %s: %s", path, remark)
    return table


def companion_files(paths: Iterable[Path], signals: SignalMap) -> list[Path]:
    """Files that are read along with recordings: the database of CAN logs, the rest of a ROS 2 bag."""
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
