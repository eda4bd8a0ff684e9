"""What a diagnosis of a car names, and what it does not."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from identification import diagnose, read_recording
from identification.diagnosis.graded_effects import inclination_note_of_effect
from symbolic.vehicle.candidate_effects import CAR_EFFECTS
from symbolic.vehicle.steering import jacking_torque, mean_wheel_angle, rack_lever
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, declared_vehicle, steering

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize(
    ("candidate", "falls", "damping", "gear", "named"),
    [
        pytest.param("damping_of_joints", 0.3, 0.0, 200.0, False, marks=pytest.mark.long),
        pytest.param("gear_friction", 0.3, 0.0, 200.0, False, marks=pytest.mark.long),
        pytest.param("damping_of_joints", 0.0, 60.0, 200.0, True, marks=pytest.mark.long),
        ("gear_friction", 0.0, 0.0, 600.0, True),
    ],
)
def test_friction_that_falls_with_speed_is_neither_damping_nor_gear(
    tmp_path: Path, candidate: str, falls: float, damping: float, gear: float, named: bool
) -> None:
    t, rack = steering(seconds=5.0)
    rate = np.gradient(rack, t)
    share = 1 - falls * np.abs(rate) / (np.abs(rate) + 0.04)
    force = SimulatedCar(gear=gear).force(rack) * share + 2 * damping * rate / 0.125**2
    path = write_columns(tmp_path / "car.csv", {"t": t, "rack": rack, "F_rack": force})
    recording = read_recording(path, vehicle=declared_vehicle())
    found = diagnose([recording], candidates=[CAR_EFFECTS[candidate]], jobs=1)

    assert [effect.name for effect in found.effects] == [candidate] * named


def test_what_dissipates_beside_what_is_declared_gives_no_work() -> None:
    ranges = {name: CAR_EFFECTS[name].parameters[0] for name in ("gear_friction", "damping_of_joints")}

    assert {name: one.lower for name, one in ranges.items()} == dict.fromkeys(ranges, 0.0)


@pytest.mark.parametrize("sign", [-1, pytest.param(1, marks=pytest.mark.long)])
def test_a_return_torque_is_told_by_its_sign_with_the_key_that_has_it(tmp_path: Path, sign: int) -> None:
    declared = replace(declared_vehicle(), inclination=0.21)
    other = replace(declared, inclination=declared.inclination + sign * 0.07)
    t, rack = steering(seconds=10.0)
    by_kingpin = jacking_torque(other, mean_wheel_angle(other, rack))
    force = SimulatedCar().force(rack) + 2 * by_kingpin / rack_lever(declared, rack)
    path = write_columns(tmp_path / "car.csv", {"t": t, "rack": rack, "F_rack": force})
    recording = read_recording(path, vehicle=declared)
    found = diagnose([recording], candidates=[CAR_EFFECTS["jacking"]], jobs=1)
    (effect,) = found.effects
    (note,) = (note for note in found.notes if note.startswith("jacking"))
    inclination = float(re.search(r"beyond its tolerance; inclination = ([\d.]+) in", note)[1])

    more_or_less = "more" if sign > 0 else "less"
    assert effect.summary == (
        f"a torque that turns the wheels back to the middle, {more_or_less} than the declared kingpin's"
    )
    assert inclination == pytest.approx(other.inclination, abs=0.02)
    assert effect.grade in ("weak", "stands_in")
    assert found.inclination is None
    fitted = SimpleNamespace(labels=())
    clear = inclination_note_of_effect(replace(effect, grade="strong"), fitted, [recording])  # type: ignore[arg-type]
    assert clear[1] == pytest.approx(other.inclination, abs=0.02)
    assert note.endswith("have a second log confirm it before you declare it")
