"""`brushgrip estimate` and `codegen` of a car, from the log of its bus."""

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from brushgrip.estimation.friction_budget import declared_uncertainty_text
from brushgrip.estimation.friction_by_both_models import EKF_DECLARED, EKF_FOUND, friction_by_both_models
from brushgrip.inputs.command_inputs import gather_inputs
from symbolic.vehicle.candidate_effects import CAR_EFFECTS
from tests.brushgrip.factories import make_diagnosis
from tests.brushgrip.helpers import Run, table_of
from tests.columns import write_columns
from tests.identification.reading.logs import write_frames, write_mdf_group
from tests.simulated_car import SimulatedCar, declared_vehicle, steering, vehicle_text

pytestmark = pytest.mark.usefixtures("interpreted")
MAP = "\n[signals]\n" + "".join(
    f'{column} = {{ channel = "{channel}", unit = "{unit}" }}\n'
    for column, channel, unit in (
        ("rack", "RackTravel", "mm"), ("F_rack", "RackForce", "N"), ("speed", "Speed", "km/h"),
    )
)  # fmt: skip


def write_log(path: Path, t: np.ndarray, rack: np.ndarray, force: np.ndarray) -> None:
    """A log of a bus, or of MDF, of a car that stands."""
    channels = {"RackTravel": 1e3 * rack, "RackForce": force, "Speed": 0 * t}
    if path.suffix == ".blf":
        write_frames(path, t, {"RackTravel": "mm", "RackForce": "N", "Speed": "km/h"}, channels)
        return
    write_mdf_group(path, channels.items(), t)


@pytest.fixture
def mapped(car: Path) -> None:
    """The vehicle file maps the channels of a log."""
    car.write_text(car.read_text() + MAP)


@pytest.mark.usefixtures("mapped")
@pytest.mark.parametrize("name", ["car.mf4", "car.blf"])
def test_from_a_log_to_friction_in_one_command(run: Run, tmp_path: Path, name: str) -> None:
    t, rack = steering(seconds=8.0)
    write_log(tmp_path / name, t, rack, SimulatedCar().force(rack))
    outcome = run("estimate", "--vehicle", "car.toml", "--observer", "ekf", name, "--out", "mu.csv")
    found = table_of(tmp_path / "mu.csv")

    assert outcome.status == 0
    assert found["usable"][-1] == 1
    assert found["mu"][-1] == pytest.approx(0.5, rel=0.06)
    assert (tmp_path / "mu.png").is_file()
    budget = outcome.out.splitlines()[1]
    parts = [float(n) for n in re.findall(r"(?<= )0\.\d\d(?=[,;])", budget)]
    whole = 2 * found["mu_eff_std"][-1]
    assert "axle load" in budget
    assert "half-length of the contact" in budget
    # Those that are not told are less than a tenth of it each; the others are rounded to 0.01.
    assert np.hypot.reduce(parts) == pytest.approx(whole, rel=0.1)
    assert float(budget.partition("± ")[2].split()[0]) == pytest.approx(whole, abs=0.011)


@pytest.mark.usefixtures("mapped")
@pytest.mark.long
@pytest.mark.parametrize("name", ["car.mf4", "car.blf"])
def test_from_logs_to_a_report_in_one_command(
    run: Run, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {name: CAR_EFFECTS[name] for name in ("jacking", "zero_of_force")}
    monkeypatch.setattr("symbolic.vehicle.candidate_effects.CAR_EFFECTS", few)
    t, rack = steering(seconds=5.0)
    force = SimulatedCar().force(rack) + 2 * 80 * np.sin(rack / 0.125) / 0.125
    write_log(tmp_path / name, t, rack, force)
    outcome = run("diagnose", "--vehicle", "car.toml", name, "--out", "found", "--jobs", "1")
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text(encoding="utf-8"))

    assert outcome.status == 0
    assert [effect["name"] for effect in found["effects"]] == ["jacking"]
    assert found["effects"][0]["parameters"]["stiffness"]["value"] == pytest.approx(80, rel=0.1)
    assert "estimate takes no model.json of a car" in " ".join(outcome.out.split())
    assert (tmp_path / "found" / "report.html").is_file()


def test_the_model_found_of_a_car_is_its_vehicle_with_the_inclination_found(
    car: Path, tmp_path: Path
) -> None:
    t, rack = steering(seconds=2.0)
    path = write_columns(
        tmp_path / "a.csv", {"t": t, "rack": rack, "F_rack": SimulatedCar().force(rack)}
    )
    leaning = tmp_path / "leaning.toml"
    leaning.write_text(vehicle_text(inclination=0.3), encoding="utf-8")
    declared, changed = (gather_inputs([str(path)], vehicle=one) for one in (car, leaning))
    found = replace(make_diagnosis(("a",), ()), of_car=True, inclination=0.3)
    outcome = friction_by_both_models(
        declared.recordings(), [], found, by_inclination=declared.recordings(inclination=0.3)
    )  # fmt: skip
    without = friction_by_both_models(changed.recordings(), [], found)

    assert outcome is not None
    assert without is not None
    assert (outcome.inclination, without.inclination) == (0.3, None)
    mu = {label: outcome.tracks_of(label)["a"].mu[-1] for label in (EKF_DECLARED, EKF_FOUND)}
    assert mu[EKF_FOUND] == without.tracks_of(EKF_DECLARED)["a"].mu[-1] != mu[EKF_DECLARED]


def test_a_car_without_a_speed_is_said_to_be_taken_to_stand(run: Run, car: Path, tmp_path: Path) -> None:
    t, rack = steering(seconds=8.0)
    columns = {"t": t, "rack": rack, "F_rack": SimulatedCar().force(rack)}
    known = write_columns(tmp_path / "known.csv", columns | {"speed": 0 * t})
    unknown = write_columns(tmp_path / "unknown.csv", columns)
    of_car = ["--vehicle", car]
    alone = run("estimate", *of_car, unknown)
    both = " ".join(run("estimate", *of_car, known, unknown, "--jobs", 1).out.split())

    assert "as steeply as declared" not in alone.out
    soft = {"t": t, "rack": rack, "F_rack": SimulatedCar(k=4.7e6).force(rack)}
    told = " ".join(run("estimate", *of_car, write_columns(tmp_path / "soft.csv", soft)).out.split())
    assert re.search(r"the force rises about 0\.[456]\d? times as steeply as declared: susp", told)
    high = {"t": t, "rack": rack, "F_rack": 1.7 * SimulatedCar().force(rack)}
    told = " ".join(run("estimate", *of_car, write_columns(tmp_path / "high.csv", high)).out.split())
    assert "and friction is told too high by up to that factor" in told or "usable in 0 %" in told
    assert "unknown: no speed is recorded, so that the car is taken to stand" in alone.out
    assert "no speed is recorded" not in run("estimate", *of_car, known).out
    assert "1 of 2: no speed is recorded, so that the car is taken to stand" in both


def test_a_log_that_is_not_there_is_a_cars(run: Run, car: Path) -> None:
    outcome = run("estimate", "--vehicle", car, "nowhere.csv")

    outcome.refused("nowhere.csv: no such recording", "examples/car_log.py")
    assert "fetch" not in outcome.err


def test_code_of_a_car(run: Run, car: Path) -> None:
    to = ["--out", "c", "--name", "grip"]

    assert run("codegen", "--vehicle", car, "--observer", "ekf", *to).status == 0
    assert "grip_from_rack" in Path("c/grip_vehicle.h").read_text()
    for options in (["--torque", "M"], ["--ground", "ice"]):
        run("codegen", "--vehicle", car, *to, *options).refused("of a wheel on a rig; leave")


@pytest.mark.usefixtures("car")
@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--rig car.toml log.csv", "--rig and --vehicle are both given"),
        (
            "--model model.json log.csv",
            "a car takes no model.json: its model is the vehicle file; leave",
        ),
        ("--observer root log.csv", "knows no steering gear"),
        ("--observer ekf --smooth log.csv", "--smooth is for a wheel on a rig"),
        ("other.csv", "--map rack=RackTravel,F_rack=RackForce,brake=BrkPedal,speed=VehSpd"),
    ],
)
def test_what_is_not_for_a_car(run: Run, line: str, said: str) -> None:
    t, rack = steering(seconds=1.0)
    write_columns(Path("log.csv"), {"t": t, "rack": rack, "F_rack": SimulatedCar().force(rack)})
    Path("model.json").write_text('{"effects": ["jacking"]}')
    Path("other.csv").write_text("t,RackTravel,RackForce,VehSpd,BrkPedal\n0,0,0,0,1\n0.01,0.001,5,0,1\n")

    run("estimate", "--vehicle", "car.toml", *line.split(), "--out", "mu.csv").refused(said)


def test_messages_mend_the_log_of_an_assisted_car(run: Run) -> None:
    t, rack = steering()
    force = SimulatedCar().force(rack)
    text = vehicle_text(steering_ratio=12.5, motor_ratio=20.0, motor_efficiency=1.0, torsion_bar=115.0)
    Path("car.toml").write_text(text)
    bar = force / 100 / 13
    shown = {
        "Time": t, "LWI_Winkel Lenkrad": np.degrees(-100 * rack - bar / 115),
        "EPS_TorsBarTrq": 1e3 * bar, "EPS_MotTrq": bar * 12 / 20,
    }  # fmt: skip
    write_columns(Path("car.csv"), shown)
    command = ["estimate", "--vehicle", "car.toml", Path("car.csv")]
    pasted, said = list[str](), list[str]()
    while (outcome := run(*command, *pasted)).status:
        said.append(outcome.err)
        pasted = shlex.split(outcome.err[outcome.err.index("--map") :])

    assert len(said) == 2, said
    assert "missing; there are Time, LWI_Winkel Lenkrad, EPS_TorsBarTrq, EPS_MotTrq" in said[0]
    assert "handwheel looks like deg; T_bar looks like mN m; handwheel and the torques" in said[1]
    mended = "t=Time,handwheel=-LWI_Winkel Lenkrad:deg,T_bar=EPS_TorsBarTrq:mNm,T_motor=EPS_MotTrq"
    assert pasted[1] == mended
    assert "usable from" in outcome.out
    assert 0.45 < float(outcome.out.partition("mu_eff = ")[2].split()[0]) < 0.55


@pytest.mark.parametrize("tolerance", [0.15, 0.0])
def test_a_half_length_that_follows_from_the_load_has_its_error(tolerance: float) -> None:
    declared = declared_vehicle()
    tolerances = replace(declared.tolerances, half_length=tolerance)
    follows = replace(declared, half_length=None, tolerances=tolerances)

    assert "front_axle_load 8000 N (5.8%)" in declared_uncertainty_text(declared, brakes=True)
    told = declared_uncertainty_text(follows, brakes=True)
    assert float(told.partition("8000 N (")[2].partition("%")[0]) > 1.2 * 5.8
    assert "half_length follows from the load; weighing the front axle narrows that most" in told
