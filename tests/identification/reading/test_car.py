"""Recordings of a car: columns, units, standstills, and what is refused."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from identification import read_recording, read_vehicle
from symbolic import InvalidInputError, vehicle_from_tables
from tests.identification.reading.logs import refused
from tests.simulated_car import vehicle_text

T = 0.01 * np.arange(60)
RACK = 0.02 * np.sin(5 * T)
FORCE = 1000 * np.sign(np.cos(5 * T))
CAR = vehicle_from_tables(tomllib.loads(vehicle_text()))


def write(path: Path, **columns: object) -> Path:
    table = np.column_stack(
        [np.broadcast_to(np.asarray(c, dtype=float), T.shape) for c in columns.values()]
    )
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return path


def test_the_mean_wheel_of_a_recording(tmp_path: Path) -> None:
    recording = read_recording(write(tmp_path / "car.csv", t=T, rack=RACK, F_rack=FORCE), vehicle=CAR)

    np.testing.assert_allclose(recording.psi, RACK / 0.125, rtol=1e-9)
    np.testing.assert_allclose(recording.M_z, -0.125 / 2 * FORCE, rtol=1e-9)
    np.testing.assert_array_equal(recording.F_N, 4000.0)
    assert recording.standstills is not None
    assert recording.standstills.brakes == (True,)


def test_units_and_names_of_a_log(tmp_path: Path) -> None:
    path = write(tmp_path / "car.csv", t=T, Way=1e3 * RACK, Force=-FORCE / 1e3)
    mapped = read_recording(path, vehicle=CAR, signals="rack=Way:mm,F_rack=-Force:kN")
    plain = read_recording(write(tmp_path / "b.csv", t=T, rack=RACK, F_rack=FORCE), vehicle=CAR)

    np.testing.assert_allclose(mapped.M_z, plain.M_z, rtol=1e-9)
    np.testing.assert_allclose(mapped.psi, plain.psi, rtol=1e-9)


def test_from_torsion_bar_and_motor(tmp_path: Path) -> None:
    text = vehicle_text(steering_ratio=12.5, torsion_bar=100.0, motor_ratio=20.0, motor_efficiency=1.0)
    car = vehicle_from_tables(tomllib.loads(text))
    bar = 0.2 * np.sign(FORCE)
    path = write(
        tmp_path / "car.csv",
        t=T,
        handwheel=RACK / 0.01 + bar / 100,
        T_bar=bar,
        T_motor=(FORCE / 100 - bar) / 20,
    )
    recording = read_recording(path, vehicle=car)

    np.testing.assert_allclose(recording.psi, RACK / 0.125, atol=1e-9)
    np.testing.assert_allclose(recording.M_z, -0.125 / 2 * FORCE, rtol=1e-6)


def test_rolling_and_brakes_part_the_standstills(tmp_path: Path) -> None:
    speed, brake = np.where((T > 0.2) & (T < 0.3), 1.0, 0.0), np.where(T < 0.45, 1.0, 0.0)
    path = write(tmp_path / "car.csv", t=T, rack=RACK, F_rack=FORCE, brake=brake, speed=speed)
    recording = read_recording(path, vehicle=CAR)
    standstills = recording.standstills

    assert standstills is not None
    assert standstills.brakes == (True, True, False)
    np.testing.assert_array_equal(np.isnan(recording.M_z), speed > 0)
    np.testing.assert_array_equal(standstills.stretch < 0, speed > 0)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"F_rack": FORCE}, "channel rack or handwheel missing"),
        ({"rack": RACK}, "channel F_rack or T_bar missing"),
        ({"handwheel": RACK, "T_bar": FORCE / 1e3, "T_motor": 0.0}, "motor_ratio"),
        ({"rack": RACK, "F_rack": FORCE, "speed": 3.0}, "the car never stands"),
        ({"rack": 100 * RACK, "F_rack": FORCE}, "in another unit"),
    ],
)
def test_what_is_refused(tmp_path: Path, columns: dict[str, object], said: str) -> None:
    path = write(tmp_path / "car.csv", t=T, **columns)

    assert said in refused(lambda one: read_recording(one, vehicle=CAR), path)


def test_a_bad_vehicle_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "car.toml"
    path.write_text("[vehicle]\ntyre = 3\n")

    with pytest.raises(InvalidInputError, match=r"car\.toml: \[vehicle\] front_axle_load, pressure"):
        read_vehicle(path)
