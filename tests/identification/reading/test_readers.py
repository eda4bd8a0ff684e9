"""Formats of recordings: those that are known, and a user's own."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from identification import READERS, Table, read_decay, read_recording, read_rig
from identification.reading.checked_file_reading import MAX_FILE_SIZE, read_bytes
from identification.reading.formats import csvfile
from identification.reading.formats.csvfile import read_csv
from observers import Ekf, from_files
from symbolic import Rig, Tyre
from tests.identification.reading.logs import require_less_memory
from tests.refusal import fault_of, refused

RIG = (Rig(a=0.04, e=0.009, J_A=0.15), Tyre(k=2.4e6))
T = np.arange(20) / 100
COLUMNS = {"t": T, "psi": 0.1 * np.sin(20 * T), "M_z": -np.cos(T), "F_N": np.full(20, 400.0)}


def read_columns(path: Path, needed: Sequence[str]) -> Table:
    """A reader that knows the columns by heart."""
    columns = {name: COLUMNS[name] for name in needed}
    return Table(path=path, columns=columns, declared={"a": 0.05}, place=lambda at: f"line {at}")


def test_a_format_of_the_users_own() -> None:
    readers = {**READERS, ".log": read_columns}
    recording = read_recording("run.LOG", RIG, readers=readers)
    decay = read_decay("run.log", RIG, readers=readers)

    np.testing.assert_array_equal(recording.M_z, COLUMNS["M_z"])
    np.testing.assert_array_equal(decay.psi, COLUMNS["psi"])
    assert recording.rig.a == decay.rig.a == 0.05


def test_what_a_users_reader_reads_is_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(COLUMNS, "F_N", np.where(T[3] == T, -1.0, 400.0))
    message = refused(read_recording, "run.log", RIG, readers={".log": read_columns})
    assert message.startswith("run.log: line 3: F_N = -1 N; a vertical load is")


def test_an_unknown_format_names_the_known_ones_and_a_missing_file_is_none(tmp_path: Path) -> None:
    path = tmp_path / "run.xlsx"
    path.write_text("t,psi\n")
    assert refused(read_recording, path, RIG).startswith(
        f"{path}: unknown format '.xlsx'; known are .csv, .mat, .tsv, .txt;"
        " pip install 'brushgrip[can]' for .blf, .asc, .log; "
    )
    message = refused(read_decay, path, RIG, readers={**READERS, ".run": read_columns})
    assert "known are .csv, .mat, .run, .tsv, .txt; pip install" in message
    assert refused(read_recording, tmp_path / "none.xlsx", RIG).endswith("none.xlsx: no such file")


def test_readers_are_not_changed_in_place() -> None:
    with pytest.raises(TypeError):
        READERS[".log"] = read_columns  # type: ignore[index]


def test_a_pipe_does_not_block_and_a_device_is_not_read_for_ever(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        assert fault_of(read_bytes, path).startswith("is a pipe or a device; allowed: a regular")
    assert "pipe.toml: is a folder, a pipe or a device; allowed" in refused(from_files, Ekf, pipe)


def test_a_file_that_is_too_large(tmp_path: Path) -> None:
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        file.truncate(MAX_FILE_SIZE + 1_000_000)
    assert fault_of(read_bytes, large) == "holds 501 MB; allowed: up to 500 MB"
    assert fault_of(read_rig, large) == "holds 501 MB; allowed: up to 0.0164 MB"
    assert "large.csv: holds more than 10000000 bytes" in refused(from_files, Ekf, large)


def test_a_table_is_not_held_twice(tmp_path: Path) -> None:
    row = "0.0101,0.2002,-3.5003,400.4\n"
    path = tmp_path / "long.csv"
    path.write_text("t,psi,M_z,F_N\n" + 5_000 * row)
    with require_less_memory(5 * path.stat().st_size):
        columns = read_csv(path, ("t", "psi")).columns

    assert columns["t"].size == 5_000


def test_more_samples_than_a_recording_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "long.csv"
    path.write_text("t,psi\n" + "".join(f"{i},0\n" for i in range(20)) + 30 * "\n")
    monkeypatch.setattr(csvfile, "MAX_SAMPLES", 20)
    assert read_csv(path, ("t", "psi")).columns["t"].size == 20
    monkeypatch.setattr(csvfile, "MAX_SAMPLES", 19)
    assert fault_of(read_csv, path, ("t", "psi")).startswith("holds more than 19 samples; cut it")
