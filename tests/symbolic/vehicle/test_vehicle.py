"""A vehicle from its file, its steering, and its mean wheel."""

import re
from dataclasses import replace
from math import cos, radians

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symbolic import InvalidInputError, Rig, Vehicle, VehicleTolerances, rig_of, vehicle_from_tables
from symbolic.masing import virgin_torque
from symbolic.patch_moment_by_zones import full_slide_arm
from symbolic.rig_and_tyre import EVEN
from symbolic.vehicle.contact_about_kingpin import (
    contact_growth_at_full_lock,
    contact_offset_from_kingpin,
)
from symbolic.vehicle.mean_wheel import (
    aligning_torque_with_friction,
    equivalent_contact_angle,
    mu_std_by_cause,
)
from symbolic.vehicle.steering import (
    jacking_torque,
    mean_wheel_angle,
    pinion_angle_from_rack,
    rack_and_gain,
    rack_force,
    rack_lever,
    rack_position,
)
from tests.refusal import refused

CAR = Vehicle(front_axle_load=8000.0, tyre_width=0.2, pressure=2.4e5, wheelbase=2.6, track=1.5)
TABLE = {
    "front_axle_load": 8000.0,
    "tyre": "195/65 R15",
    "pressure": 2.2e5,
    "wheelbase": 2.5,
    "track": 1.5,
}


def lowest_point(car: Vehicle, psi: float, side: int) -> np.ndarray:
    """The lowest of many points of the rim, less the kingpin's point at that height."""
    axis = np.array([-np.tan(car.caster), -side * np.tan(car.inclination), 1.0])
    turn = Rotation.from_rotvec(psi * axis / np.linalg.norm(axis))
    around = np.linspace(0, 2 * np.pi, 200_001)
    axle = np.array([-car.trail, side * car.scrub_radius, car.wheel_radius])
    rim = axle + car.wheel_radius * np.stack([np.sin(around), 0 * around, np.cos(around)], axis=1)
    points = turn.apply(rim)
    low = points[np.argmin(points[:, 2])]
    return np.array([*(low - axis / axis[2] * low[2])[:2], low[2]])


def test_five_numbers_are_enough() -> None:
    car = vehicle_from_tables({"vehicle": TABLE})

    # 4000 N on 90 % of it over 2.2 bar, on 80 % of 195 mm.
    assert car.a == pytest.approx(0.9 * 4000 / 2.2e5 / (2 * 0.8 * 0.195))
    assert car.wheel_radius == pytest.approx(0.1905 + 0.8 * 0.65 * 0.195)
    assert 3e6 < car.k < 3e7


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"tyre": "wide"}, "tyre must be a size"),
        ({"pressure": 2.4}, "pressure must lie between"),
        ({"wheel": 3}, "unknown key"),
        ({"half_length": {"value": 0.05}}, "half_length: write"),
        ({"brakes": "on"}, "brakes must be true or false"),
        ({"track": True}, "track must be a number"),
    ],
)
def test_what_a_file_must_not_hold(changed: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        vehicle_from_tables({"vehicle": TABLE | changed})


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"inclination": 10.0}, "inclination must lie between -0.1 and 0.5 rad, got 10; 10 looks like"),
        ({"inclination": 10.0}, "; 10 looks like degrees: 0.175"),
        ({"pressure": 2.4}, "; 2.4 looks like bar: 2.4e5"),
        ({"front_axle_load": 7.9}, "; 7.9 looks like kN: 7.9e3"),
        ({"rack_travel": 84}, "; 84 looks like mm: 0.084"),
        # All at once.
        ({"caster": 6.7, "pressure": 2.4}, "2.4 looks like bar: 2.4e5; caster must lie between"),
    ],
)
def test_a_number_in_another_unit_is_told_in_its_own(changed: dict[str, float], said: str) -> None:
    with pytest.raises(InvalidInputError, match=re.escape(said)):
        vehicle_from_tables({"vehicle": TABLE | changed})
    with pytest.raises(InvalidInputError) as error:
        vehicle_from_tables({"vehicle": TABLE | {"pressure": 1e9}})
    assert "looks like" not in str(error.value)


def test_tolerances_of_a_file_may_have_a_percent_sign() -> None:
    table = TABLE | {"half_length": {"value": 0.05, "tolerance": "20%"}, "geometry": {"tolerance": "5%"}}
    car = vehicle_from_tables({"vehicle": table})

    assert car.tolerances.half_length == pytest.approx(0.2)
    assert car.tolerances.geometry == pytest.approx(0.05)


def test_tolerances_of_a_file_are_shares() -> None:
    table = TABLE | {
        "half_length": {"value": 0.05, "tolerance": 0.01},
        "geometry": {"tolerance": 0.05},
        "force_scale": {"tolerance": 0.08},
    }
    car = vehicle_from_tables({"vehicle": table})

    assert car.tolerances.half_length == pytest.approx(0.2)
    assert car.tolerances.geometry == 0.05
    assert car.tolerances.force_scale == 0.08
    assert car.tolerances.load == VehicleTolerances().load


def test_the_lever_is_the_derivative_of_the_angle() -> None:
    s, step = np.linspace(-0.07, 0.07, 15), 1e-6
    by_differences = 2 * step / (mean_wheel_angle(CAR, s + step) - mean_wheel_angle(CAR, s - step))

    np.testing.assert_allclose(rack_lever(CAR, s), by_differences, rtol=1e-6)
    assert rack_lever(CAR, CAR.rack_travel) == pytest.approx((1 - CAR.lever_loss) * CAR.steering_arm)


@pytest.mark.parametrize("psi", [-0.5, 0.2, 0.6])
def test_the_body_is_lifted_by_both_wheels(psi: float) -> None:
    car = replace(CAR, trail=0.03, scrub_radius=0.02)
    sides, beside = (1, -1), (psi - 0.01, psi + 0.01)
    heights = [sum(-lowest_point(car, at, side)[2] for side in sides) / 2 for at in beside]
    # Turning lowers the wheels below the kingpins: it lifts the body.
    expected = car.wheel_load * (heights[1] - heights[0]) / 0.02

    assert jacking_torque(car, psi) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("side", [1, -1])
def test_where_a_wheel_stands(side: int) -> None:
    car = replace(CAR, trail=0.03, scrub_radius=0.02)
    behind, outside = contact_offset_from_kingpin(car, 0.5, side)
    found = lowest_point(car, 0.5, side)

    assert np.hypot(behind, outside) == pytest.approx(np.hypot(*found[:2]), abs=2e-4)
    assert contact_offset_from_kingpin(car, 0.0, side) == pytest.approx((0.03, 0.02))


def test_upright_kingpins_turn_the_contact_alike_everywhere() -> None:
    upright = replace(CAR, inclination=0.0, caster=0.0)
    growth = contact_growth_at_full_lock(upright, brakes=True)

    assert (growth.torque, growth.stiffness) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert equivalent_contact_angle(upright, 0.4, brakes=True) == pytest.approx(0.4)
    assert contact_growth_at_full_lock(CAR, brakes=True).torque > 0.05


@pytest.mark.parametrize("turn", [0.005, 0.02, 0.05, 0.1, 0.3])
@pytest.mark.parametrize("scrub_radius", [0.0, 0.05])
def test_one_line_turns_as_hard_as_a_contact(turn: float, scrub_radius: float) -> None:
    mu, rng = 0.7, np.random.default_rng(3)
    car = replace(CAR, trail=0.0, scrub_radius=scrub_radius, inclination=0.0, caster=0.0)
    rig, tyre = rig_of(car, brakes=True)
    x, y = rng.uniform(-1, 1, (2, 200_000))
    arm = np.hypot(car.a * x, car.patch_width / 2 * y + scrub_radius)
    # 7/5 and 9/8 make the mean pressure that of the load; shoulders bear less.
    limit = mu * 63 / 40 * (1 - np.abs(x) ** 2.5) * (1 - y**8) * car.wheel_load
    limit /= 2 * car.a * car.patch_width
    # Rods, joints and suspension take a tenth of the stiffness.
    stress = np.minimum(0.9 * car.k / car.patch_width * arm * turn, limit)
    expected = float((stress * arm).mean() * 2 * car.a * car.patch_width)
    slide = float((limit * arm).mean() * 2 * car.a * car.patch_width)
    found = -float(virgin_torque(turn, car.wheel_load, mu, tyre.k, rig.a, rig.e))

    assert found == pytest.approx(expected, abs=0.015 * slide)


def test_tolerances_reach_the_wheel() -> None:
    none = dict.fromkeys(("load", "half_length", "stiffness", "geometry", "force_scale"), 0.0)
    sure = replace(CAR, tolerances=VehicleTolerances(**none))
    wide, narrow = rig_of(CAR)[0].tolerances, rig_of(sure)[0].tolerances
    k, identified = rig_of(sure)[1].k, rig_of(replace(sure, slide_factor=1.0))[0].tolerances

    assert isinstance(rig_of(CAR)[0], Rig)
    assert wide.tolerance_or_zero("load") > 0.1 > narrow.tolerance_or_zero("load")
    # Rods and suspension take more or less of it, by 10 % as a standard deviation.
    assert narrow.tolerance_or_zero("k") == pytest.approx(0.1 / EVEN * k, rel=0.05)
    assert wide.tolerance_or_zero("k") > 1.5 * narrow.tolerance_or_zero("k")
    assert identified.tolerance_or_zero("k") == 0, "the measured one has them in it"


@pytest.mark.parametrize("half_length", [None, 0.05])
def test_the_load_is_in_the_half_length_where_that_follows_from_it(half_length: float | None) -> None:
    car = replace(CAR, half_length=half_length)
    heavy = replace(car, front_axle_load=1.02 * car.front_axle_load)
    slides = [each.wheel_load * full_slide_arm(1.0, 0.7) * rig_of(each)[0].a for each in (car, heavy)]
    growth = np.log(slides[1] / slides[0]) / np.log(1.02)

    # Any value within a tolerance is as likely; that of the load is 10 %.
    of_load = mu_std_by_cause(car, brakes=True)["front_axle_load"]
    assert of_load == pytest.approx(0.1 * EVEN * growth, rel=0.01)


def test_the_scale_of_the_force_is_in_friction_until_the_tyres_are_identified() -> None:
    rough = replace(CAR, tolerances=VehicleTolerances(force_scale=0.2))
    floors = [rig_of(car)[0].tolerances.scale ** 2 for car in (rough, CAR)]

    # Tolerances of the scale add up in quadrature.
    assert floors[0] - floors[1] == pytest.approx(0.2**2 - 0.05**2)
    assert "force_scale" not in mu_std_by_cause(replace(rough, slide_factor=1.1), brakes=True)


def test_force_on_the_rack_as_torque_of_a_wheel() -> None:
    plain = replace(CAR, inclination=0.0, caster=0.0, lever_loss=0.0, rack_mass=100.0)

    # 20 N m s of each wheel at 0.4 rad/s, 1 kg m^2 of each at 16 rad/s^2.
    expected = pytest.approx(-0.125 / 2 * 800 + 20 * 0.4 + 16)
    assert aligning_torque_with_friction(plain, 0.01, 1000.0, 0.05, 2.0, brakes=False) == expected
    # 0.04 kg m^2 before a pinion of 10 mm a radian are 400 kg more.
    by_hand = replace(plain, steering_ratio=12.5, handwheel_inertia=0.04)
    assert aligning_torque_with_friction(by_hand, 0.01, 1800.0, 0.05, 2.0, brakes=False) == expected


def test_from_the_handwheel() -> None:
    car = replace(CAR, steering_ratio=12.5, torsion_bar=100.0, motor_ratio=20.0, motor_efficiency=0.5)

    # 10 mm of rack a radian of the pinion, which 2 N m twist by 0.02 rad.
    assert rack_position(car, 1.0, 2.0) == pytest.approx(0.01 * 0.98)
    assert rack_force(car, 2.0, 1.0) == pytest.approx((2.0 + 10.0) / 0.01)


def test_a_ratio_that_varies() -> None:
    pairs = ((1.0, 0.008), (2.0, 0.018), (4.0, 0.042))
    car = replace(
        CAR, rack_by_handwheel=pairs, torsion_bar=100.0, motor_ratio=20.0, motor_efficiency=0.5
    )
    angles = np.array([-7.0, -4.0, -1.5, -1e-3, 0.0, 1.0, 2.0, 3.0, 4.0, 4.1, 50.0])
    ways, gains = rack_and_gain(car, angles)

    assert ways[[1, 4, 5, 6, 8]] == pytest.approx([-0.042, 0.0, 0.008, 0.018, 0.042])
    # Straight on beyond the last pair, 12 mm a radian, and alike to the right.
    assert ways[[0, 9, 10]] == pytest.approx([-0.078, 0.0432, 0.594])
    assert gains[[0, 4, 8, 10]] == pytest.approx([0.012, 0.008, 0.012, 0.012])
    step = (rack_and_gain(car, angles + 1e-6)[0] - rack_and_gain(car, angles - 1e-6)[0]) / 2e-6
    assert gains == pytest.approx(step, rel=1e-4)
    assert pinion_angle_from_rack(car, ways) == pytest.approx(angles, abs=1e-6)
    assert np.isnan(rack_and_gain(car, np.array([np.nan]))).all()
    assert rack_force(car, 2.4, 1.0, 5.0) == pytest.approx(2.4 / 0.012 + 10.0 / 0.008)
    assert "angle of the pinion" in refused(rack_force, car, 2.0)
    one = replace(CAR, rack_by_handwheel=np.array([[1.0, 0.01]]))  # type: ignore[arg-type]
    assert one.rack_by_handwheel == ((1.0, 0.01),)
    assert rack_position(one, 3.0, 0.0) == pytest.approx(0.03)
    assert one.rack_gain == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ([[0.0, 0.0], [1.5, 0.012], [1.5, 0.02]], "rack_by_handwheel must have pairs of rad and m"),
        ([[1.5, 0.012], [3.0, 0.011]], "1.5, 0.012"),
        ([[1.5, 12.0]], "0.06 m/rad"),
        ([[90.0, 0.012]], "0.00125 to"),
        ([[0.25, 0.0115], [0.5, 0.0251]], "a steering ratio of 2.72 straight ahead"),
        ([[86.0, 1.1], [172.0, 2.4], [458.0, 7.5]], "7.5 m from the middle, more than 0.2 m; angles"),
        ([[float("inf"), float("inf")]], "rack_by_handwheel"),
        ([[1.5, "wide"]], "rack_by_handwheel"),
        ([], "rack_by_handwheel: write"),
        ([[0, 0]], "rack_by_handwheel has no pair beside the middle"),
        ([[1.5, 0.012, 3]], "write [[rad, m], ...]"),
        (15.0, "write [[rad, m], ...]"),
    ],
)
def test_pairs_of_a_ratio_that_are_refused(entry: object, message: str) -> None:
    table = {"vehicle": TABLE | {"rack_by_handwheel": entry}}
    assert message in refused(vehicle_from_tables, table)
    table["vehicle"]["steering_ratio"] = 15.0
    assert "in place of steering_ratio" in refused(vehicle_from_tables, table)


def test_a_leaning_kingpin_takes_part_of_the_torque() -> None:
    leaning = replace(CAR, trail=0.0, scrub_radius=0.0, inclination=radians(15), caster=0.0)
    arm = rig_of(leaning)[0].a / rig_of(replace(leaning, inclination=0.0))[0].a

    assert arm == pytest.approx(cos(radians(15)))
