"""What a diagnosis of a car names, and what it does not."""

from pathlib import Path

import numpy as np
import pytest

from identification import diagnose, read_recording
from symbolic.vehicle.candidate_effects import CAR_EFFECTS
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, declared_vehicle, steering


@pytest.mark.parametrize(
    ("candidate", "falls", "damping", "gear", "named"),
    [
        ("damping_of_joints", 0.3, 0.0, 200.0, False),
        ("gear_friction", 0.3, 0.0, 200.0, False),
        ("damping_of_joints", 0.0, 60.0, 200.0, True),
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
