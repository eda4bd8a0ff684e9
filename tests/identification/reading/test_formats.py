"""One recording in every format, read back; and formats that are damaged on purpose."""

import re
import struct
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, read_recording, read_rig
from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats import can
from identification.reading.formats.optional_libraries import read_by_optional_library
from identification.reading.signal_map import NO_MAP, SignalMap
from tests.identification.reading.logs import OWN_CLOCK, WRITERS, as_logged, write_datasets, write_fields
from tests.refusal import refused

FOLDER = Path(__file__).parents[3] / "examples" / "recordings"
RIG = read_rig(FOLDER / "rig.toml")
ORIGINAL = read_recording(FOLDER / "holdout_c.csv", RIG)
NUMBERS = np.arange(12.0)


def read(path: Path, signals: str = "") -> Recording:
    return read_recording(path, RIG, signals=signals)


def refusal(path: Path, signals: str = "") -> str:
    return refused(read, path, signals)


def written(format_: str, folder: Path) -> tuple[Path, str]:
    name, write, signals = WRITERS[format_]
    path = folder / name
    write(path, as_logged(ORIGINAL.t, ORIGINAL.psi, ORIGINAL.M_z, ORIGINAL.F_N))
    return path, signals


@pytest.mark.parametrize("format_", WRITERS)
def test_every_format_gives_the_same_samples(format_: str, tmp_path: Path) -> None:
    path, signals = written(format_, tmp_path)

    recording = read(path, signals)

    start = ORIGINAL.t[0] if "t=" not in signals else 0.0
    np.testing.assert_allclose(recording.t, ORIGINAL.t - start, rtol=0, atol=1.1e-6)
    # CAN frames hold single precision.
    np.testing.assert_allclose(recording.psi, ORIGINAL.psi, rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(recording.M_z, ORIGINAL.M_z, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(recording.F_N, ORIGINAL.F_N, rtol=1e-7)
    assert recording.rig.a == (0.05 if format_ == "matlab" else ORIGINAL.rig.a)


def test_a_database_is_found_or_asked_for(tmp_path: Path) -> None:
    path, _ = written("blf", tmp_path)
    (tmp_path / "rig.dbc").rename(tmp_path / "car.db")

    assert re.search(r"run\.blf: 0 databases .* --map dbc=car\.dbc", refusal(path, OWN_CLOCK))
    assert read(path, f"{OWN_CLOCK},dbc={tmp_path / 'car.db'}").t.size == ORIGINAL.t.size


@pytest.mark.parametrize(("share", "told"), [(1.01, True), (1.05, False)])
def test_a_torque_at_the_end_of_its_range_in_the_database_is_told(
    share: float, told: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, _ = written("blf", tmp_path)
    database, end = tmp_path / "rig.dbc", share * float(np.abs(ORIGINAL.M_z).max())
    database.write_text(database.read_text().replace('[0|0] "Nm"', f'[{-end}|{end}] "Nm"'))
    recording = read(path, OWN_CLOCK)

    assert ("comes within 2 % of the end of the range of the database" in caplog.text) == told
    assert np.isfinite(recording.M_z).all()
    assert recording.rig.range is None


@pytest.mark.parametrize("suffix", [".tdms", ".mf4", ".parquet", ".h5", ".blf", ".bag"])
def test_a_library_that_is_not_there_is_named(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr("identification.reading.formats.optional_libraries.import_module", missing)
    path = tmp_path / f"run{suffix}"
    path.write_bytes(b"anything")

    assert re.search(r"not installed; pip install 'brushgrip\[\w+\]'", refusal(path))


@pytest.mark.parametrize("format_", ["parquet", "german"])
def test_a_missing_channel_lists_those_there_and_proposes_a_map(format_: str, tmp_path: Path) -> None:
    path, _ = written(format_, tmp_path)

    assert re.search(r"missing.*Angle.*--map .*psi=.*Angle", refusal(path))


def test_a_time_that_channels_with_clocks_of_their_own_do_not_have_is_left_out(tmp_path: Path) -> None:
    path, _ = written("blf", tmp_path)

    left_out = "no channel 'time' for t; the others have clocks of their own: map no t"
    assert refusal(path, f"{OWN_CLOCK},t=time").endswith(left_out)


def test_texts_that_unpack_to_far_more_are_refused(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="needs brushgrip[parquet]")
    text = pyarrow.array(["x" * 1000] * 12).dictionary_encode()
    columns = dict.fromkeys(("t", "psi", "M_z", "F_N"), NUMBERS) | {"psi": text}
    write_fields(tmp_path / "b.parquet", columns.items())

    assert "b.parquet: column 'psi' must hold numbers" in refusal(tmp_path / "b.parquet")


def test_a_chunk_that_unpacks_to_far_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    h5py = pytest.importorskip("h5py", reason="needs brushgrip[hdf5]")
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        for name in ("t", "psi", "M_z", "F_N"):
            whole = file.create_dataset(name, data=NUMBERS, chunks=(12,), compression="gzip")
        whole.id.write_direct_chunk((0,), zlib.compress(bytes(1_000_000)))
    monkeypatch.setattr("identification.reading.formats.hdf5._UNTESTED", 0)

    assert "bomb.h5: a chunk of F_N unpacks to more" in refusal(path)


def test_a_file_of_many_objects_is_not_listed_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_datasets(tmp_path / "many.h5", {f"channel_{i}": NUMBERS for i in range(9)})
    monkeypatch.setattr("identification.reading.formats.hdf5._MAX_OBJECTS", 3)

    assert "there are channel_0, channel_1, channel_2; say" in refusal(path)


def test_a_blf_file_that_unpacks_to_far_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed = zlib.compress(bytes(2_000_000))
    container = struct.pack("<4sHHII", b"LOBJ", 16, 1, 32 + len(packed), 10)
    header = b"LOGG" + struct.pack("<I", 144) + bytes(136)
    body = container + struct.pack("<H6xI4x", 2, 2_000_000) + packed
    path = tmp_path / "bomb.blf"
    path.write_bytes(header + body)

    can.require_bounded_blf_parts(path)
    monkeypatch.setattr(can, "_MAX_CONTAINER_SIZE", 1_000_000)
    assert re.search(
        r"bomb\.blf: holds more than .* unpacked", refused(can.require_bounded_blf_parts, path)
    )


@pytest.mark.parametrize(
    ("format_", "field", "message"),
    [
        ("mdf", "byte_offset", "a record of 32"),
        ("mdf 3", "additional_byte_offset", "a record of 32"),
        ("mdf", "samples_byte_nr", "60000 each"),
    ],
)
@pytest.mark.parametrize("channel", [0, 1], ids=["master", "value"])
def test_a_channel_beyond_its_record_is_refused(
    format_: str, field: str, message: str, channel: int, tmp_path: Path
) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs brushgrip[mdf]")
    path, signals = written(format_, tmp_path)
    content = bytearray(path.read_bytes())
    with asammdf.MDF(path) as file:
        group = file.groups[0]
        block = group.channel_group if field == "samples_byte_nr" else group.channels[channel]
        first, old = block.address, bytes(block)
        setattr(block, field, 60000)
        new = bytes(block)
    content[first : first + len(old)] = new
    path.write_bytes(content)

    assert message in refusal(path, signals)


def test_more_data_than_records_are_refused(tmp_path: Path) -> None:
    path, signals = written("mdf", tmp_path)
    content, many = path.read_bytes(), struct.pack("<Q", ORIGINAL.t.size)
    assert content.count(many) == 1
    path.write_bytes(content.replace(many, struct.pack("<Q", 24)))

    assert re.search(r"declares 24 records and holds \d+ bytes, \d+ each", refusal(path, signals))


def test_a_channel_too_long_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, signals = written("parquet", tmp_path)
    monkeypatch.setattr("identification.reading.formats.optional_libraries.MAX_SAMPLES", 100)

    assert "at most 100 allowed" in refusal(path, signals)


def refusal_where(opening: Callable[[], object], folder: Path) -> str:
    """How a format is refused whose library does this when it opens a file."""

    @contextmanager
    def opener(_: Path, __: SignalMap) -> Iterator[ChannelFile]:
        opening()
        yield ChannelFile(names=[], read=lambda _: ChannelSamples(values=np.empty(0)))

    (folder / "run.xyz").write_bytes(b"anything")
    return refused(read_by_optional_library, opener, folder / "run.xyz", ("t",), NO_MAP)


def test_whatever_a_library_raises_is_one_line(tmp_path: Path) -> None:
    assert "run.xyz: is damaged, or no .xyz file: " in refusal_where(lambda: {}["a\nb"], tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="bounds memory on Linux alone")
def test_memory_is_bounded_in_every_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    usual = resource.getrlimit(resource.RLIMIT_AS)
    monkeypatch.setattr("identification.reading.formats.optional_libraries.LIMIT.most", 1_000_000_000)
    message = refusal_where(lambda: np.ones(300_000_000), tmp_path)

    assert re.search(r"run\.xyz: takes more than .* GB of memory to read", message)
    assert resource.getrlimit(resource.RLIMIT_AS) == usual
