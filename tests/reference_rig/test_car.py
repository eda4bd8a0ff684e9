"""The independent car against mechanics: limit moment, slope, energy, mirror image, play, presliding."""

from dataclasses import replace
from functools import lru_cache
from math import cos, inf, sin

import numpy as np
import pytest
from scipy.integrate import dblquad

from reference_rig import (
    CAR_STEP,
    TOLERANCES,
    Array,
    Car,
    CarBus,
    CarMotion,
    CarPatches,
    CarTyre,
    GearFriction,
    Joint,
    Kingpin,
    Linkage,
    SteeredCar,
    draw_car,
    handwheel_path,
    record_car,
    simulate_car,
)

TYRE = CarTyre(half_length=0.06, half_width=0.08, k=7e6, length_exponent=2.5)
STIFF = replace(TYRE, k=1e10)
CAR = replace(Car(), assistance=None, tyre=TYRE)
EVEN = replace(CAR, friction=replace(CAR.friction, asymmetry=0.0))


def turned(patches: CarPatches, yaw: float, *, about: complex = 0j, hold: float = 3000.0) -> Array:
    """Moment of the left wheel about its patch's middle, turned to an angle about a fixed point."""
    step = yaw / 400
    shift = -1j * step * about
    return np.array([patches.move((step, step), (shift, shift), (hold, hold))[2] for _ in range(400)])


@lru_cache
def swung(
    car: Car = EVEN, *, mirrored: bool = False, brake: bool = True, **settings: float
) -> CarMotion:
    """Two seconds of quick turning, to the left first."""
    step = settings.get("step", CAR_STEP)
    t = np.arange(0.0, 3.0, step)
    path = 3.5 * np.sin(np.pi * t / 1.5) ** 3
    grid = (64, 32) if settings.get("fine") else (32, 16)
    return simulate_car(car, -path if mirrored else path, brake=brake, step=step, grid=grid)


def test_full_slide_is_the_integral_of_pressure_times_arm() -> None:
    """Even load on a stiff tread: mu W times the mean distance from the middle."""
    n, m = STIFF.length_exponent, STIFF.width_exponent

    def pressure(y: float, x: float) -> float:
        return (1 - abs(x) ** n) * (1 - abs(y) ** m)

    def arm(y: float, x: float) -> float:
        return float(np.hypot(STIFF.half_length * x, STIFF.half_width * y)) * pressure(y, x)

    mean = dblquad(arm, 0, 1, 0, 1)[0] / dblquad(pressure, 0, 1, 0, 1)[0]
    assert turned(CarPatches(STIFF), 0.3)[-1] == pytest.approx(-3000 * mean, rel=5e-3)


def test_stick_slope_is_the_second_moment_of_the_springs() -> None:
    patches = CarPatches(TYRE, 60, 60)
    slope = turned(patches, 1e-4)[-1] / 1e-4
    second = (TYRE.half_length**2 + TYRE.half_width**2) / 3
    assert slope == pytest.approx(-2 * TYRE.half_length * TYRE.k * second, rel=0.02)


def test_a_turn_beside_the_middle_also_pushes() -> None:
    """Far from the patch the turn is a shift: the force is all that friction holds, the moment none."""
    patches = CarPatches(STIFF)
    moment = turned(patches, 0.01, about=-2j)[-1]
    force = patches.stiffness * patches.stretch[0].sum()
    assert force.real == pytest.approx(3000, rel=2e-3)
    assert abs(moment) < 0.1 * abs(turned(CarPatches(STIFF), 0.3)[-1])


def test_the_stop_only_dissipates() -> None:
    """Work put in is never less than what the springs have gained."""
    rng = np.random.default_rng(5)
    patches, work, lost = CarPatches(TYRE), 0.0, [0.0]
    for _ in range(600):
        yaw = float(3e-3 * rng.standard_normal())
        shift = complex(*(2e-4 * rng.standard_normal(2)))
        force, _, moment, _ = patches.move((yaw, 0.0), (shift, 0j), (3000.0, 3000.0))
        work -= moment * yaw + (force.conjugate() * shift).real
        lost.append(work - patches.energy)
    assert min(np.diff(lost)) > -1e-4 * max(lost)
    assert lost[-1] > 3 * patches.energy


def test_energy_of_the_whole_car_is_accounted_for() -> None:
    """Hands = gear + ground + lift + ball joints + what springs still hold."""
    car = replace(EVEN, yaw_stiffness=inf)
    motion = swung(car)
    dt = motion.t[1] - motion.t[0]
    spent = motion.energy["gear"]
    for side, wheel in ((1.0, "left"), (-1.0, "right")):
        steer = motion.channels[f"steer_{wheel}"]
        turn = np.diff(steer, prepend=steer[0])
        spent -= car.kingpin.upright * float(motion.channels[f"M_{wheel}"] @ turn)
        spent += car.wheel_damping * float(np.sum(turn**2)) / dt
        rise = np.array([car.kingpin.stand(side, angle)[0] for angle in steer[::20]])
        spent += float(motion.channels[f"load_{wheel}"][::20][1:] @ np.diff(rise))
    assert motion.energy["hands"] > 20
    assert motion.energy["hands"] == pytest.approx(spent, rel=0.03)


def test_mirror_image() -> None:
    """Turned the other way, left and right change places and every sign turns."""
    left, right = swung(), swung(mirrored=True)
    size = np.ptp(left.F_rack)
    np.testing.assert_allclose(right.F_rack, -left.F_rack, atol=1e-6 * size)
    np.testing.assert_allclose(right.M_right, -left.M_left, atol=1e-6 * np.ptp(left.M_left))
    np.testing.assert_allclose(right.load_right, left.load_left, atol=1e-6 * left.load_left[0])


def test_finer_grid_and_steps_change_little() -> None:
    reference = swung(fine=True)
    size = np.ptp(reference.F_rods)
    assert np.abs(swung().F_rods - reference.F_rods).max() < 0.02 * size
    half = swung(step=CAR_STEP / 2)
    assert np.abs(half.F_rods[::2][: len(swung().t)] - swung().F_rods).max() < 0.02 * size


def test_presliding_comes_before_friction() -> None:
    """Within a hundredth of a millimetre the gear is a spring; then it slides at its bound."""
    friction, dt = GearFriction(level=200.0, by_load=0.0, asymmetry=0.1, damping=0.0), 1e-4
    stretch, forces = 0.0, []
    for speed in [1e-3] * 2000 + [-1e-3] * 2000:
        stretch, force = friction.step(stretch, speed, 0.0, dt)
        forces.append(force)
    assert forces[9] == pytest.approx(friction.stiffness * 1e-6, rel=0.05)
    assert forces[1999] == pytest.approx(220.0, rel=0.02)
    assert forces[-1] == pytest.approx(-180.0, rel=0.02)
    assert forces[2000] > 200.0


def test_play_is_lost_between_rack_and_wheel() -> None:
    """Where a rod's force changes sign, the rack moves by the play and the wheel does not."""
    tight, loose = (replace(EVEN, rod=Joint(play=play)) for play in (0.0, 0.8e-3))
    lost = []
    for car in (tight, loose):
        motion = swung(car)
        straight = [car.linkage.steer(1.0, rack) for rack in motion.rack[::20]]
        lost.append(np.ptp(motion.steer_left[::20] - straight))
    assert lost[1] - lost[0] == pytest.approx(0.8e-3 / CAR.linkage.arm, rel=0.25)


def test_a_free_wheel_rolls_and_feels_no_scrub_radius() -> None:
    """With brakes a wheel is dragged about the kingpin; without them it runs round it."""
    none, wide = (
        replace(
            EVEN, yaw_stiffness=inf, free_yaw_stiffness=inf,
            kingpin=Kingpin(scrub_radius=scrub, trail=0.0, inclination=0.0, caster=0.0),
        )
        for scrub in (0.0, 0.06)
    )  # fmt: skip
    dragged, free, straight = (
        np.ptp(swung(car, brake=brake).M_left)
        for car, brake in ((wide, True), (wide, False), (none, True))
    )
    assert dragged > 1.2 * free
    assert free == pytest.approx(straight, rel=0.05)


def test_lift_is_that_of_a_hub_on_a_leaning_axis() -> None:
    """To second order: distance of the hub from the axis, times sin(sigma) psi²/2."""
    sigma, psi = 0.2, 0.05
    kingpin = Kingpin(inclination=sigma, caster=0.0, trail=0.0, scrub_radius=0.015, radius=0.3)
    distance = 0.015 * cos(sigma) + 0.3 * sin(sigma)
    rise = kingpin.stand(1.0, psi)[0]
    assert rise == pytest.approx(distance * sin(sigma) * psi**2 / 2, rel=0.01)
    assert kingpin.stand(1.0, 0.0)[1] == pytest.approx(0.015j)
    # With caster the wheels lift the body unlike each other: the load crosses over.
    leaning = replace(kingpin, caster=0.1)
    assert leaning.stand(1.0, 0.4)[0] > leaning.stand(1.0, -0.4)[0]


def test_the_linkage_closes_and_turns_the_inner_wheel_more() -> None:
    linkage = Linkage()
    for rack in (0.0, 0.02, 0.06):
        inner, outer = linkage.steer(1.0, rack), linkage.steer(-1.0, rack)
        assert linkage.gap(1.0, rack, inner) == pytest.approx(0.0, abs=1e-12)
        assert linkage.rack_at(1.0, inner) == pytest.approx(rack, abs=1e-9)
        assert inner >= outer - 1e-12
        assert linkage.steer(1.0, -rack) == pytest.approx(-outer, abs=1e-9)


def test_assistance_takes_most_of_the_work() -> None:
    light, heavy = swung(replace(EVEN, assistance=Car().assistance)), swung()
    assert np.abs(light.T_bar).max() < 0.25 * np.abs(heavy.T_bar).max()


def test_declared_values_are_off_within_their_tolerance() -> None:
    drawn, extreme = draw_car(7), draw_car(7, full_tolerance=True)
    for name, tolerance in TOLERANCES.items():
        true = drawn.true[name]
        assert abs(drawn.declared[name] - true) <= tolerance * abs(true) * (1 + 1e-12)
        declared = extreme.declared[name]
        assert abs(declared - true) == pytest.approx(tolerance * abs(declared))
    assert extreme.car == drawn.car
    assert draw_car(7, split=0.3).car.mu[1] == pytest.approx(0.3 * drawn.car.mu[0])


def test_a_recording_shows_steps_and_time_stamps_of_a_bus() -> None:
    bus = CarBus()
    recording = record_car(3, EVEN, swung(), bus=bus, brake=False)
    assert np.all(np.diff(recording.t) > 0)
    steps = recording.handwheel / bus.handwheel_step
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert np.all(recording.t - recording.taken > -1e-9)
    assert np.ptp(recording.handwheel) == pytest.approx(np.ptp(swung().handwheel), abs=0.01)
    assert set(recording.brake) == {0.0}


@pytest.mark.long
def test_a_drawn_car_is_driven_from_lock_to_lock() -> None:
    drawn = draw_car(3)
    recording = drawn.drive()
    assert np.ptp(recording.handwheel) > 1.8 * 0.9 * drawn.car.lock / drawn.car.pinion_radius
    assert set(recording.brake) == {float(drawn.brake)}


def test_a_driver_pauses_reverses_and_reaches_both_stops() -> None:
    path = handwheel_path(4, 9.0)
    rate = np.gradient(path, CAR_STEP)
    assert path.max() > 8.2
    assert path.min() < -8.2
    assert np.count_nonzero(np.diff(np.sign(rate[np.abs(rate) > 0.2]))) >= 3
    assert np.count_nonzero(np.abs(rate) < 0.1) * CAR_STEP > 1.0


def test_a_car_steered_by_samples_moves_as_along_a_path() -> None:
    ways = 1e-4 * np.arange(41)
    motion = simulate_car(Car(), ways, by_rack=True, every=1, grid=(6, 4))
    car = SteeredCar(Car(), brake=True, grid=(6, 4))
    forces = [car.turn(way, 20 * CAR_STEP) for way in (ways[20], ways[40])]

    # The path has one step more, at rest.
    assert car.rack == pytest.approx(motion.rack[-1], rel=1e-3)
    assert forces[1] == pytest.approx(motion.F_rack[-10:].mean(), rel=1e-3)
