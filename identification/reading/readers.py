"""Readers of recordings by the suffix of the file's name; a user may add to them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

from identification.reading.csvfile import read_csv
from identification.reading.files import read_bytes
from identification.reading.matfile import read_mat
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


READERS: Mapping[str, Reader] = MappingProxyType({".mat": read_mat, ".csv": read_csv, ".txt": read_csv})
"""Readers by suffix in lower case; `{**READERS, ".log": reader}` adds one."""


def read_table(path: Path, needed: Sequence[str], readers: Mapping[str, Reader]) -> Table:
    """Read a file by the reader of its suffix and check its samples; without a suffix it is CSV.

    Args:
        path: the file.
        needed: names of columns of which not every sample may be missing.
        readers: by suffix in lower case.

    Raises:
        InvalidInputError: there is no such file, no reader of its suffix, or something in it is wrong.
    """
    reader = readers.get(path.suffix.lower() or ".csv")
    if reader is None:
        read_bytes(path)  # A missing file has another remedy than an unknown format.
        raise InvalidInputError(
            f"{path}: unknown format {path.suffix!r}; known are {', '.join(sorted(readers))}"
        )
    table = reader(path, needed)
    check(table, needed)
    return table
