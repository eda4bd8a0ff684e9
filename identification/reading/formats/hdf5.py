"""HDF5, and MATLAB 7.3 files, which are HDF5, by h5py."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats.matlab_5_file import VARIABLES
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.rigfile import DECLARABLE
from identification.reading.signal_map import SignalMap
from identification.reading.units import unit_attribute
from symbolic import InvalidInputError

_MAX_OBJECTS = 10_000
_MAX_DEFLATE_RATIO = 1032
"""Largest compression ratio of deflate."""
_SIZES = {
    **dict.fromkeys(("_FillValue", "missing_value", "scale_factor", "add_offset"), 1),
    **dict.fromkeys(("valid_min", "valid_max"), 1),
    "valid_range": 2,
}
"""Attributes that say what numbers mean, and how many each holds."""
_UNTESTED = 100_000_000
"""Excess of a chunk's unpacked size up to which it need not be tried [bytes]."""


@contextmanager
def open_hdf5(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Datasets as `group/dataset`; scalars a, e, k, mu, J_A, b_t are values of the rig."""
    h5py = import_library("h5py", "hdf5", path)
    with h5py.File(path, "r") as file:
        datasets = dict(_numeric_datasets(h5py, file))

        def read(name: str) -> ChannelSamples:
            dataset = datasets[name]
            require_allowed_size(path, name, dataset.size)
            require_allowed_size(path, f"a chunk of {name}", prod(dataset.chunks or ()))
            _require_bounded_chunks(path, name, dataset)
            unit = next(iter(np.ravel(unit_attribute(dataset.attrs))), "")
            text = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
            values = _decode_cf_packing(path, name, dataset)
            # MATLAB's vectors have two dimensions, one of them 1.
            is_row = values.size == max(values.shape, default=0)
            return ChannelSamples(values=values.ravel() if is_row else values, unit=text)

        declared = {
            name: float(_decode_cf_packing(path, name, datasets[name]).ravel()[0])
            for name in DECLARABLE
            if name in datasets and datasets[name].size == 1
        }
        aliases = {column: (column, name) for column, name in VARIABLES.items()}
        yield ChannelFile(names=list(datasets), read=read, declared=declared, aliases=aliases)


def _numeric_datasets(h5py: Any, file: Any) -> Iterator[tuple[str, Any]]:
    """Datasets of plain numbers inside the file; links that leave it are not followed."""
    names: list[str] = []

    def collect(name: str) -> bool | None:
        names.append(name)
        return True if len(names) >= _MAX_OBJECTS else None

    file.visit(collect)
    for name in names:
        entry = file.get(name)
        if isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiu" and not entry.external:
            yield name, entry


def _require_bounded_chunks(path: Path, name: str, dataset: Any) -> None:
    """Refuses chunks that unpack to more than a chunk holds, which HDF5 does before it looks."""
    if dataset.compression != "gzip" or dataset.fletcher32:
        return
    size = prod(dataset.chunks) * dataset.dtype.itemsize
    for i in range(dataset.id.get_num_chunks()):
        stored = dataset.id.get_chunk_info(i)
        if stored.size * _MAX_DEFLATE_RATIO > size + _UNTESTED and not stored.filter_mask:
            _, packed = dataset.id.read_direct_chunk(stored.chunk_offset)
            if len(zlib.decompressobj().decompress(packed, size + 1)) > size:
                raise InvalidInputError(f"{path}: a chunk of {name} unpacks to more than it holds")


def _decode_cf_packing(path: Path, name: str, dataset: Any) -> Any:
    """Numbers by the CF Metadata Conventions 1.11, sections 2.5.1 and 8.1; NaN where one is missing."""
    values = np.asarray(dataset[()])
    attributes = {}
    for key, size in _SIZES.items():
        if key not in dataset.attrs:
            continue
        given = np.ravel(dataset.attrs[key])
        if given.dtype.kind in "fiu" and (given.size == size or key == "missing_value"):
            attributes[key] = given
        elif not key.startswith("valid_"):
            raise InvalidInputError(f"{path}: {key} of {name} must be a number")
    missing = np.zeros(values.shape, dtype=bool)
    for key in attributes.keys() & {"_FillValue", "missing_value"}:
        with np.errstate(over="ignore"):
            # A double such as 1e20 marks what is missing among floats as their nearest.
            same = values.dtype.kind == "f"
            mark = attributes[key].astype(values.dtype) if same else attributes[key]
        missing |= np.isin(values, mark)
    if not attributes:
        return values
    with np.errstate(invalid="ignore"):
        scaled = values * attributes.get("scale_factor", 1.0) + attributes.get("add_offset", 0.0)
        for key in attributes.keys() & {"valid_min", "valid_max", "valid_range"}:
            # Of packed integers the range is one of these, unless it is no integer.
            low, high = attributes[key][0], attributes[key][-1]
            inside = values if attributes[key].dtype.kind in "iu" else scaled
            missing |= (inside < low) & (key != "valid_max") | (inside > high) & (key != "valid_min")
        return np.where(missing, np.nan, scaled.astype(np.float64))
