"""What a diagnosis of a car names, and what it does not."""

from pathlib import Path

import numpy as np
import pytest

from identification import diagnose, read_recording
from symbolic.vehicle.candidate_effects import CAR_EFFECTS
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, declared_vehicle, steering

DAMPING = "damping_of_joints"


@pytest.mark.parametrize(
    ("falls", "damping", "named"),
    [pytest.param(0.3, 0.0, [], id="friction falls"), pytest.param(0.0, 60.0, [DAMPING], id="damping")],
)
def test_friction_that_falls_with_speed_is_no_damping_of_joints(
    tmp_path: Path, falls: float, damping: float, named: list[str]
) -> None:
    t, rack = steering(seconds=5.0)
    rate = np.gradient(rack, t)
    force = SimulatedCar().force(rack) * (1 - falls * np.abs(rate) / (np.abs(rate) + 0.04))
    columns = {"t": t, "rack": rack, "F_rack": force + 2 * damping * rate / 0.125**2}
    path = write_columns(tmp_path / "car.csv", columns)
    recording = read_recording(path, vehicle=declared_vehicle())
    found = diagnose([recording], candidates=[CAR_EFFECTS[DAMPING]], jobs=1)

    assert [effect.name for effect in found.effects] == named
