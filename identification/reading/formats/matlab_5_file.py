"""Recordings in MATLAB 5 files, as published: time, Psi, Mz, Fz and scalars such as a, e, k.

The parser follows The MathWorks, "MAT-File Format", chapter "Level 5 MAT-File Format". It reads real
arrays alone; `scipy.io.loadmat` reads everything, but a damaged file can end the process there.
"""

import struct
import zlib
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.checked_file_reading import read_bytes, require_readable
from identification.reading.checked_sample_table import COLUMNS, MAX_SAMPLES, Table
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.rigfile import DECLARABLE
from identification.reading.signal_map import NO_MAP, SignalMap
from symbolic import TOLERATED, InvalidInputError
from symbolic.float_array_type import Array
from symbolic.tables.toml_and_json_parsing import prefix_errors

VARIABLES = {"t": "time", "psi": "Psi", "M_z": "Mz", "F_N": "Fz"}
"""Variable of each column, before that of the column's own name."""
HALF_LENGTH_TOLERANCE = 0.0025
"""Half-lengths in the published files are whole multiples of 5 mm [m].

A scalar `a_tolerance` in a file overrides it."""
_SCALARS = (*DECLARABLE, *(f"{name}_tolerance" for name in TOLERATED))
"""Values of the rig, and how far off these may be."""
_HDF5 = (b"MATLAB 7.3", b"\x89HDF")
_HEADER_BYTES = 128
_NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"
}  # fmt: skip
_INT32, _MATRIX, _COMPRESSED = 5, 14, 15
_NUMERIC_CLASSES = range(6, 16)
_OPAQUE_CLASS = 17
_COMPLEX_FLAG = 0x0800
_MAX_DIMENSIONS, _MAX_VARIABLES = 32, 10_000
_MAX_HEAD_SIZE = 1024
"""Largest size of flags, shape and name, in front of the values [bytes]."""
_MAX_ARRAY_SIZE = 8 * MAX_SAMPLES + _MAX_HEAD_SIZE


def read_mat(path: Path, needed: Sequence[str], signals: SignalMap = NO_MAP) -> Table:
    """Read the table; other variables in the file are ignored."""
    content = _load(path, {*_SCALARS, *VARIABLES.values()})
    scalars = {name: _scalar(path, name, content[name]) for name in _SCALARS if name in content}
    file = ChannelFile(
        names=list(content),
        read=lambda name: ChannelSamples(values=_vector(path, name, _load(path, {name})[name])),
        declared={name: value for name, value in scalars.items() if name in DECLARABLE},
        aliases={c: (VARIABLES[c], c) if c in VARIABLES else () for c in COLUMNS},
    )
    own = {name: scalars[f"{name}_tolerance"] for name in TOLERATED if f"{name}_tolerance" in scalars}
    published = {"a": HALF_LENGTH_TOLERANCE} if "a" in content else {}
    return replace(table_from_channels(path, file, needed, signals), tolerances=published | own)


def is_hdf5(path: Path) -> bool:
    """Whether a MATLAB file is one of version 7.3."""
    require_readable(path)
    with path.open("rb") as file:
        return file.read(len(_HDF5[0])).startswith(_HDF5)


def _load(path: Path, wanted: Container[str]) -> Mapping[str, Array | None]:
    content = read_bytes(path)
    if not content:
        raise InvalidInputError(f"{path}: is empty")
    if not content.startswith(b"MATLAB 5.0"):
        raise InvalidInputError(
            f"{path}: is not a MATLAB 5 file; save it with save(..., '-v7'), or as CSV"
        )
    try:
        with prefix_errors(path):
            return read_arrays(content, wanted)
    except DamagedFileError as error:
        raise InvalidInputError(
            f"{path}: is damaged, it cannot be read as a MATLAB 5 file ({error}); copy or save it again"
        ) from None


def _vector(path: Path, variable: str, value: Array | None) -> Array:
    if value is None:
        raise InvalidInputError(f"{path}: {variable} must hold real numbers")
    if value.size == 0 or value.size != max(value.shape):
        shape = "x".join(str(length) for length in value.shape)
        raise InvalidInputError(f"{path}: {variable} must be one row or column, it is {shape}")
    return value.ravel()


def _scalar(path: Path, variable: str, value: Array | None) -> float:
    vector = _vector(path, variable, value)
    if vector.size != 1:
        raise InvalidInputError(f"{path}: {variable} must be one number, it holds {vector.size}")
    return float(vector[0])


class DamagedFileError(ValueError):
    """The content contradicts the format."""


class _Element(NamedTuple):
    kind: int
    data: memoryview


def read_arrays(
    content: bytes, wanted: Container[str] | None = None
) -> dict[str, NDArray[np.float64] | None]:
    """Variables by name, in their shape; None for what is no array of real numbers, or is not wanted.

    Raises:
        DamagedFileError: the content is not that of a whole MATLAB 5 file.
        InvalidInputError: a wanted variable is larger than a recording may be.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[_HEADER_BYTES - 2 : _HEADER_BYTES])
    if order is None:
        raise DamagedFileError("no mark of the byte order")
    arrays: dict[str, NDArray[np.float64] | None] = {}
    try:
        for element in _elements(memoryview(content)[_HEADER_BYTES:], order):
            name, values = _variable(element, order, wanted)
            arrays[name] = values
            if len(arrays) > _MAX_VARIABLES:
                raise InvalidInputError(f"holds more than {_MAX_VARIABLES} variables")
    except (struct.error, zlib.error, UnicodeDecodeError, KeyError) as error:
        raise DamagedFileError(str(error)) from error
    return arrays


def _variable(
    element: _Element, order: str, wanted: Container[str] | None
) -> tuple[str, NDArray[np.float64] | None]:
    """A variable by name; decompressed as far as its name, and only a wanted one to its end."""
    if element.kind == _MATRIX:
        name, shape, parts = _read_array_header(element.data, order)
        if shape is None or not (wanted is None or name in wanted):
            return name, None
        return name, _values(name, shape, _next_element(parts), order)
    if element.kind != _COMPRESSED:
        raise DamagedFileError(f"element of type {element.kind} outside an array")
    inflater = zlib.decompressobj()
    begin = inflater.decompress(element.data, _MAX_HEAD_SIZE)
    kind, size = struct.unpack_from(order + "II", begin)
    if kind != _MATRIX:
        raise DamagedFileError(f"a compressed element of type {kind}, no array")
    name, shape, _ = _read_array_header(memoryview(begin)[8:], order)
    if wanted is not None and (shape is None or name not in wanted):
        return name, None
    if size > _MAX_ARRAY_SIZE:
        raise InvalidInputError(f"{name} takes {size} bytes; allowed: up to {MAX_SAMPLES} numbers")
    # One byte more than declared tells whether more is in it.
    whole = begin + inflater.decompress(inflater.unconsumed_tail, max(1, size + 9 - len(begin)))
    if not inflater.eof or len(whole) != size + 8:
        raise DamagedFileError(f"{name} does not decompress to the {size} bytes that it declares")
    return _variable(_Element(_MATRIX, memoryview(whole)[8:]), order, wanted)


def _read_array_header(
    content: memoryview, order: str
) -> tuple[str, tuple[int, ...] | None, Iterator[_Element]]:
    """Name, shape (None for what is not an array of real numbers), and the parts that follow."""
    parts = _elements(content, order)
    (flag,) = struct.unpack_from(order + "I", _next_element(parts).data)
    kind = flag & 0xFF
    if kind not in range(1, _OPAQUE_CLASS + 1):
        raise DamagedFileError(f"array of class {kind}")
    if kind == _OPAQUE_CLASS:  # its name comes at once
        return _text(_next_element(parts)), None, parts
    lengths = _next_element(parts)
    if lengths.kind != _INT32:
        raise DamagedFileError(f"a shape of type {lengths.kind}")
    shape = tuple(_numbers(lengths, order).tolist())
    name = _text(_next_element(parts))
    if kind not in _NUMERIC_CLASSES or flag & _COMPLEX_FLAG:
        return name, None, parts
    return name, shape, parts


def _values(name: str, shape: tuple[int, ...], part: _Element, order: str) -> NDArray[np.float64]:
    values = _numbers(part, order)
    if min(shape, default=-1) < 0 or prod(shape) != values.size:
        raise DamagedFileError(f"{name} holds {values.size} numbers, its shape is {shape}")
    if len(shape) > _MAX_DIMENSIONS or prod(max(1, length) for length in shape) > MAX_SAMPLES:
        raise InvalidInputError(
            f"{name} has {len(shape)} dimensions, {values.size} numbers; allowed: up to"
            f" {_MAX_DIMENSIONS} dimensions, {MAX_SAMPLES} numbers"
        )
    with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN
        return values.astype(np.float64).reshape(shape, order="F")


def _next_element(parts: Iterator[_Element]) -> _Element:
    part = next(parts, None)
    if part is None:
        raise DamagedFileError("an array that ends early")
    return part


def _text(element: _Element) -> str:
    return bytes(element.data).decode("ascii")


def _numbers(element: _Element, order: str) -> NDArray[np.generic]:
    dtype = np.dtype(order + _NUMBERS[element.kind])
    if len(element.data) % dtype.itemsize:
        raise DamagedFileError("a fraction of a number")
    return np.frombuffer(element.data, dtype)


def _elements(content: memoryview, order: str) -> Iterator[_Element]:
    """The elements in turn: a tag of 8 bytes, then data, padded to 8 unless compressed."""
    at = 0
    while at < len(content):
        kind, size = struct.unpack_from(order + "II", content, at)
        start, end = at + 8, at + 8 + size
        if kind >> 16:  # a small element: size and type share four bytes, data in the other four
            kind, size = kind & 0xFFFF, kind >> 16
            start, end = at + 4, at + 4 + size
            if size > 4:
                raise DamagedFileError("a small element that is not small")
            at += 8
        else:
            at = end if kind == _COMPRESSED else end + -size % 8
        if end > len(content):
            raise DamagedFileError("an element that goes on beyond the end")
        yield _Element(kind, content[start:end])
