"""The steered wheel against mechanics: oscillation, decay, balance, energy, runaway, convergence."""

import numpy as np
import pytest

from reference_rig import MOTION_STEP as STEP
from reference_rig import (
    Array,
    Grip,
    Hand,
    RigTyre,
    SteeredMotion,
    SteeringRecording,
    Wheel,
    friction_step,
    full_slide_moment,
    hand_path,
    jitter_instants,
    make_steering_recording,
    simulate_steering,
)

LOAD = 400.0
TYRE = RigTyre()
WHEEL = Wheel()
STIFFNESS = 2 * TYRE.a * TYRE.k * (TYRE.e**2 + TYRE.a**2 / 3)
"""Sticking, q = -(x - e) psi: M_z = -psi times the integral of k (x - e)² over the patch [N m/rad]."""
FULL = full_slide_moment(TYRE, TYRE.mu * LOAD)


def push(torque: Array, wheel: Wheel = WHEEL) -> SteeredMotion:
    """Impose a torque at constant load and friction."""
    n = len(torque)
    return simulate_steering(torque, np.full(n, LOAD), np.full(n, TYRE.mu), wheel=wheel)


def plucked(wheel: Wheel) -> SteeredMotion:
    """A push so short and weak that every bristle sticks in what follows."""
    return push(np.where(np.arange(20001) < 10, 0.2, 0.0), wheel)


def swaying(count: int, level: float) -> Array:
    """A torque of two tones, up to a level [N m]."""
    t = np.arange(count) * STEP
    return level / 2 * (np.sin(5.0 * t) + np.sin(8.3 * t))


def crossings(motion: SteeredMotion) -> Array:
    """Instants at which the angle passes zero upwards [s], after the push."""
    psi = motion.psi
    up = np.flatnonzero((psi[:-1] < 0) & (psi[1:] >= 0))
    return motion.t[up] - psi[up] * STEP / (psi[up + 1] - psi[up])


def clean(seed: int = 3, **settings: object) -> SteeringRecording:
    return make_steering_recording(seed, noise=0.0, encoder_step=0.0, **settings)  # type: ignore[arg-type]


def test_damped_wheel_decays() -> None:
    motion = plucked(WHEEL)
    decay = WHEEL.b_t / (2 * WHEEL.J_A)
    period = 2 * np.pi / np.sqrt(STIFFNESS / WHEEL.J_A - decay**2)

    times = crossings(motion)
    speeds = np.interp(times, motion.t, motion.psi_dot)

    np.testing.assert_allclose(np.diff(times), period, rtol=1e-4)
    np.testing.assert_allclose(np.diff(np.log(speeds)), -decay * period, rtol=1e-3)
    assert len(times) > 8


def test_work_is_motion_damping_and_friction() -> None:
    motion = push(swaying(50001, 1.1 * FULL))

    def work(torque: Array) -> Array:
        power = torque * motion.psi_dot
        return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * STEP)])

    kinetic = 0.5 * WHEEL.J_A * motion.psi_dot**2
    into_patch = work(-motion.M_z)
    spent = kinetic + WHEEL.b_t * work(motion.psi_dot) + into_patch
    np.testing.assert_allclose(work(motion.M), spent, rtol=0, atol=1e-5 * spent[-1])
    # A virgin patch has nothing to give.
    assert into_patch.min() > -1e-12
    assert into_patch[-1] > 1.0


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 6))])
def test_hand_slides_fully_and_reverses(seed: int) -> None:
    made = clean(seed)
    used = made.M_z_true / full_slide_moment(TYRE, 1.0) / (TYRE.mu * made.F_N)
    rate = made.psi_dot_true[np.abs(made.psi_dot_true) > 0.01]

    assert used.min() < -0.95
    assert used.max() > 0.95
    assert np.count_nonzero(np.diff(np.sign(rate))) >= 3
    assert np.max(np.abs(rate)) < 1.0
    assert np.max(np.abs(made.psi_true)) < 0.7


def test_hand_pulls_towards_its_path() -> None:
    made = clean(4, grip=Grip(stiffness=150.0, damping=5.0), hand=Hand(), duration=6.0)
    path = hand_path(4, 12.0)

    # The path is run through at double tempo.
    psi = np.interp(2 * made.t, path.t, path.psi)
    psi_dot = 2 * np.interp(2 * made.t, path.t, path.psi_dot)
    pull = 150.0 * (psi - made.psi_true) + 5.0 * (psi_dot - made.psi_dot_true)
    np.testing.assert_allclose(made.M_true, pull, rtol=0, atol=1e-9)


def test_recorded_torque_repeats_the_motion() -> None:
    made = clean(duration=3.0)

    again = clean(torque=made.M_true, duration=3.0)

    np.testing.assert_allclose(again.M_true, made.M_true, atol=1e-12)
    np.testing.assert_allclose(again.psi_true, made.psi_true, atol=2e-6)
    np.testing.assert_allclose(again.M_z_true, made.M_z_true, atol=1e-4)


def test_torque_needs_a_value_a_sample() -> None:
    with pytest.raises(ValueError, match="needs 10001 samples"):
        clean(torque=np.zeros(10))


def test_friction_may_fall_while_turning() -> None:
    made = clean(friction=friction_step(3.0, 1.2, 0.5), duration=6.0)
    limit = full_slide_moment(TYRE, 1.0) * made.mu_true * made.F_N

    assert set(made.mu_true) == {0.5, 1.2}
    assert made.tyre.mu == 1.2
    assert np.all(np.abs(made.M_z_true) <= limit * (1 + 1e-4))
    assert np.max(np.abs(made.M_z_true[made.t < 3])) > 1.5 * limit[-1]


def test_uneven_samples_lie_on_the_same_motion() -> None:
    even = clean(duration=3.0)
    times = jitter_instants(1, np.arange(301) / 100, spread=0.03)

    made = clean(duration=3.0, times=times)

    np.testing.assert_array_equal(made.t, times)
    np.testing.assert_allclose(made.psi_true, np.interp(times, even.t, even.psi_true), atol=1e-5)
