"""Motion of both measurement models beside what the textbook filter shows: noises, the wheel's path."""

from math import inf
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from observers import AligningTorque, MeasurementModel, SteeringTorque, Tuning
from observers.measurement.measurement_model import CLEAN
from observers.measurement.motion_and_torque_jacobians import (
    build_linearised_measurement,
    build_linearised_motion,
    slope_states,
)
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG
from tests.observers.factories import slide

NUMBERS = np.array([RIG.a, RIG.e, RIG.J_A, RIG.b_t, RIG.slide_rate, np.nan, np.nan, np.nan])
TUNING = Tuning(zero_time=3.0, stiffness_walk=0.01, noise=0.5, error=inf)
CHOICES = [(zero, stiffness) for zero in (False, True) for stiffness in (False, True)]
MEASUREMENT_MODELS = [
    kind(zero=z, stiffness=s) for kind in (AligningTorque, SteeringTorque) for z, s in CHOICES
]
MEANINGS = {"log_mu": 0.1, "M_0": 0.2, "stiffness": 0.9, "psi": 0.03, "psi_dot": -0.4}


def clean(**values: float) -> Array:
    usual = {"psi": 0.03, "psi_dot": 0.1, "F_N": 410.0, "dt": 0.008, "M_z": -3.0, "M": 2.5, "M_age": 0.0,
             "F_N_first": 400.0, "travel": 0.001}  # fmt: skip
    return np.array([(usual | values).get(name, 0.0) for name in CLEAN])


def motion_of(
    measurement_model: MeasurementModel, x: Array, M_z: float, slopes: Array, **settings: Any
) -> tuple[Array, ...]:
    last, now = settings.get("last", clean(dt=0.012)), settings.get("now", clean())
    tuning = settings.get("tuning", TUNING)
    made = build_linearised_motion(measurement_model)(x, M_z, slopes, last, now, NUMBERS, tuning.vector)
    x_next, A, Q, b = (np.asarray(part) for part in made)
    np.testing.assert_allclose(b.ravel(), x_next.ravel() - A @ x, rtol=0, atol=1e-12)
    return x_next.ravel(), A, Q.ravel()


def usual_x(measurement_model: MeasurementModel) -> Array:
    return np.array([MEANINGS[name] for name in measurement_model.states])


@pytest.mark.parametrize("measurement_model", MEASUREMENT_MODELS, ids=repr)
@pytest.mark.parametrize("last_dt", [0.0, 0.01])
def test_into_an_empty_place_nothing_moves(measurement_model: MeasurementModel, last_dt: float) -> None:
    x, slopes = usual_x(measurement_model), np.ones(len(slope_states(measurement_model)))
    empty = clean(dt=0.0, M=0.0, M_z=0.0)
    x_next, A, Q = motion_of(measurement_model, x, 3.0, slopes, last=clean(dt=last_dt), now=empty)
    linearised = build_linearised_measurement(measurement_model)
    weight = linearised(x, 3.0, slopes, empty, NUMBERS, TUNING.vector)[2]

    np.testing.assert_array_equal(x_next, x)
    np.testing.assert_array_equal(A, np.eye(x.size))
    np.testing.assert_array_equal(Q, 0.0)
    assert float(weight) == 0


@pytest.mark.parametrize("measurement_model", MEASUREMENT_MODELS[3::4], ids=repr)
def test_walks_grow_with_time_and_not_with_samples(measurement_model: MeasurementModel) -> None:
    walks = {"mu_walk": 0.1, "zero_walk": 0.02, "stiffness_walk": 0.3}
    tuning = Tuning(**walks, noise=0.2, error=inf, error_travel=0.0)
    x, slopes = usual_x(measurement_model), np.zeros(len(slope_states(measurement_model)))
    of_a_second = []
    for steps in (np.full(100, 0.01), np.full(1000, 0.001), np.random.default_rng(1).random(300)):
        steps, total = steps / steps.sum(), 0.0
        for before, dt in zip([steps[0], *steps[:-1]], steps, strict=True):
            clocks = {"last": clean(dt=before), "now": clean(dt=dt)}
            total = total + motion_of(measurement_model, x, 0.0, slopes, tuning=tuning, **clocks)[2]
        of_a_second.append(dict(zip(measurement_model.states, total, strict=True)))

    level = slide(410.0)
    expected = {"log_mu": 0.01, "M_0": (0.02 * level) ** 2, "stiffness": 0.09, "psi": 0.0}
    expected["psi_dot"] = 0.01 * (0.2 * level / NUMBERS[2]) ** 2
    for found in of_a_second:
        for name, variance in found.items():
            assert variance == pytest.approx(expected[name], rel=0.01), name


def test_a_held_steering_torque_is_worth_less_the_longer_it_is_held() -> None:
    x, slopes = np.zeros(3), np.zeros(2)
    doubt = {
        time: motion_of(SteeringTorque(zero=False), x, 0.0, slopes, last=clean(M_age=time))[2][2]
        for time in (0.0, 0.05, 0.1, 5.0)
    }
    kick, slide = 0.008, 0.375 * 410.0 * RIG.a

    # Half of full slide after half the time, all of it from then on, each time for a tenth of a second.
    for time, share in ((0.05, 0.5), (0.1, 1.0), (5.0, 1.0)):
        assert doubt[time] - doubt[0.0] == pytest.approx((share * slide / RIG.J_A) ** 2 * 0.1 * kick)


SPRING = 65.0
"""A patch that sticks [N m/rad]; with the rig's inertia it swings at 3.3 Hz."""


def push(t: Any) -> Any:
    return 3.0 * np.sin(2.0 * t) * np.exp(-0.3 * t)


def leapfrogged(steps: Array) -> tuple[Array, Array]:
    """Angle at the samples and rate in the middle before each, the wheel driven by `push`."""
    measurement_model = SteeringTorque(zero=False)
    times = np.concatenate([[0.0], np.cumsum(steps)])
    x, made = np.array([1.0, 0.0, 0.0]), []
    last = clean(psi=0.0, M=push(0.0), dt=0.0)
    for t, dt in zip(times[1:], steps, strict=True):
        now = clean(dt=dt, M=push(t))
        slopes = np.array([-SPRING, 0.0])
        x, *_ = motion_of(measurement_model, x, -SPRING * x[1], slopes, last=last, now=now)
        made.append(x[1:])
        last = now
    angle, rate = np.array(made).T
    return angle, rate


def exactly(times: Array) -> Array:
    def motion(t: float, y: Array) -> list[float]:
        return [y[1], (push(t) - SPRING * y[0] - RIG.b_t * y[1]) / RIG.J_A]

    solution = solve_ivp(motion, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-11, atol=1e-13)
    return np.asarray(solution.y)


@pytest.mark.parametrize("jitter", [pytest.param(0.0, marks=pytest.mark.long), 0.6])
def test_wheel_on_a_spring_follows_its_equation_of_motion_to_second_order(jitter: float) -> None:
    pattern = 1 + jitter * np.random.default_rng(2).uniform(-1, 1, 500)
    errors = []
    for fine in (1, 2, 4):
        steps = np.repeat(0.004 * pattern, fine) / fine
        angle, rate = leapfrogged(steps)
        times = np.cumsum(steps)
        psi = exactly(times)[0]
        middle = exactly(times - steps / 2)[1]
        errors.append([np.abs(angle - psi).max(), np.abs(rate - middle).max()])
    errors_of_angle, errors_of_rate = np.array(errors).T

    assert errors_of_angle[-1] < 1e-4 * np.ptp(psi)
    assert (errors_of_angle[:-1] / errors_of_angle[1:] > 3.0).all(), errors_of_angle
    assert (errors_of_rate[:-1] / errors_of_rate[1:] > 3.0).all(), errors_of_rate


def test_undamped_wheel_keeps_its_energy_and_damping_takes_it() -> None:
    motion = build_linearised_motion(SteeringTorque(zero=False))
    for b_t, keeps in ((0.0, True), (RIG.b_t, False), (1e4, False)):
        x, energy = ca.DM([1.0, 0.01, 0.0]), []
        for _ in range(2000):
            numbers = [RIG.a, RIG.e, RIG.J_A, b_t, *NUMBERS[4:]]
            at = clean(M=0.0, dt=0.01)
            x = motion(x, -SPRING * x[1], [-SPRING, 0.0], at, at, numbers, TUNING.vector)[0]
            energy.append(0.5 * RIG.J_A * float(x[2]) ** 2 + 0.5 * SPRING * float(x[1]) ** 2)
        late, early = max(energy[-200:]), max(energy[:200])
        assert late == pytest.approx(early, rel=0.01) if keeps else late < early
