"""Readers of recordings by the suffix of the file's name; a user may add to them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Protocol, runtime_checkable

from identification.reading.channels import remapped
from identification.reading.csvfile import read_csv
from identification.reading.files import require_readable
from identification.reading.formats.can import open_can
from identification.reading.formats.hdf5 import open_hdf5
from identification.reading.formats.mdf import open_mdf
from identification.reading.formats.opening import EXTRAS, FormatReader
from identification.reading.formats.parquet import open_parquet
from identification.reading.formats.ros import open_ros
from identification.reading.formats.tdms import open_tdms
from identification.reading.matfile import is_hdf5, read_mat
from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.table import Table, check
from symbolic import InvalidInputError


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


@runtime_checkable
class MappingReader(Protocol):
    """A format whose reader finds the channels of a map itself."""

    def read_mapped(self, path: Path, needed: Sequence[str], signals: SignalMap, /) -> Table:
        """Read the table of a file by a map; see `Reader`."""
        ...


@dataclass(frozen=True)
class Mapped:
    """A reader out of a function that takes the map as its third argument."""

    read: Callable[[Path, Sequence[str], SignalMap], Table]

    def __call__(self, path: Path, needed: Sequence[str], /) -> Table:
        """Read the table of a file whose channels have the names of the columns."""
        return self.read(path, needed, NO_MAP)

    def read_mapped(self, path: Path, needed: Sequence[str], signals: SignalMap, /) -> Table:
        """Read the table of a file by a map."""
        return self.read(path, needed, signals)


_OPENERS = {
    "can": open_can, "hdf5": open_hdf5, "mdf": open_mdf, "parquet": open_parquet, "ros": open_ros,
    "tdms": open_tdms,
}  # fmt: skip
_FORMATS = {extra: FormatReader(extra=extra, opener=opener) for extra, opener in _OPENERS.items()}


def _read_matlab(path: Path, needed: Sequence[str], signals: SignalMap) -> Table:
    """MATLAB 5 by our own parser, MATLAB 7.3 by that of HDF5."""
    if not is_hdf5(path):
        return read_mat(path, needed, signals)
    if find_spec("h5py") is None:
        raise InvalidInputError(
            f"{path}: is a MATLAB 7.3 (HDF5) file; save it as MATLAB 5, with save(..., '-v7'), or"
            " pip install 'brushgrip[hdf5]'"
        )
    return _FORMATS["hdf5"](path, needed, signals)


PLAIN = (".mat", ".csv", ".txt", ".tsv")
"""Suffixes that need no other package."""
READERS: Mapping[str, Reader] = MappingProxyType(
    {
        ".mat": Mapped(_read_matlab),
        **dict.fromkeys(PLAIN[1:], Mapped(read_csv)),
        **{suffix: Mapped(_FORMATS[extra]) for suffix, extra in EXTRAS.items()},
    }
)
"""Readers by suffix in lower case; `{**READERS, ".log": reader}` adds or replaces one."""


def read_table(
    path: Path, needed: Sequence[str], readers: Mapping[str, Reader], signals: SignalMap = NO_MAP
) -> Table:
    """Read a file by the reader of its suffix and check its samples; without a suffix it is CSV.

    Args:
        path: the file.
        needed: names of columns of which not every sample may be missing.
        readers: by suffix in lower case.
        signals: where columns come from.

    Raises:
        InvalidInputError: there is no such file, no reader of its suffix, or something in it is wrong.
    """
    reader = readers.get(path.suffix.lower() or ".csv")
    if reader is None:
        require_readable(path)  # A missing file has another remedy than an unknown format.
        raise InvalidInputError(f"{path}: unknown format {path.suffix!r}; {_known(readers)}")
    if isinstance(reader, MappingReader):
        table = reader.read_mapped(path, needed, signals)
    else:
        table = reader(path, needed)
        table = remapped(table, needed, signals) if signals else table
    check(table, needed)
    return table


def _known(readers: Mapping[str, Reader]) -> str:
    """The formats that can be read, and what to install for those that need more."""
    extras = {
        f"pip install 'brushgrip[{extra}]' for {', '.join(s for s, e in EXTRAS.items() if e == extra)}"
        for extra in EXTRAS.values()
    }
    plain = sorted(suffix for suffix in readers if suffix not in EXTRAS)
    return f"known are {', '.join(plain)}; {'; '.join(sorted(extras))}"
