import io
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from identification.reading.matfile import DamagedFileError, read_arrays


def saved(variables: dict[str, Any], *, compressed: bool = False) -> bytes:
    stream = io.BytesIO()
    savemat(stream, variables, do_compression=compressed)
    return stream.getvalue()


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize(
    "values",
    [
        np.random.default_rng(0).normal(size=(1, 300)),
        np.arange(6.0).reshape(2, 3),
        np.array([1.5, np.nan, np.inf], np.float32),
        np.arange(5, dtype=np.int8),
        np.arange(3, dtype=np.uint16),
        np.array([[2438000]], np.int32),
        np.array([[2**40]], np.uint64),
        np.zeros((0, 0)),
        np.arange(24).reshape(2, 3, 4),
    ],
)
def test_agrees_with_scipy(values: np.ndarray, compressed: bool) -> None:
    content = saved({"before": 1.0, "values": values, "z": 2}, compressed=compressed)
    read = read_arrays(content)["values"]

    assert read is not None
    assert read.dtype == np.float64
    np.testing.assert_array_equal(read, loadmat(io.BytesIO(content))["values"])


def test_other_kinds_are_none() -> None:
    content = saved({"text": "abc", "z": 1 + 2j, "struct": {"x": 1.0}, "number": 3.0})
    arrays = read_arrays(content)

    assert [name for name, values in arrays.items() if values is None] == ["text", "z", "struct"]
    assert arrays["number"] == 3.0


def test_big_endian() -> None:
    def element(kind: int, data: bytes) -> bytes:
        return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8)

    name = struct.pack(">HH", 1, 1) + b"k\0\0\0"
    flags, shape = struct.pack(">II", 6, 0), struct.pack(">ii", 1, 2)
    array = element(6, flags) + element(5, shape) + name + element(9, struct.pack(">dd", 1, -2))
    content = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI" + element(14, array)
    k = read_arrays(content)["k"]

    assert k is not None
    assert k.tolist() == [[1, -2]]


@pytest.mark.measured
def test_published_files(measured_dir: Path) -> None:
    for path in sorted(measured_dir.glob("*.mat")):
        arrays = read_arrays(path.read_bytes())
        for name in ("time", "Psi", "Mz", "Fz", "a", "e", "k"):
            np.testing.assert_array_equal(arrays[name], loadmat(path, variable_names=[name])[name])


@pytest.mark.parametrize("compressed", [False, True])
def test_cut_anywhere(compressed: bool) -> None:
    content = saved({"a": np.arange(7.0)}, compressed=compressed)
    for kept in (*range(100, 128), *range(129, len(content))):
        with pytest.raises(DamagedFileError):
            read_arrays(content[:kept])


@pytest.mark.parametrize("compressed", [False, True])
def test_damaged_anywhere(compressed: bool) -> None:
    # Any byte at any value: an error or other numbers, but nothing else.
    content = saved({"a": np.arange(4.0), "text": "abc", "k": 3}, compressed=compressed)
    random = np.random.default_rng(0)
    for position in range(126, len(content)):
        for value in random.integers(0, 256, 8):
            damaged = bytearray(content)
            damaged[position] = value
            try:
                read_arrays(bytes(damaged))
            except DamagedFileError:
                continue
