"""`brushgrip identify` of a car, and the vehicle file that it writes."""

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from brushgrip.outputs.rig_and_vehicle_files import plate_changes, tyre_changes
from identification import ParameterEstimate
from identification.steering.gear_friction_on_plates import PlatesResult
from identification.steering.tyres_on_known_friction import TyresResult
from symbolic import InvalidInputError, vehicle_from_tables
from symbolic.vehicle.steering import jacking_torque
from tests.brushgrip.helpers import Run, table_of
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, declared_vehicle, on_plates, steering, vehicle_text

pytestmark = pytest.mark.usefixtures("interpreted")


def test_the_vehicle_file_is_written_with_what_was_found(run: Run, tmp_path: Path) -> None:
    t, s, force = on_plates()
    write_columns(tmp_path / "p.csv", {"t": t, "RackTravel": 1e3 * s, "F_rack": force})
    signals = '[signals]\nrack = { channel = "RackTravel", unit = "mm" }\n'
    text = vehicle_text(inclination=0.2, brakes="true") + signals
    (tmp_path / "car.toml").write_text(text)
    files = {"--out": tmp_path / "id.json", "--write-vehicle": tmp_path / "new.toml"}
    given = ["--vehicle", tmp_path / "car.toml", "--plates", tmp_path / "p.csv"]
    outcome = run("identify", *given, *(one for pair in files.items() for one in pair))
    found = json.loads((tmp_path / "id.json").read_text())["plates"]
    names = ("car.toml", "new.toml")
    declared, written = (tomllib.loads((tmp_path / name).read_text()) for name in names)
    new = vehicle_from_tables(written)

    assert outcome.status == 0
    assert abs(new.gear_friction - 200.0) < new.tolerances.gear_friction * new.gear_friction
    assert new.tolerances.gear_friction < 0.5
    assert 0 <= new.inclination < 0.02, "its kingpins are upright"
    assert found["gear_friction"]["unit"] == "N"
    # 2 2/3 4000 N of a circle of 0.066 m in radius over 0.125 m, nearly.
    assert re.search(r"each 0\.01 more, .* is told as 2\d N of gear", " ".join(outcome.out.split()))
    assert written["signals"] == {"rack": {"channel": "RackTravel", "unit": "mm", "factor": 1.0}}
    for key in {*written["vehicle"], *declared["vehicle"]} - {"gear_friction", "damping", "inclination"}:
        assert written["vehicle"][key] == declared["vehicle"][key]


def test_a_damping_below_zero_is_told_and_not_written(run: Run) -> None:
    t, s, force = on_plates()
    write_columns(Path("p.csv"), {"t": t, "rack": s, "F_rack": force - 4500 * np.gradient(s, t)})
    Path("car.toml").write_text(vehicle_text(brakes="true"))
    given = ("--vehicle", "car.toml", "--plates", "p.csv", "--write-vehicle", Path("new.toml"))
    outcome = run("identify", *given)

    assert "damping is below zero, as if gear friction fell with speed: the file gets 0" in outcome.err
    assert tomllib.loads(Path("new.toml").read_text())["vehicle"]["damping"] == 0


def test_a_return_torque_that_no_kingpin_has_is_refused() -> None:
    car = declared_vehicle(inclination=0.2)
    values = {"gear_friction": 200.0, "damping": 30.0, "return_torque": -0.5, "zero": 90.0}
    found = {name: ParameterEstimate(value=value, std=2.0, unit="") for name, value in values.items()}
    result = PlatesResult(**found, samples=1000, rms=10.0)

    with pytest.raises(InvalidInputError, match=r"which no kingpin inclined by 0 to 0\.5 rad has"):
        plate_changes(car, result)
    found["return_torque"] = ParameterEstimate(value=1.2, std=0.1, unit="1")
    changes = plate_changes(car, PlatesResult(**found, samples=1000, rms=10.0))
    new = replace(car, inclination=changes["inclination"])  # type: ignore[arg-type]

    assert jacking_torque(new, 0.5) == pytest.approx(1.2 * jacking_torque(car, 0.5), rel=0.01)
    assert changes["force_zero"] == 90.0
    # A fifth and a quarter are allowed for what plates and the day change.
    assert changes["gear_friction"] == pytest.approx((200, 40))
    assert changes["damping"] == pytest.approx((30, 7.5))
    for damping, written in ((-1.0, (2.0, 1.8)), (-5.0, 0.0)):
        found["damping"] = ParameterEstimate(value=damping, std=2.0, unit="")
        assert plate_changes(car, PlatesResult(**found, samples=1000, rms=10.0))["damping"] == written


def ground_log(**of_file: object) -> list[object]:
    """The arguments for a car that steered from lock to lock on ground of mu 0.8, its file written."""
    t, rack = steering()
    force = SimulatedCar(mu=(0.8, 0.8)).force(rack)
    write_columns(Path("g.csv"), {"t": t, "rack": rack, "F_rack": force})
    Path("car.toml").write_text(vehicle_text(**of_file))
    return ["--vehicle", "car.toml", "--lock-to-lock", "g.csv"]


def test_tyres_go_into_the_vehicle_file(run: Run) -> None:
    log = ground_log(brakes="true")
    given = [*log, "--ground-friction", 0.8, "--friction-tolerance", 0.02]
    outcome = run("identify", *given, "--write-vehicle", Path("new.toml"))
    new = vehicle_from_tables(tomllib.loads(Path("new.toml").read_text()))

    assert outcome.status == 0
    assert new.slide_factor == pytest.approx(1, abs=0.05)
    assert 0.02 / 0.8 < new.tolerances.slide_factor < 0.055
    assert new.tolerances.load == pytest.approx(0.03)
    assert new.slide_load == new.front_axle_load == 8000
    assert "# on ground of mu 0.8 ± 0.02, load 8000 N\n" in Path("new.toml").read_text()
    assert "unexplained, of full slide (rms)" in outcome.out
    assert outcome.err == "", "no warning"
    assert new.tolerances.stiffness < 0.165
    assert "slide_factor holds for a front axle load of 8000 N" in outcome.out

    # With the file that was written, friction rests on these two.
    told = run("estimate", "--vehicle", Path("new.toml"), Path("g.csv")).out

    assert "measured torque of full slide 0.0" in told
    assert "half-length" not in told


def test_a_doubtful_slide_factor_is_warned_of(run: Run) -> None:
    outcome = run("identify", *ground_log(brakes="true"), "--ground-friction", 0.6)

    assert outcome.status == 0
    assert outcome.err.count("\n") == 1
    assert "standard deviations from what the vehicle file declares: check --ground" in outcome.err
    assert "all later friction is wrong by it" in outcome.err


def test_tyres_are_written_with_room_for_fuel_and_the_length_under_the_load() -> None:
    weighed = {"front_axle_load": "{ value = 9600.0, tolerance = 96.0 }", "slide_load": 8000.0}
    car = declared_vehicle(slide_factor=1.1, **weighed)
    one = ParameterEstimate(value=1.1, std=0.05, unit="1")
    found = TyresResult(slide_factor=one, stiffness=one, samples=9, rms=1.0, rest=0.02, deviations=0.5)
    changes = tyre_changes(car, found)

    assert changes["front_axle_load"] == pytest.approx((9600, 0.03 * 9600))
    assert changes["slide_load"] == 9600
    assert changes["half_length"] == pytest.approx((0.066, 0.15 * 0.066))
    assert "half_length" not in tyre_changes(replace(car, half_length=None), found)
    assert "half_length" not in tyre_changes(replace(car, slide_load=None), found)


def test_friction_stays_usable_under_the_load_that_is_declared_since(run: Run) -> None:
    log = ground_log(brakes="true")
    run("identify", *log, "--ground-friction", 0.8, "--write-vehicle", Path("new.toml"))
    changed = Path("new.toml").read_text().replace("{ value = 8000.0, tolerance = 240.0 }", "9600.0")
    Path("loaded.toml").write_text(changed)
    t, rack = steering()
    force = SimulatedCar(mu=(0.8, 0.8), load=4800.0, half_length=0.066).force(rack)
    write_columns(Path("l.csv"), {"t": t, "rack": rack, "F_rack": force})
    run("estimate", "--vehicle", Path("loaded.toml"), Path("l.csv"), "--out", Path("mu.csv"))
    told = table_of(Path("mu.csv"))
    usable = told["usable"] > 0

    assert "9600.0" in changed
    assert usable[-1]
    assert usable.mean() > 0.3
    assert told["mu"][-1] == pytest.approx(0.8, rel=0.06)


@pytest.mark.parametrize(
    ("of_file", "options", "said"),
    [
        ({"brakes": "true"}, [], "--lock-to-lock needs the friction of the ground"),
        ({}, ["--ground-friction", 0.8], "whether the brakes held the wheels is not known"),
        ({"brakes": "true"}, ["--ground-friction", 0], "must be known to less than itself, got 0"),
        ({}, ["--ground-friction", 0.8, "--plates", "p.csv"], "give --free-decay, with --rig"),
    ],
)
def test_tyres_are_refused_where_ground_or_brakes_are_not_known(
    run: Run, of_file: dict[str, object], options: list[object], said: str
) -> None:
    run("identify", *ground_log(**of_file), *options).refused(said)
