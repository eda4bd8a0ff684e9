"""One recording in every format, read back; and the friction that comes out of it."""

import struct
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, fit, read_recording, read_rig
from identification.reading.channels import ChannelFile, Samples
from identification.reading.formats.opening import read_format
from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.table import REQUIRED_COLUMNS
from symbolic import InvalidInputError, Model
from tests.identification.reading.logs import OWN_CLOCK, WRITERS, as_logged, write_can

FOLDER = Path(__file__).parents[3] / "examples" / "recordings"


@pytest.fixture(scope="module")
def original() -> Recording:
    return read_recording(FOLDER / "holdout_c.csv", read_rig(FOLDER / "rig.toml"))


def written(format_: str, folder: Path, original: Recording) -> tuple[Path, str]:
    name, write, signals = WRITERS[format_]
    path = folder / name
    write(path, as_logged(original.t, original.psi, original.M_z, original.F_N))
    return path, signals


@pytest.mark.parametrize("format_", WRITERS)
def test_every_format_gives_the_same_samples(format_: str, tmp_path: Path, original: Recording) -> None:
    path, signals = written(format_, tmp_path, original)
    rig = (original.rig, original.tyre)

    read = read_recording(path, rig, signals=signals)

    start = original.t[0] if "t=" not in signals else 0.0
    np.testing.assert_allclose(read.t, original.t - start, rtol=0, atol=1.1e-6)
    # CAN frames hold single precision.
    np.testing.assert_allclose(read.psi, original.psi, rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(read.M_z, original.M_z, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(read.F_N, original.F_N, rtol=1e-7)
    assert read.rig.a == (0.05 if format_ == "matlab" else original.rig.a)


@pytest.mark.long
@pytest.mark.parametrize("format_", WRITERS)
def test_every_format_gives_the_same_friction(format_: str, tmp_path: Path, original: Recording) -> None:
    path, signals = written(format_, tmp_path, original)
    rig = (original.rig, original.tyre)
    if format_ == "matlab":
        pytest.skip("that file declares a rig of its own")

    frictions = [
        fit(Model(), [recording]).values.own[recording.name]["mu"]
        for recording in (original, read_recording(path, rig, signals=signals))
    ]

    assert frictions[1] == pytest.approx(frictions[0], abs=1e-6)


def test_a_database_is_found_or_asked_for(tmp_path: Path, original: Recording) -> None:
    path, _ = written("blf", tmp_path, original)
    rig = (original.rig, original.tyre)
    (tmp_path / "rig.dbc").rename(tmp_path / "car.db")

    with pytest.raises(InvalidInputError, match=r"run\.blf: 0 databases .* --map dbc=car\.dbc"):
        read_recording(path, rig, signals=OWN_CLOCK)
    read = read_recording(path, rig, signals=f"{OWN_CLOCK},dbc={tmp_path / 'car.db'}")
    assert read.t.size == original.t.size


def test_a_bus_without_the_frame_says_so(tmp_path: Path, original: Recording) -> None:
    path = tmp_path / "run.log"
    columns = as_logged(original.t, original.psi, original.M_z, original.F_N)
    write_can(path, {name: values[:20] for name, values in columns.items()})
    path.write_text(path.read_text().replace(" 123##", " 124##"))

    with pytest.raises(InvalidInputError, match=r"holds no frame Motion \(0x123\)"):
        read_recording(path, (original.rig, original.tyre), signals=OWN_CLOCK)


@pytest.mark.long
@pytest.mark.parametrize("format_", [name for name in WRITERS if name != "german"])
@pytest.mark.parametrize("kept", [0.5, 0.05])
def test_a_file_cut_short_is_no_surprise(
    format_: str, kept: float, tmp_path: Path, original: Recording
) -> None:
    path, signals = written(format_, tmp_path, original)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])

    samples, message = 0, str(path)
    try:
        samples = read_recording(path, (original.rig, original.tyre), signals=signals).t.size
    except InvalidInputError as error:
        message = str(error)

    # What stands before the cut may still be whole.
    assert samples < original.t.size
    assert message.startswith(str(path))
    assert "\n" not in message


@pytest.mark.parametrize("suffix", [".tdms", ".mf4", ".parquet", ".h5", ".blf", ".bag"])
def test_a_library_that_is_not_there_is_named(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, original: Recording
) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr("identification.reading.formats.opening.import_module", missing)
    (tmp_path / f"run{suffix}").write_bytes(b"anything")

    with pytest.raises(InvalidInputError, match=r"not installed; pip install 'brushgrip\[\w+\]'"):
        read_recording(tmp_path / f"run{suffix}", (original.rig, original.tyre))


@pytest.mark.parametrize("format_", ["tdms", "mdf", "parquet", "hdf5", "german"])
def test_a_missing_channel_lists_those_there_and_proposes_a_map(
    format_: str, tmp_path: Path, original: Recording
) -> None:
    path, _ = written(format_, tmp_path, original)

    with pytest.raises(InvalidInputError, match=r"missing.*Angle.*--map '.*psi=.*Angle"):
        read_recording(path, (original.rig, original.tyre))


def test_texts_that_unpack_to_far_more_are_refused(tmp_path: Path, original: Recording) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="needs brushgrip[parquet]")
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs brushgrip[parquet]")
    text = pyarrow.array(["x" * 1000] * 12).dictionary_encode()
    numbers = pyarrow.array(np.arange(12.0))
    parquet.write_table(
        pyarrow.table({"t": numbers, "psi": text, "M_z": numbers, "F_N": numbers}),
        tmp_path / "b.parquet",
    )

    with pytest.raises(InvalidInputError, match=r"b\.parquet: column 'psi' must hold numbers"):
        read_recording(tmp_path / "b.parquet", (original.rig, original.tyre))


def test_a_chunk_that_unpacks_to_far_more_is_refused(
    tmp_path: Path, original: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    h5py = pytest.importorskip("h5py", reason="needs brushgrip[hdf5]")
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        for name in ("t", "psi", "M_z", "F_N"):
            whole = file.create_dataset(name, data=np.arange(12.0), chunks=(12,), compression="gzip")
        whole.id.write_direct_chunk((0,), zlib.compress(bytes(1_000_000)))
    monkeypatch.setattr("identification.reading.formats.hdf5._UNTESTED", 0)

    with pytest.raises(InvalidInputError, match=r"bomb\.h5: a chunk of F_N unpacks to more"):
        read_recording(path, (original.rig, original.tyre))


def test_a_file_of_many_objects_is_not_listed_without_end(
    tmp_path: Path, original: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    h5py = pytest.importorskip("h5py", reason="needs brushgrip[hdf5]")
    with h5py.File(tmp_path / "many.h5", "w") as file:
        for i in range(9):
            file[f"channel_{i}"] = 1.0
    monkeypatch.setattr("identification.reading.formats.hdf5._MOST_OBJECTS", 3)

    with pytest.raises(InvalidInputError, match="there are channel_0, channel_1, channel_2; say"):
        read_recording(tmp_path / "many.h5", (original.rig, original.tyre))


def test_more_data_than_records_are_refused(tmp_path: Path, original: Recording) -> None:
    path, signals = written("mdf", tmp_path, original)
    content, many = path.read_bytes(), struct.pack("<Q", original.t.size)
    assert content.count(many) == 1
    path.write_bytes(content.replace(many, struct.pack("<Q", 24)))

    with pytest.raises(InvalidInputError, match=r"declares 24 records and holds \d+ bytes, \d+ each"):
        read_recording(path, (original.rig, original.tyre), signals=signals)


@pytest.mark.skipif(sys.platform != "linux", reason="bounds memory on Linux alone")
def test_memory_is_bounded_whatever_a_library_asks_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import resource

    @contextmanager
    def asks_for_much(_: Path, __: SignalMap) -> Iterator[ChannelFile]:
        np.ones(300_000_000)
        yield ChannelFile(names=[], read=lambda _: Samples(values=np.empty(0)))

    usual = resource.getrlimit(resource.RLIMIT_AS)
    monkeypatch.setattr("identification.reading.formats.memory.MOST_MEMORY", 1_000_000_000)
    (tmp_path / "run.xyz").write_bytes(b"anything")

    with pytest.raises(InvalidInputError, match=r"run\.xyz: takes more than .* GB of memory to read"):
        read_format(asks_for_much, tmp_path / "run.xyz", REQUIRED_COLUMNS, NO_MAP)
    assert resource.getrlimit(resource.RLIMIT_AS) == usual


def test_a_channel_too_long_is_refused_before_it_is_read(
    tmp_path: Path, original: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, signals = written("parquet", tmp_path, original)
    monkeypatch.setattr("identification.reading.formats.opening.MOST_SAMPLES", 100)

    with pytest.raises(InvalidInputError, match="at most 100 allowed"):
        read_recording(path, (original.rig, original.tyre), signals=signals)
