"""Gear friction, return torque and zero from a car whose front wheels stand on plates."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.car_files import vehicle_toml
from identification.reading.car_as_mean_wheel import RackRecording, read_rack_recording
from identification.steering.gear_friction_on_plates import identify_on_plates
from reference_rig import CAR_STEP, FleetCar, draw_car, record_car, simulate_car
from symbolic import InvalidInputError, vehicle_from_tables
from symbolic.vehicle.steering import (
    jacking_torque,
    mean_wheel_angle,
    rack_force,
    rack_lever,
    rack_position,
)
from tests.columns import write_columns
from tests.simulated_car import BOTH_WAYS, Array, declared_vehicle, drive, on_plates

CAR = declared_vehicle()
PLATES = 0.002
"""Friction of turntables [1]."""


def plates(**given: float) -> RackRecording:
    t, s, force = on_plates(**given)  # type: ignore[arg-type]
    return RackRecording(name="plates", t=t, s=s, force=force, brakes=True)


def test_gear_damping_and_zero_come_back() -> None:
    vehicle = replace(CAR, gear_friction=150.0)
    result = identify_on_plates([plates()], vehicle)

    for name, true in (("gear_friction", 200.0), ("damping", 3000 * 0.125**2 / 2), ("zero", 20.0)):
        found = result.parameters[name]
        assert found.std is not None
        # Plates that are better than supposed leave the gear by half of that behind.
        assert abs(found.value - true) < 3 * found.std, name
        assert found.std < 0.05 * true


def test_damping_is_about_the_kingpin_where_the_lever_shrinks_to_the_locks() -> None:
    vehicle = replace(CAR, gear_friction=150.0, lever_loss=0.25)
    t, s, force = on_plates()
    rate = np.gradient(s, t)

    def with_damping(about: float) -> RackRecording:
        drag = 2 * about * rate / rack_lever(vehicle, s) ** 2
        return RackRecording(name="plates", t=t, s=s, force=force - 3000 * rate + drag, brakes=True)

    found = identify_on_plates([with_damping(24.0)], vehicle).damping
    assert found.std is not None
    assert abs(found.value - 24) < 3 * found.std < 0.15 * 24
    with pytest.raises(InvalidInputError, match=r"plates: damping about one kingpin is 2\d\d N m s/rad"):
        identify_on_plates([with_damping(230.0)], vehicle)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"mu": 0.1}, "the plates hold the tyres"),
        ({"speeds": (1.5,) * 5}, "at one speed to a side"),
        ({"speeds": (1.5, 1.6, 1.52, 1.58, 1.5)}, "at one speed to a side"),
        ({"speeds": (1.2, 2.5, 1.2, 2.5, 1.2)}, "at one speed to a side"),
        ({"drift": 300.0}, "turn from lock to lock slowly and back quickly"),
        ({"reach": 0.03}, "turn it beyond 0.045 m to either side"),
        ({"speeds": (30.0,) * 5}, "allowed: from 200 on"),
    ],
)
def test_what_would_be_wrong_is_refused(given: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        identify_on_plates([plates(**given)], replace(CAR, gear_friction=150.0))  # type: ignore[arg-type]


@pytest.mark.parametrize("share", [0.7, 0.8])
def test_a_force_that_is_clipped_near_the_locks_is_refused(tmp_path: Path, share: float) -> None:
    vehicle = replace(CAR, inclination=0.2)
    t, s, force = on_plates()
    force = 10 * np.round((force + 2 * jacking_torque(vehicle, s / 0.125) / 0.125) / 10)

    def read(shown: Array) -> RackRecording:
        columns = {"t": t, "rack": s, "F_rack": shown}
        return read_rack_recording(write_columns(tmp_path / "p.csv", columns), vehicle)

    most = share * np.abs(force).max()
    with pytest.raises(InvalidInputError, match="clips it, and looks like less return torque"):
        identify_on_plates([read(np.clip(force, -most, most))], vehicle)
    found = identify_on_plates([read(force)], vehicle).return_torque

    assert found.std is not None
    assert abs(found.value - 1) < 3 * found.std


def independent(drawn: FleetCar) -> dict[str, Array]:
    """Columns of an independent car on turntables."""
    car = replace(drawn.car, mu=(PLATES, PLATES))
    path = drive(0.95 * car.lock / car.pinion_radius, BOTH_WAYS, CAR_STEP)
    path = path * (car.pinion_radius if drawn.by_rack else 1.0)
    motion = simulate_car(car, path, brake=True, by_rack=drawn.by_rack)
    shown = record_car(drawn.seed, car, motion, bus=drawn.bus)
    names = ("t", "rack", "F_rack", "handwheel", "T_bar", "T_motor")
    rods = {"F_rods": np.interp(shown.taken, motion.t, motion.F_rods)}
    return {name: getattr(shown, name) for name in names} | rods


@pytest.mark.long
@pytest.mark.parametrize("seed", range(300, 312))
def test_independent_cars_within_a_tenth(seed: int) -> None:
    drawn = draw_car(seed)
    vehicle = vehicle_from_tables(tomllib.loads(vehicle_toml(drawn.declared, brake=True)))
    seen = independent(drawn)
    by_hand = rack_position(vehicle, seen["handwheel"], seen["T_bar"])
    told = rack_force(vehicle, seen["T_bar"], seen["T_motor"])
    for s, force in ((seen["rack"], seen["F_rack"]), (by_hand, told)):
        one = RackRecording(name="plates", t=seen["t"], s=s, force=force, brakes=True)
        result = identify_on_plates([one], vehicle)
        friction = result.gear_friction
        near_lock = np.abs(np.abs(s) - 0.8 * vehicle.rack_travel) < 3e-3
        lift = 2 * jacking_torque(vehicle, mean_wheel_angle(vehicle, s)) / rack_lever(vehicle, s)
        # What the rods put on the rack, to either side, is what lifts the body.
        lifted = np.mean(np.abs(seen["F_rods"][near_lock])) / np.mean(np.abs(lift[near_lock]))
        print(f"{seed}: {friction.value:.0f} ± {friction.std:.0f} of {drawn.car.friction.level:.0f} N,"
              f" return torque {result.return_torque.value / lifted:.3f} of the car's")  # fmt: skip

        assert friction.value == pytest.approx(drawn.car.friction.level, rel=0.1)
        assert abs(friction.value - drawn.car.friction.level) < 3 * (friction.std or 0)
        assert result.return_torque.value == pytest.approx(lifted, rel=0.1)
