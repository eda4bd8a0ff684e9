import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from identification import read_recording
from identification.reading.formats.matlab_5_file import DamagedFileError, read_arrays
from tests.identification.reading.logs import require_less_memory
from tests.refusal import refused


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
    arrays = read_arrays(saved({"text": "abc", "z": 1 + 2j, "struct": {"x": 1.0}, "number": 3.0}))

    assert [name for name, values in arrays.items() if values is None] == ["text", "z", "struct"]
    assert arrays["number"] == 3.0


HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI"


def element(kind: int, data: bytes) -> bytes:
    return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8 if kind != 15 else 0)


def array(shape: bytes, values: bytes, *, shape_type: int = 5, values_type: int = 9) -> bytes:
    flags = element(6, struct.pack(">II", 6, 0))
    name = struct.pack(">HH", 4, 1) + b"time"
    return element(14, flags + element(shape_type, shape) + name + element(values_type, values))


def test_big_endian() -> None:
    content = HEADER + array(struct.pack(">ii", 1, 2), struct.pack(">dd", 1, -2))
    time = read_arrays(content)["time"]

    assert time is not None
    assert time.tolist() == [[1, -2]]


@pytest.mark.parametrize(
    "element_bytes",
    [
        array(struct.pack(">dd", np.nan, 1), bytes(8), shape_type=9),
        array(struct.pack(">dd", np.inf, 1), bytes(8), shape_type=9),
        array(struct.pack(">ii", -1, -1), bytes(8)),
        array(struct.pack(">qq", 0, 2**62), b"", shape_type=12),
        array(b"", bytes(8)),
        element(
            15, zlib.compress(element(15, zlib.compress(array(struct.pack(">ii", 1, 1), bytes(8)))))
        ),
        element(15, zlib.compress(array(struct.pack(">ii", 1, 1), bytes(8)) + b"more")),
    ],
    ids=["NaN", "infinite", "negative", "0 x 2^62", "none", "compressed twice", "more than declared"],
)
def test_shapes_that_are_none(element_bytes: bytes) -> None:
    with pytest.raises(DamagedFileError):
        read_arrays(HEADER + element_bytes)


@pytest.mark.parametrize(
    "element_bytes",
    [
        array(struct.pack(">65i", *[1] * 65), bytes(8)),
        array(struct.pack(">3i", 0, 2**31 - 1, 2**31 - 1), b""),
    ],
    ids=["65 dimensions", "0 x 2^31 x 2^31"],
)
def test_shapes_beyond_any_recording(element_bytes: bytes) -> None:
    message = refused(read_arrays, HEADER + element_bytes)
    assert message.endswith("allowed: up to 32 dimensions, 10000000 numbers")


DECLARES_MUCH = struct.pack(">II", 14, 2**31) + array(struct.pack(">ii", 1, 2**28), b"")[8:]
DECLARES_LITTLE = array(struct.pack(">ii", 1, 1), bytes(8))


@pytest.mark.parametrize(
    ("begin", "fault"),
    [
        (DECLARES_MUCH, "time takes 2147483648 bytes; allowed: up to 10000000 numbers"),
        (DECLARES_LITTLE, "time does not decompress to the"),
    ],
)
def test_a_bomb_takes_no_memory(tmp_path: Path, begin: bytes, fault: str) -> None:
    # Zeros shrink a thousandfold: what an element declares and what is in it count before it is read.
    packer = zlib.compressobj(9)
    zeros = bytes(1_000_000)
    bomb = packer.compress(begin) + b"".join(packer.compress(zeros) for _ in range(150))
    bomb += packer.flush()
    path = tmp_path / "bomb.mat"
    path.write_bytes(HEADER + element(15, bomb))
    with require_less_memory(5_000_000):
        message = refused(read_recording, path)

    assert len(bomb) < 200_000
    assert fault in message


def test_what_is_not_wanted_is_not_decompressed(tmp_path: Path) -> None:
    t = np.arange(20) * 0.01
    columns = {"time": t, "Psi": t, "Mz": t, "Fz": t + 400, "a": 0.04, "e": 0.0, "k": 2e6}
    path = tmp_path / "film.mat"
    path.write_bytes(saved({"film": np.zeros((2000, 2000)), **columns}, compressed=True))
    with require_less_memory(5_000_000):
        recording = read_recording(path)

    assert recording.t.size == 20


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
