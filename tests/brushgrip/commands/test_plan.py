"""`brushgrip plan`: the path, and how far to turn on each ground."""

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import observers
from brushgrip.outputs import plan_texts
from tests.brushgrip.helpers import Outcome, Run, table_of
from tests.each_once import each_once

pytestmark = pytest.mark.usefixtures("optimised")
PlanRun = Callable[..., Outcome]
PLANNED_ONCE = each_once(partial(observers.plan, coarse=True))
"""A coarse family of paths, tried once for the same question."""


@pytest.fixture
def planning(run: Run, rig: Path, monkeypatch: pytest.MonkeyPatch) -> PlanRun:
    """The command on a rig."""

    def without_progress(*given: object, **named: object) -> object:
        named.pop("progress", None)
        return PLANNED_ONCE(*given, **named)

    monkeypatch.setattr(observers, "plan", without_progress)
    limit = ("--limit", "angle=0.3,rate=0.4", "--limit", "time=5")
    usual = ("--load", "400", "--tuning", "clean", *limit)
    return lambda *options: run("plan", "--rig", rig, *usual, *options)


def test_writes_the_path_and_what_it_tells(planning: PlanRun) -> None:
    outcome = planning("--mu", "0.8,0.1", "--out", "p.csv")
    table = table_of(Path("p.csv"))

    assert outcome.status == 0
    before, _, table_told = outcome.out.partition("until sigma/mu is 10.0%")
    assert "k counts as a state: give estimate, and codegen, --stiffness-state too" in before
    assert "sigma/mu" in table_told
    assert [*table] == ["t", "psi", "psi_dot", "travel", "F_N", "deviation_01", "deviation_08"]
    # So that `simulate` takes it.
    assert (table["F_N"] == 400).all()
    assert np.abs(table["psi"]).max() <= 0.3
    turned = np.cumsum(np.abs(np.diff(table["psi"], prepend=0)))
    assert table["travel"] == pytest.approx(turned, abs=1e-5)
    # The path ends soon after the last ground is known.
    assert max(table["deviation_01"][-1], table["deviation_08"][-1]) <= 0.1
    assert Path("p.png").read_bytes()[:4] == b"\x89PNG"
    assert json.loads(Path("p.provenance.json").read_text())["settings"]["target"] == 0.1
    known = np.searchsorted(table["travel"], table["travel"][-1] / 1.1)
    assert any(f"{travel:.3f}" in outcome.out for travel in table["travel"][known - 3 : known + 3])


def test_says_the_path_in_the_angle_that_the_rig_file_maps(planning: PlanRun, rig: Path) -> None:
    options = ("--mu", "0.8,0.1")
    plain = planning(*options).out.splitlines()[0]
    angle = 'psi = { channel = "Lenkwinkel", unit = "deg", factor = -0.07 }'
    rig.write_text(f"{rig.read_text()}[signals]\n{angle}\n")
    mapped = planning(*options).out.splitlines()[0]
    turns = [float(turn) for turn in plain.split(" rad")[0].removeprefix("turn to ").split(", ")]

    begin, places, rest = re.split(" to | deg; that", mapped, maxsplit=2)
    assert begin == "turn channel Lenkwinkel"
    of_wheel = [float(place) for place in places.split(", ")]
    assert of_wheel == pytest.approx(np.degrees(turns) / -0.07, abs=1.0)
    assert rest == f" turns the wheel, as below, {plain.removeprefix('turn ')}"


def test_a_missed_target_has_the_digits_that_tell_it_from_the_deviation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reached = {"travel": 0.1, "time": 1.0, "angle": 0.05}
    missed = dict.fromkeys(reached)
    grounds = [
        {"mu": 0.4, **reached, "deviation": 0.0498},
        {"mu": 0.1, **missed, "deviation": 0.0504},
        {"mu": 0.05, **missed, "deviation": None},
    ]
    monkeypatch.setattr(plan_texts, "plan_document", lambda *_: {"grounds": grounds})
    rows = plan_texts.rows_by_ground(SimpleNamespace(target=0.05), None)

    assert rows == [
        ["0.4", "0.100", "1.000", "0.050", "5.0%"],
        ["0.1", "–", "–", "–", "5.04%"],
        ["0.05", "–", "–", "–", "–"],
    ]


@pytest.mark.long
def test_says_why_a_target_is_out_of_reach(planning: PlanRun) -> None:
    planning("--mu", "0.8", "--target", "0.02").refused(
        "2.0% cannot be reached by any steering: tolerances of half-length", "ask for well above that"
    )
    options = ("--mu", "0.05,0.8", "--limit", "torque=1")
    partly, told = planning(*options), json.loads(planning(*options, "--json").out)

    assert told["grounds"][1]["travel"] is None
    assert told["unreached"][0] in partly.out
    assert partly.status == 1
    assert "a dash: with noise in fewer than 18 of 20 simulated runs; sigma/mu is there" in partly.out
    assert "no path within the limits reaches 10.0% in 18 of 20 simulated runs on mu = " in partly.err
    assert "0.8; the best one was found" in partly.err


@pytest.mark.long
def test_a_car_is_steered_by_its_handwheel(run: Run, repository_root: Path) -> None:
    car = repository_root / "examples" / "vehicles" / "small_car.toml"
    outcome = run("plan", "--vehicle", car, "--mu", "0.6", "--target", "15%", "--out", "p.csv")
    table = table_of(Path("p.csv"))

    assert outcome.status == 0
    assert "this is for a car as declared; off within its tolerances it may take more" in outcome.out
    assert "rests on declared values that no steering tells: front_axle_load" in outcome.out
    # At rest, before the first turn, both are 0.
    turned = table["psi"] != 0
    assert not table["handwheel"][~turned].any()
    ratio = table["handwheel"][turned] / table["psi"][turned]
    assert 10 < np.median(ratio) < 25
    assert np.ptp(ratio) < 0.1 * np.median(ratio)
    # The table counts degrees of the handwheel until the target.
    known = table["deviation_06"] <= 0.15
    travel = np.cumsum(np.abs(np.diff(table["handwheel"], prepend=0)))
    (row,) = re.findall(r"0\.6 *│ *(\d+) *│ *([\d.]+) *│ *(\d+) *│", outcome.out)
    at = int(np.searchsorted(table["t"], float(row[1]) - 0.06))
    assert float(row[0]) == pytest.approx(np.degrees(travel[at]), rel=0.1)
    most = np.degrees(np.abs(table["handwheel"][: at + 1]).max())
    assert float(row[2]) == pytest.approx(most, rel=0.1)
    assert known[at : at + 12].any()
    assert "15.0% (95 % band ± 30% of mu)" in re.sub(r"\s+", " ", outcome.out)
