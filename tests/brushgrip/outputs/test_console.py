import io
import json
import os
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest

from brushgrip.outputs import console
from brushgrip.outputs.console import print_line, print_table, progress
from brushgrip.outputs.standard_streams import replace_unencodable_characters, stdout_fault
from brushgrip.outputs.verbosity import flags_first
from brushgrip.report.tables import errors_by_stage
from tests.brushgrip.factories import make_diagnosis
from tests.brushgrip.helpers import Run

pytestmark = pytest.mark.usefixtures("interpreted")


def test_progress_elsewhere_than_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = iter([0.0, 1.0, 9.9, 10.0, 12.0, 21.0])
    monkeypatch.setattr(console.time, "monotonic", lambda: next(seconds))
    with progress() as report:
        for done in range(5):
            report("trying", done, 5)

    captured = capsys.readouterr()
    assert captured.out == ""
    steps = "trying: 2 of 5, 10 s so far, about 14 s left in this step\ntrying: 4 of 5, 21 s so far\n"
    assert captured.err == steps


def test_bar_and_count_stay_at_80_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    with progress() as report:
        report("trying [1] on top of frictional_creep, carcass_torsion, asymmetric_friction", 7, 11)

    captured = capsys.readouterr()
    assert captured.out == ""
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", captured.err)
    line = next(line for line in re.split(r"[\r\n]", shown) if "7/11" in line)
    assert "━━━" in line
    assert "left" not in line
    assert line.startswith("trying [1] on top of")
    assert len(line) <= 80


def test_words_of_headings_are_whole_at_80_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    diagnosis = make_diagnosis()
    after = replace(diagnosis.after, unrefitted={"held_c": 0.01})
    model, *headings = errors_by_stage(replace(diagnosis, after=after)).headings
    print_table("Errors", [model, *headings], [["declared", *["1.23 %"] * len(headings)]])
    shown = capsys.readouterr().out
    assert "nothing" in shown
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= 80
    # The table fits, borders and all.
    assert {line[-1] for line in shown.splitlines()[1:]} == set("┓┃┩│┘")


OURS = "μ = 1.20 ± 0.05 → 3·10⁻² N/m², “höhe” – ϑ … 重"


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("ascii", 'mu = 1.20 +/- 0.05 -> 3*10^-2 N/m^2, "hohe" - theta ... \\u91cd'),
        ("cp1252", "mu = 1.20 ± 0.05 -> 3·10^-² N/m², “höhe” – theta … \\u91cd"),
        ("utf-8", OURS),
    ],
)
def test_a_sign_that_an_encoding_lacks_is_spelt(
    encoding: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", stream)
    replace_unencodable_characters()
    print(OURS, end="", flush=True)

    assert stream.buffer.getvalue().decode(encoding) == shown  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["two\nlines", "\x1b[2J", "\udcff", "\u202eturned"])
def test_what_is_said_stays_on_its_line(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    print_line(f"wrote {name}.csv")
    out = capsys.readouterr().out

    assert out.count("\n") == 1
    assert out.removesuffix("\n").isprintable()


def test_a_full_disk_is_told_from_a_closed_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        print("result")
        assert stdout_fault() == "No space left on device"
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w", encoding="utf-8") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        print("result")
        assert stdout_fault() == ""
    monkeypatch.undo()

    assert stdout_fault() is None


def test_flags_come_first() -> None:
    given = ["estimate", "--quiet", "a", "--", "--json"]

    assert flags_first(given) == ["--quiet", "estimate", "a", "--", "--json"]


def test_the_version(run: Run) -> None:
    outcome = run("--version")

    assert (outcome.status, outcome.out) == (0, f"brushgrip {version('brushgrip')}\n")


@pytest.mark.parametrize("behind", [False, True])
def test_json_is_all_that_is_printed(
    run: Run, write_csv: Callable[..., Path], rig: Path, tmp_path: Path, behind: bool
) -> None:
    command = ["simulate", write_csv(), "--rig", rig, "--out", tmp_path / "torque.csv"]
    outcome = run(*[*command, "--json"] if behind else ["--json", *command])

    assert outcome.status == 0
    assert outcome.err == ""
    assert json.loads(outcome.out) == {"wrote": [str(tmp_path / "torque.csv")]}
    # Once only: the next command speaks plainly again.
    assert run(*command).out.splitlines()[-1] == f"wrote {tmp_path / 'torque.csv'}"


def test_quiet_says_what_goes_wrong_alone(run: Run, write_csv: Callable[..., Path], rig: Path) -> None:
    out = Path("torque.csv")

    assert run("simulate", write_csv(), "--rig", rig, "--out", out, "--quiet")[:] == (0, "", "")
    assert out.is_file()
    assert "no such recording" in run("simulate", "none", "--out", out, "--quiet").err
    assert "give one of them" in run("--quiet", "--json", "fetch").err
