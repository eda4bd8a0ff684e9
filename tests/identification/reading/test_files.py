"""What is no file of sensible size is refused before it is read."""

import os
from pathlib import Path

import pytest

from identification import read_rig
from identification.reading.files import LARGEST_FILE, read_bytes
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
