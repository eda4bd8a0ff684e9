"""A bad file gets one line, exit status 2, and leaves nothing behind; `reading` has every fault."""

from pathlib import Path

import numpy as np
import pytest

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
        ({"psi": replaced(GOOD, 3, "left")}, ["row 5", "psi", "'left'", "not a number"]),
        ({"t": GOOD * 1e-321}, ["row 3", "stands nearly still", "at least 1e-06 s"]),
    ],
    ids=["text", "time still"],
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


def test_a_bad_rig(refuses: Run, write_csv: Write, rig: Path) -> None:
    rig.write_text(rig.read_text().replace("k = 2.4e6", ""))
    refuses("diagnose", write_csv(), str(rig), "k is missing")


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
