"""What recordings stand on, said on the command line."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip.estimation.observe_recording import observer_factory
from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.inputs.recording_files import parse_ground_by_recording
from brushgrip.live.session_setup import source_and_estimator
from brushgrip.outputs.provenance import provenance_of
from tests.brushgrip.helpers import Run, Write, write_model
from tests.refusal import refused

pytestmark = pytest.mark.usefixtures("interpreted")


THREE = ["a", "b", "c"]


def test_grounds_by_name() -> None:
    by_name = {"a": "steel", "b": "steel", "c": "red emery"}
    assert parse_ground_by_recording(THREE, ["steel=a, b", "red emery=c"]) == by_name
    assert parse_ground_by_recording(THREE, ["steel=a"]) == {"a": "steel"}
    assert parse_ground_by_recording(THREE, None) == {}
    assert parse_ground_by_recording(THREE, ["steel"]) == dict.fromkeys(THREE, "steel")


def test_a_ground_may_have_the_name_of_a_recording(write_csv: Write) -> None:
    files = [str(write_csv(f"{name}.csv")) for name in ("ice", "a")]
    inputs = gather_inputs(files, ground=["ice=ice,a"])

    assert [*inputs.paths] == ["ice_recording", "a"]
    assert inputs.grounds == {"ice_recording": "ice", "a": "ice"}


@pytest.mark.parametrize(
    ("given", "word"),
    [
        (["=a"], "--ground =a: expected NAME, or NAME=REC,REC"),
        (["steel="], "--ground steel=: no recording ''; given are a, b, c"),
        (["steel=a,d"], "--ground steel=a,d: no recording 'd'; given are a, b, c"),
        (["steel=a", "emery=b,a"], "--ground emery=b,a: a stands on steel already; one ground each"),
    ],
)
def test_faults(given: list[str], word: str) -> None:
    assert refused(parse_ground_by_recording, THREE, given).startswith(word)


@pytest.fixture
def model() -> Path:
    """Bristles four times as stiff on steel as on emery."""
    return write_model(
        effects=["stiffness_by_ground"],
        shared={},
        grounds={"steel": {"k": 4e6}, "emery": {"k": 1e6}},
        recordings={"known": {"mu": 0.9}},
        rig={"known": {"a": 0.047, "load": 1.02, "zero": 0.3}},
    )


def first_torque(path: Path) -> float:
    return float(np.loadtxt(path, delimiter=",", skiprows=1)[1, 1])


def test_simulate_takes_values_of_the_ground(run: Run, write_csv: Write, rig: Path, model: Path) -> None:
    labelled = write_csv("labelled.csv", top="# ground = emery\n")
    out = Path("out.csv")
    torques, texts = [], []
    for path, more in (
        (labelled, ()),
        (labelled, ("--ground", "steel")),
        (write_csv("bare.csv"), ()),
        (write_csv("bare.csv"), ("--ground", "steel=bare")),
    ):
        outcome = run("simulate", "--rig", rig, "--model", model, path, "--out", out, *more)
        assert outcome.status == 0
        torques.append(first_torque(out))
        texts.append(outcome.out)

    assert torques[1] == pytest.approx(torques[3])
    assert abs(torques[0]) < abs(torques[2]) < abs(torques[1])
    assert "labelled: values of emery" in texts[0]
    assert "labelled: values of steel" in texts[1]
    assert "bare: ground not given: mean of steel and emery" in texts[2]


def test_simulate_takes_what_became_of_the_declared_values(
    run: Run, write_csv: Write, rig: Path, model: Path, table: Any
) -> None:
    out = Path("out.csv")
    path = write_csv("known.csv", top="# ground = steel\n")
    behind = {"provenance": provenance_of([path])}
    model.write_text(json.dumps(json.loads(model.read_text()) | behind))
    assert run("simulate", "--rig", rig, "--model", model, path, "--out", out).status == 0

    # At rest the channel shows its zero, in full slide the patch 3/8 mu F_N a, 6 % more for the caster.
    torque = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1]
    assert torque[0] == pytest.approx(0.3, abs=0.01)
    slide = 0.375 * 0.9 * 1.02 * table["F_N"][0] * 0.047
    assert 1.0 < np.abs(torque - 0.3).max() / slide < 1.06


def test_estimate_says_whose_values_it_takes(run: Run, write_csv: Write, rig: Path, model: Path) -> None:
    paths = [write_csv(f"{name}.csv") for name in ("run", "one", "two")]
    outcome = run("estimate", "--rig", rig, "--model", model, *paths, "--ground", "steel=run",
                  "--ground", "ice=one,two", "--jobs", 1)  # fmt: skip

    assert "run: values of steel" in outcome.out
    assert "one and two: ice is unknown: mean of steel and emery" in outcome.out


def test_live_says_whose_values_it_takes(
    rig: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    inputs = gather_inputs(rig=rig, model=model)
    source_and_estimator("-", inputs, observer_factory(ObserverName.EKF), ground="ice")

    assert capsys.readouterr().out == "ice is unknown: mean of steel and emery\n"
