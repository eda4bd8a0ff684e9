"""What every command takes: --version, --json, --quiet; before its name or behind."""

import json
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import pytest

from brushgrip.outputs.speech import flags_first
from tests.brushgrip.helpers import Run

pytestmark = pytest.mark.usefixtures("interpreted")


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
    assert run(*command).out == f"wrote {tmp_path / 'torque.csv'}\n"


def test_quiet_says_what_goes_wrong_alone(
    run: Run, write_csv: Callable[..., Path], rig: Path, tmp_path: Path
) -> None:
    out = tmp_path / "torque.csv"

    assert run("simulate", write_csv(), "--rig", rig, "--out", out, "--quiet")[:] == (0, "", "")
    assert out.is_file()
    assert "no such recording" in run("simulate", "none", "--out", out, "--quiet").err
    assert "give one of them" in run("--quiet", "--json", "fetch").err
