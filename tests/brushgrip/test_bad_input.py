"""A bad file gets one line, exit status 2, and leaves nothing behind."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

Run = Callable[..., Any]
Write = Callable[..., Path]

N = 60
GOOD = np.arange(N) * 0.01


def replaced(values: np.ndarray, at: int, value: object) -> list[object]:
    return [*values[:at], value, *values[at + 1 :]]


@pytest.fixture(autouse=True)
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faults are found before any estimation begins."""

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("work has begun")

    monkeypatch.setattr("identification.diagnose", refuse)


def tree(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"M_z": None}, ["row 1", "M_z", "missing"]),
        ({"psi": replaced(GOOD, 3, "left")}, ["row 5", "psi", "'left'", "not a number"]),
        ({"t": replaced(GOOD, 30, 0.05)}, ["row 32", "runs backwards", "must increase"]),
        ({"t": GOOD * 1e-321}, ["row 3", "stands nearly still", "at least 1e-06 s"]),
        ({"M_z": np.full(N, np.nan)}, ["every M_z is missing"]),
        ({"F_N": replaced(np.full(N, 400.0), 9, -5)}, ["row 11", "F_N = -5", "greater than 0"]),
    ],
    ids=["column", "text", "time", "time still", "all NaN", "load"],
)
@pytest.mark.parametrize("command", ["diagnose", "estimate"])
def test_bad_columns(
    run: Run,
    write_csv: Write,
    rig: Path,
    tmp_path: Path,
    command: str,
    columns: dict[str, object],
    words: list[str],
) -> None:
    path = write_csv("bad.csv", columns)
    before = tree(tmp_path)
    options = ["--observer", "ekf"] if command == "estimate" else []
    outcome = run(command, path, "--rig", rig, "--out", tmp_path / "new" / "out", *options)

    assert_refused(outcome, [str(path), *words])
    assert tree(tmp_path) == before


def test_a_diagnosis_from_nine_torques(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    path = write_csv("few.csv", {"M_z": [1.0] * 9 + [""] * (N - 9)})
    outcome = run("diagnose", path, "--rig", rig, "--out", tmp_path / "out")

    assert_refused(outcome, [f"{path}: M_z is known in 9 of 60 samples, at least 10 needed"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty"]),
        ("t,psi,M_z,F_N\n0,0,0,400\n0.01,0,0,400\n", ["2 samples", "at least 10"]),
        ("t,psi,M_z,F_N\n", ["0 samples"]),
    ],
    ids=["empty", "two samples", "header alone"],
)
def test_bad_files(run: Run, rig: Path, tmp_path: Path, text: str, words: list[str]) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    before = tree(tmp_path)
    outcome = run("diagnose", path, "--rig", rig, "--out", tmp_path / "out")

    assert_refused(outcome, [str(path), *words])
    assert tree(tmp_path) == before


def test_mat_without_the_angle(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "bad.mat"
    column = np.ones((N, 1))
    content = {"time": GOOD[:, None], "Mz": column, "Fz": column, "a": 0.04, "e": 0.0, "k": 2e6}
    scipy.io.savemat(path, content)
    before = tree(tmp_path)
    outcome = run("diagnose", path, "--out", tmp_path / "out")

    assert_refused(outcome, [str(path), "Psi"])
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (("a = 0.045", "a = 0"), ["a must be", "greater than 0", "got 0"]),
        (("a = 0.045", "a = -0.1"), ["a must be", "greater than 0", "got -0.1"]),
        (("e = 0.009", "e = 0.045"), ["e must lie between", "got 0.045"]),
        (("e = 0.009", "e = -0.05"), ["e must lie between", "got -0.05"]),
        (("k = 2.4e6", ""), ["k is missing"]),
    ],
)
def test_bad_rigs(
    run: Run, write_csv: Write, rig: Path, tmp_path: Path, changes: tuple[str, str], words: list[str]
) -> None:
    rig.write_text(rig.read_text().replace(*changes))
    path = write_csv()
    before = tree(tmp_path)
    outcome = run("diagnose", path, "--rig", rig, "--out", tmp_path / "out")

    assert_refused(outcome, [str(rig), *words])
    assert tree(tmp_path) == before


def test_no_rig(run: Run, write_csv: Write, tmp_path: Path) -> None:
    assert_refused(run("diagnose", write_csv(), "--out", tmp_path / "out"), ["--rig"])


@pytest.mark.parametrize("command", ["diagnose", "simulate", "estimate"])
def test_unwritable_places_show_before_work_begins(
    run: Run, write_csv: Write, rig: Path, tmp_path: Path, command: str
) -> None:
    path = write_csv()
    (tmp_path / "file").write_text("x")
    before = tree(tmp_path)
    options = ["--observer", "ekf"] if command == "estimate" else []
    out = tmp_path / "file" / "out.csv"
    outcome = run(command, path, "--rig", rig, "--out", out, *options)

    assert_refused(outcome, [str(out)])
    assert tree(tmp_path) == before


def test_a_file_where_the_folder_goes(run: Run, write_csv: Write, rig: Path) -> None:
    path = write_csv()
    outcome = run("diagnose", path, "--rig", rig, "--out", path)

    assert_refused(outcome, [str(path), "is not a folder"])


def assert_refused(outcome: Any, words: list[str]) -> None:
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    assert outcome.err.endswith("\n")
    for word in words:
        assert word in outcome.err
