"""Recordings of a car: columns, units, standstills, and what is refused."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, read_recording, read_signals, read_vehicle
from observers import RackSampler
from symbolic import Vehicle
from tests.columns import write_columns
from tests.refusal import refused
from tests.simulated_car import declared_vehicle, vehicle_text

pytestmark = pytest.mark.usefixtures("interpreted")

T = 0.01 * np.arange(60)
RACK = 0.035 * np.sin(5 * T)
FORCE = 1000 * np.sign(np.cos(5 * T))
CAR = declared_vehicle()
MOTOR = {"steering_ratio": 12.5, "motor_ratio": 20.0, "motor_efficiency": 1.0}


def late(signal: np.ndarray) -> np.ndarray:
    """The middle of the samples of the last 60 ms, or of as many as there are."""
    return signal[[0, 1, 1, 2, 2, 3, *range(3, len(signal) - 3)]]


def write(folder: Path, **columns: object) -> Path:
    """A log with its time; of way and force of the rack where no columns are given."""
    return write_columns(folder / "car.csv", {"t": T, **(columns or {"rack": RACK, "F_rack": FORCE})})


def read(path: Path, signals: str = "", vehicle: Vehicle = CAR) -> Recording:
    return read_recording(path, vehicle=vehicle, signals=signals)


def test_the_mean_wheel_of_a_recording(tmp_path: Path) -> None:
    recording = read(write(tmp_path))

    np.testing.assert_allclose(recording.psi, late(RACK) / 0.125, rtol=1e-9)
    np.testing.assert_allclose(recording.M_z, -0.125 / 2 * late(FORCE), rtol=1e-9)
    np.testing.assert_array_equal(recording.F_N, 4000.0)
    assert recording.standstills is not None
    assert recording.standstills.brakes == (True,)


def test_units_and_names_of_a_log(tmp_path: Path) -> None:
    columns = {"stamp": T, "Way": RACK, "Force": FORCE, "TorsionBarTorque": FORCE}
    message = refused(read, write_columns(tmp_path / "a.csv", columns), "rack=Way,F_rack=Force")
    assert re.search(r"channel t missing.*such as --map (?!.*M_z)", message)
    mapped = read(write(tmp_path, Way=1e3 * RACK, Force=-FORCE / 1e3), "rack=Way:mm,F_rack=-Force:kN")
    plain = read(write(tmp_path))

    np.testing.assert_allclose(mapped.M_z, plain.M_z, rtol=1e-9)
    np.testing.assert_allclose(mapped.psi, plain.psi, rtol=1e-9)


def test_a_file_with_columns_of_its_own_is_told_the_map_that_reads_it(tmp_path: Path) -> None:
    path = write(tmp_path)
    message = refused(read, path, "rack=Way:mm,F_rack=Force")
    assert message.count("F_rack (as") == 1
    mapped = read(path, message.partition("such as --map ")[2])
    np.testing.assert_array_equal(mapped.M_z, read(path).M_z)


def test_samples_one_by_one_are_those_of_the_recording(tmp_path: Path) -> None:
    heavy = declared_vehicle(rack_mass=12.0, damping=20.0, inclination=0.2)
    recording, sample_of = read(write(tmp_path), vehicle=heavy), RackSampler(heavy, brakes=True)
    samples = [sample_of(*row) for row in zip(T.tolist(), RACK.tolist(), FORCE.tolist(), strict=True)]

    np.testing.assert_allclose([s.psi for s in samples], recording.psi, rtol=1e-12)
    np.testing.assert_allclose([s.M_z for s in samples], recording.M_z, rtol=1e-9)
    np.testing.assert_allclose([s.dt for s in samples], 0.01)
    assert {s.F_N for s in samples} == {4000.0}
    # What is refused leaves no trace.
    for wrong in (T[-1], T[-1] - 100.0, float("nan"), float("inf")):
        assert "time must rise" in refused(sample_of, wrong, 0.0, 0.0)
    assert sample_of(T[-1] + 0.01, RACK[-1], FORCE[-1]).dt == pytest.approx(0.01)


def test_the_geometry_is_worked_out_once_for_all_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    sample_of = RackSampler(CAR)
    sample_of(0.0, 0.0, 0.0)
    monkeypatch.setattr("symbolic.vehicle.contact_about_kingpin.contact_offset_from_kingpin", None)
    assert sample_of(0.001, 0.01, -1000.0).M_z == pytest.approx(0.125 / 2 * 1000.0)


def test_from_torsion_bar_and_motor(tmp_path: Path) -> None:
    car = declared_vehicle(**MOTOR, torsion_bar=100.0)
    bar = 0.2 * np.sign(FORCE)
    handwheel, motor = RACK / 0.01 + bar / 100, (FORCE / 100 - bar) / 20
    recording = read(write(tmp_path, handwheel=handwheel, T_bar=bar, T_motor=motor), vehicle=car)

    np.testing.assert_allclose(recording.psi, late(RACK) / 0.125, atol=1e-9)
    np.testing.assert_allclose(recording.M_z, -0.125 / 2 * late(FORCE), rtol=1e-6)


@pytest.mark.parametrize("way", ["handwheel", "rack"])
def test_from_a_steering_whose_ratio_varies(tmp_path: Path, way: str) -> None:
    angles = np.linspace(-6, 6, 100_001)
    ways, gains = 0.008 * angles + 1e-4 * angles**3, 0.008 + 3e-4 * angles**2
    pairs = [[angle, 0.008 * angle + 1e-4 * angle**3] for angle in (0.0, 1.0, 2.0, 3.0, 4.5, 6.0)]
    text = vehicle_text(
        rack_by_handwheel=pairs, motor_ratio=20.0, motor_efficiency=1.0, torsion_bar=100.0
    )
    (tmp_path / "car.toml").write_text(text, encoding="utf-8")
    pinion = np.interp(RACK, ways, angles)
    # The motor has a gear of its own; the torsion bar's torque acts through the pinion.
    bar, motor = 0.3 * FORCE * np.interp(pinion, angles, gains), 0.7 * FORCE * 0.008 / 20
    columns = {"handwheel": pinion + bar / 100, "rack": RACK}
    path = write(tmp_path, **{way: columns[way]}, T_bar=bar, T_motor=motor)
    recording = read(path, vehicle=read_vehicle(tmp_path / "car.toml"))

    np.testing.assert_allclose(recording.psi, late(RACK) / 0.125, atol=5e-4)
    np.testing.assert_allclose(recording.M_z, -0.125 / 2 * late(FORCE), rtol=0.02)


def test_drag_and_inertia_are_taken_off_where_they_act(tmp_path: Path) -> None:
    way, speed, acceleration = 1.6e-2 * T**2, 3.2e-2 * T, 3.2e-2 + 0 * T
    # 16 N m s and 1 kg m^2 of each of two wheels, through a lever of 0.125 m.
    force = FORCE + 2 * 16 / 0.125**2 * speed + (400 + 2 / 0.125**2) * acceleration
    car = declared_vehicle(damping=16.0, rack_mass=400.0)
    recording = read(write(tmp_path, rack=way, F_rack=force), vehicle=car)

    np.testing.assert_allclose(recording.M_z[6:], -0.125 / 2 * late(FORCE)[6:], rtol=1e-6)


def test_rolling_and_brakes_part_the_standstills(tmp_path: Path) -> None:
    speed, brake = np.where((T > 0.2) & (T < 0.3), 1.0, 0.0), np.where(T < 0.45, 1.0, 0.0)
    recording = read(write(tmp_path, rack=RACK, F_rack=FORCE, brake=brake, speed=speed))
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
        ({"handwheel": RACK, "T_bar": FORCE / 1e3}, "declare handwheel_inertia"),
        ({"rack": RACK, "F_rack": FORCE, "speed": 3.0}, "the car never stands"),
        ({"rack": RACK, "F_rack": FORCE, "speed": np.nan}, "the car never stands"),
    ],
)
def test_what_is_refused(tmp_path: Path, columns: dict[str, object], said: str) -> None:
    assert said in refused(read, write(tmp_path, **columns))


def test_the_handwheel_is_not_taken_off_a_force_on_the_rack(tmp_path: Path) -> None:
    said = refused(read, write(tmp_path), vehicle=declared_vehicle(handwheel_inertia=0.035))
    assert "F_rack is measured below the handwheel" in said


def test_a_bad_vehicle_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "car.toml"
    path.write_text("[vehicle]\ntyre = 3\n")

    assert "car.toml: [vehicle] front_axle_load, pressure" in refused(read_vehicle, path)


BAR = FORCE / 100 / 13
ASSISTED = {"handwheel": 100 * RACK + BAR / 115, "T_bar": BAR, "T_motor": BAR * 12 / 20}
DEGREES = 180 / np.pi


def spoilt(**factors: float) -> dict[str, object]:
    measured = {"rack": RACK, "F_rack": FORCE} if {"rack", "F_rack"} & {*factors} else ASSISTED
    return {name: factors.get(name, 1.0) * values for name, values in measured.items()}


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (spoilt(handwheel=DEGREES), "handwheel looks like deg"),
        (spoilt(handwheel=-1.0), "handwheel and the torques have opposite signs"),
        (spoilt(T_bar=1e3), "T_bar looks like mN m"),
        (spoilt(T_motor=1e3), "T_motor looks like mN m"),
        (spoilt(T_bar=-1.0), "T_bar and T_motor act against each other"),
        (spoilt(T_motor=-1e3), "T_motor looks like mN m; T_bar and T_motor act against"),
        (spoilt(rack=1e3), "rack looks like mm"),
        (spoilt(F_rack=-1e-3), "F_rack looks like kN; rack and F_rack have opposite signs"),
        ({"Rack Pos": RACK, "F_rack": FORCE}, "channel rack or handwheel missing"),
        ({"Angle_Hand:Wheel": spoilt()["handwheel"], **spoilt(rack=1e3)}, "rack looks like mm"),
        (
            {"handwheel": ASSISTED["handwheel"], "T_bar": BAR, "MotTrq": ASSISTED["T_motor"]},
            "T_motor, and motor_ratio of the vehicle go together",
        ),
    ],
)  # fmt: skip
def test_what_a_message_proposes_mends_the_recording(
    tmp_path: Path, columns: dict[str, object], said: str
) -> None:
    car = declared_vehicle(**MOTOR, torsion_bar=115.0)
    path = write(tmp_path, **columns)
    message = refused(read, path, vehicle=car)
    (remedy,) = shlex.split(message.partition("--map ")[2])
    mended = read(path, remedy, car)

    assert said in message
    # To the other side is the same to all but the sign.
    np.testing.assert_allclose(np.abs(mended.M_z), np.abs(0.125 / 2 * late(FORCE)), rtol=1e-6)
    np.testing.assert_allclose(np.abs(mended.psi), np.abs(late(RACK) / 0.125), atol=1e-6)


def test_a_name_that_no_option_holds_goes_into_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, **{"Rack:XCP": -RACK, "F_rack": FORCE})
    named = f'signals = {{ rack = "Rack:XCP" }}\n{vehicle_text()}'
    (tmp_path / "car.toml").write_text(named)
    message = refused(read_recording, path, vehicle=CAR, signals=read_signals(tmp_path / "car.toml"))
    (tmp_path / "car.toml").write_text(f"{message.partition('in its place: ')[2]}\n{vehicle_text()}")
    mended = read_recording(path, vehicle=CAR, signals=read_signals(tmp_path / "car.toml"))

    np.testing.assert_allclose(mended.psi, late(RACK) / 0.125, atol=1e-9)
    assert mended.sources["rack"].channel == "Rack:XCP"


def test_a_handwheel_that_the_motor_drags_along_is_no_fault(tmp_path: Path) -> None:
    rate = np.gradient(ASSISTED["handwheel"], T)
    dragged = -0.05 * rate - 0.02 * np.gradient(rate, T)
    motor = (FORCE / 100 - dragged) / 20
    path = write(tmp_path, handwheel=100 * RACK, T_bar=dragged, T_motor=motor)
    read(path, vehicle=declared_vehicle(**MOTOR))


@pytest.mark.parametrize(
    "columns",
    [
        # A gear that hardly moves puts little force on the rack, and tyres that unwind turn the wheels.
        {"rack": 0.01 * RACK, "F_rack": 0.01 * FORCE},
        {"rack": -0.02 * T, "F_rack": 1000 * (1 - T / 0.4)},
        # Single samples are glitches.
        {**ASSISTED, "T_motor": ASSISTED["T_motor"] + 1e3 * (T[30] == T)},
    ],
)  # fmt: skip
def test_what_is_no_other_unit_and_no_other_sign(tmp_path: Path, columns: dict[str, object]) -> None:
    car = declared_vehicle(**MOTOR) if "T_motor" in columns else CAR

    read(write(tmp_path, **columns), vehicle=car)
