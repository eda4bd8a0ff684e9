"""What is no file of sensible size is refused before it is read."""

import os
import tracemalloc
from pathlib import Path

import pytest

from identification import read_rig
from identification.reading.files import LARGEST_FILE, read_bytes
from identification.reading.formats import csvfile
from identification.reading.formats.csvfile import read_csv
from observers import Ekf, from_files
from symbolic import InvalidInputError


def test_a_pipe_does_not_block(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    with pytest.raises(
        InvalidInputError, match=r"pipe\.toml: is a pipe or a device; allowed: a regular"
    ):
        read_bytes(pipe)
    with pytest.raises(InvalidInputError, match=r"pipe\.toml: is a folder, a pipe or a device; allowed"):
        from_files(Ekf, pipe)


def test_a_device_is_not_read_for_ever() -> None:
    with pytest.raises(InvalidInputError, match=r"^/dev/zero: is a pipe or a device"):
        read_bytes(Path("/dev/zero"))


def test_a_file_that_is_too_large(tmp_path: Path) -> None:
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(LARGEST_FILE + 1_000_000)
    with pytest.raises(InvalidInputError, match=r"large\.csv: holds 501 MB; allowed: up to 500 MB$"):
        read_bytes(large)
    with pytest.raises(InvalidInputError, match=r"large\.csv: holds 501 MB; allowed: up to 0\.0164 MB$"):
        read_rig(large)
    with pytest.raises(InvalidInputError, match=r"large\.csv: holds more than 10000000 bytes"):
        from_files(Ekf, large)


def test_a_table_is_not_held_twice(tmp_path: Path) -> None:
    row = "0.0101,0.2002,-3.5003,400.4\n"
    path = tmp_path / "long.csv"
    path.write_text("t,psi,M_z,F_N\n" + 20_000 * row)
    tracemalloc.start()
    columns = read_csv(path, ("t", "psi")).columns
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert columns["t"].size == 20_000
    assert peak < 5 * path.stat().st_size


def test_more_samples_than_a_recording_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "long.csv"
    path.write_text("t,psi\n" + "".join(f"{i},0\n" for i in range(20)) + 30 * "\n")
    monkeypatch.setattr(csvfile, "MOST_SAMPLES", 20)
    assert read_csv(path, ("t", "psi")).columns["t"].size == 20
    monkeypatch.setattr(csvfile, "MOST_SAMPLES", 19)
    with pytest.raises(InvalidInputError, match=r"long\.csv: holds more than 19 samples; cut it"):
        read_csv(path, ("t", "psi"))
