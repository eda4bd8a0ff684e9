"""HDF5, and MATLAB 7.3 files, which are HDF5, by h5py."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from identification.reading.channels import ChannelFile, Samples
from identification.reading.formats.opening import library, require_size
from identification.reading.rigfile import DECLARABLE
from identification.reading.signal_map import SignalMap
from symbolic import InvalidInputError

MATLAB_NAMES = {"t": "time", "psi": "Psi", "M_z": "Mz", "F_N": "Fz"}
"""Variable of each column in the published MATLAB files."""
_MOST_OBJECTS = 10_000
_MOST_DEFLATED = 1032
"""Ratio to which deflate can compress."""
_UNTESTED = 100_000_000
"""A chunk that cannot unpack to so much more than it should need not be tried [bytes]."""


@contextmanager
def open_hdf5(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Datasets as `group/dataset`; scalars a, e, k, mu, J_A, b_t are values of the rig."""
    h5py = library("h5py", "hdf5", path)
    with h5py.File(path, "r") as file:
        datasets = dict(_numeric(h5py, file))

        def read(name: str) -> Samples:
            dataset = datasets[name]
            require_size(path, name, dataset.size)
            require_size(path, f"a chunk of {name}", prod(dataset.chunks or ()))
            _require_unpacked(path, name, dataset)
            unit = dataset.attrs.get("unit", dataset.attrs.get("units", ""))
            text = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
            return Samples(values=_row(np.asarray(dataset[()])), unit=text)

        declared = {
            name: float(np.ravel(datasets[name][()])[0])
            for name in DECLARABLE
            if name in datasets and datasets[name].size == 1
        }
        yield ChannelFile(names=list(datasets), read=read, declared=declared, aliases=MATLAB_NAMES)


def _numeric(h5py: Any, file: Any) -> Iterator[tuple[str, Any]]:
    """Datasets of plain numbers inside the file; links that leave it are not followed."""
    names: list[str] = []

    def collect(name: str) -> bool | None:
        names.append(name)
        return True if len(names) >= _MOST_OBJECTS else None

    file.visit(collect)
    for name in names:
        entry = file.get(name)
        if isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiu" and not entry.external:
            yield name, entry


def _require_unpacked(path: Path, name: str, dataset: Any) -> None:
    """Refuses compressed chunks that unpack to more than a chunk holds, which HDF5 does before it looks.

    Raises:
        InvalidInputError: there is one.
    """
    if dataset.compression != "gzip" or dataset.fletcher32:
        return
    size = prod(dataset.chunks) * dataset.dtype.itemsize
    for i in range(dataset.id.get_num_chunks()):
        stored = dataset.id.get_chunk_info(i)
        if stored.size * _MOST_DEFLATED > size + _UNTESTED and not stored.filter_mask:
            _, packed = dataset.id.read_direct_chunk(stored.chunk_offset)
            if len(zlib.decompressobj().decompress(packed, size + 1)) > size:
                raise InvalidInputError(f"{path}: a chunk of {name} unpacks to more than it holds")


def _row(values: Any) -> Any:
    """MATLAB's vectors have two dimensions, one of them 1."""
    return values.ravel() if values.size == max(values.shape, default=0) else values
