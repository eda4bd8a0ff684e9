"""A bad file gets one line, exit status 2, and leaves nothing behind."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from tests.brushgrip.helpers import Outcome, Run, Write, contents

pytestmark = pytest.mark.usefixtures("no_work")
N = 60
GOOD = np.arange(N) * 0.01
COMMANDS = {"diagnose": [], "estimate": ["--observer", "ekf"], "simulate": []}


@pytest.fixture
def refuses(run: Run, rig: Path, tmp_path: Path) -> Run:
    """Runs a command on a recording, and looks that nothing has changed."""

    def command(name: str, recording: Path, *words: str, out: Path | None = None) -> Outcome:
        before = contents(tmp_path)
        place = out or tmp_path / "new" / "out.csv"
        outcome = run(name, recording, "--rig", rig, "--out", place, *COMMANDS[name])
        outcome.refused(*words)
        assert contents(tmp_path) == before
        return outcome

    return command


def replaced(values: np.ndarray, at: int, value: object) -> list[object]:
    return [*values[:at], value, *values[at + 1 :]]


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
    refuses: Run, write_csv: Write, command: str, columns: dict[str, object], words: list[str]
) -> None:
    path = write_csv("bad.csv", columns)
    refuses(command, path, str(path), *words)


def test_a_diagnosis_from_nine_torques(refuses: Run, write_csv: Write) -> None:
    path = write_csv("few.csv", {"M_z": [1.0] * 9 + [""] * (N - 9)})
    refuses("diagnose", path, f"{path}: M_z is known in 9 of 60 samples, at least 10 needed")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty"]),
        ("t,psi,M_z,F_N\n0,0,0,400\n0.01,0,0,400\n", ["2 samples", "at least 10"]),
        ("t,psi,M_z,F_N\n", ["0 samples"]),
    ],
    ids=["empty", "two samples", "header alone"],
)
def test_bad_files(refuses: Run, tmp_path: Path, text: str, words: list[str]) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    refuses("diagnose", path, str(path), *words)


def test_mat_without_the_angle(refuses: Run, tmp_path: Path) -> None:
    column = np.ones((N, 1))
    content = {"time": GOOD[:, None], "Mz": column, "Fz": column, "a": 0.04, "e": 0.0, "k": 2e6}
    scipy.io.savemat(tmp_path / "bad.mat", content)
    refuses("diagnose", tmp_path / "bad.mat", str(tmp_path / "bad.mat"), "Psi")


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
    refuses: Run, write_csv: Write, rig: Path, changes: tuple[str, str], words: list[str]
) -> None:
    rig.write_text(rig.read_text().replace(*changes))
    refuses("diagnose", write_csv(), str(rig), *words)


def test_no_rig(run: Run, write_csv: Write, tmp_path: Path) -> None:
    run("diagnose", write_csv(), "--out", tmp_path / "out").refused("--rig")


@pytest.mark.parametrize("command", COMMANDS)
def test_unwritable_places_show_before_work_begins(
    refuses: Run, write_csv: Write, tmp_path: Path, command: str
) -> None:
    (tmp_path / "file").write_text("x")
    out = tmp_path / "file" / "out.csv"
    refuses(command, write_csv(), str(out), out=out)


def test_a_file_where_the_folder_goes(refuses: Run, write_csv: Write) -> None:
    path = write_csv()
    refuses("diagnose", path, str(path), "is not a folder", out=path)
