"""Recordings in MATLAB 5 files, as published: time, Psi, Mz, Fz and scalars such as a, e, k."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from identification.reading.files import read_bytes
from identification.reading.matlab5 import DamagedFileError, read_arrays
from identification.reading.rigfile import DECLARABLE
from identification.reading.table import Array, Table
from symbolic import InvalidInputError

_VARIABLES = {"t": "time", "psi": "Psi", "M_z": "Mz", "F_N": "Fz"}


def read_mat(path: Path, needed: Sequence[str]) -> Table:
    """Reads the table; other variables in the file are passed over.

    Args:
        path: the file.
        needed: names of columns that the file must hold, `t` for its variable `time` and so on.

    Raises:
        InvalidInputError: not a MATLAB 5 file, a variable is missing, of another length or not of
            real numbers.
    """
    content = _load(path)
    missing = [_VARIABLES[name] for name in needed if _VARIABLES[name] not in content]
    if missing:
        raise InvalidInputError(
            f"{path}: variable{'s' * (len(missing) > 1)} {', '.join(missing)} missing; "
            f"expected {', '.join(_VARIABLES[name] for name in needed)}"
        )
    columns = {
        name: _vector(path, variable, content[variable])
        for name, variable in _VARIABLES.items()
        if variable in content
    }
    for name, values in columns.items():
        if values.size != columns["t"].size:
            raise InvalidInputError(
                f"{path}: {_VARIABLES[name]} holds {values.size} samples, time holds "
                f"{columns['t'].size}; equal numbers are needed"
            )
    declared = {name: _scalar(path, name, content[name]) for name in DECLARABLE if name in content}
    return Table(
        path=path,
        columns=columns,
        declared=declared,
        faults=(),
        place=lambda of: f"sample {of + 1}" if isinstance(of, int) else f"scalar {of}",
    )


def _load(path: Path) -> Mapping[str, Array | None]:
    content = read_bytes(path)
    if not content:
        raise InvalidInputError(f"{path}: is empty")
    if content.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InvalidInputError(
            f"{path}: is a MATLAB 7.3 (HDF5) file; save it as MATLAB 5, with save(..., '-v7')"
        )
    if not content.startswith(b"MATLAB 5.0"):
        raise InvalidInputError(
            f"{path}: is not a MATLAB 5 file; save it with save(..., '-v7'), or as CSV"
        )
    try:
        return read_arrays(content)
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
