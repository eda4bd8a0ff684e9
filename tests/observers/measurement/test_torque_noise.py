"""Noise of a torque channel from its samples, against the noise that was drawn."""

from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import Ekf, Status, run
from observers.layout import named, vector_of
from observers.measurement.torque_error import NOISE, update_sensor_noise_estimate
from reference_rig import RigTyre, free_path, simulate_bristles
from symbolic import Model, Rig
from symbolic.float_array_type import Array
from tests.observers.conftest import K
from tests.observers.factories import wrong_and_usable

SLIDE = 0.375 * 400.0 * 0.045
"""Full slide at mu = 1 of the rig that is steered here [N m]."""
USUAL, LEAST = 0.02**2, 0.005**2


@cache
def stepped() -> ca.Function:
    """One torque: (numbers of `NOISE`, M_z, dt) -> numbers."""
    before, M_z, dt = ca.SX.sym("before", len(NOISE)), ca.SX.sym("M_z"), ca.SX.sym("dt")
    after = update_sensor_noise_estimate(named(NOISE, before), M_z, dt, USUAL, LEAST)
    return ca.Function("noise", [before, M_z, dt], [vector_of(NOISE, after)])


def seen(M_z: Array, rate: float) -> float:
    """Standard deviation of 10 ms after these torques [N m]."""
    state: Any = np.zeros(len(NOISE))
    for torque in M_z:
        state = stepped()(state, torque, 1 / rate)
    return float(np.sqrt(np.asarray(state).ravel()[NOISE.index("variance")]))


@pytest.mark.parametrize("std", [0.004, 0.02, 0.3])
@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_white_noise_is_that_of_10_ms(std: float, rate: float) -> None:
    count = int(3 * rate)
    drawn = std * np.random.default_rng(5).standard_normal(count)
    # Beside it a torque that turns over within 0.3 s, and samples that are missing.
    M_z = 0.2 * np.tanh((np.arange(count) / rate - 1.5) / 0.15) + drawn
    M_z[::17] = np.nan
    assert seen(M_z, rate) == pytest.approx(std * min(1, np.sqrt(100 / rate)), rel=0.3)


def test_a_sensor_that_is_read_oftener_than_it_measures_is_as_noisy() -> None:
    drawn = 0.05 * np.random.default_rng(5).standard_normal(400)
    assert seen(np.repeat(drawn, 10), 1000.0) == pytest.approx(seen(drawn, 100.0), rel=1e-9)


def test_a_torque_that_comes_more_slowly_than_the_angle_is_as_noisy() -> None:
    drawn = 0.05 * np.random.default_rng(5).standard_normal(400)
    rare = np.where(np.arange(4000) % 10 == 0, np.repeat(drawn, 10), np.nan)
    assert seen(rare, 1000.0) == pytest.approx(seen(drawn, 100.0), rel=0.05)


def test_nothing_seen_is_the_usual_noise_and_silence_is_none() -> None:
    assert seen(np.zeros(1), 100.0) == pytest.approx(np.sqrt(USUAL))
    assert seen(np.zeros(300), 100.0) < 0.2 * np.sqrt(LEAST)
    # Noise that begins late is seen within a second and a half.
    late = np.concatenate([np.zeros(300), 0.05 * np.random.default_rng(5).standard_normal(150)])
    assert seen(late, 100.0) > 0.03


def test_corners_of_the_torque_are_not_its_noise() -> None:
    drawn = 0.01 * np.random.default_rng(5).standard_normal(400)
    corners = np.where(np.arange(400) // 60 % 2, 0.4, -0.4)
    assert seen(drawn + corners, 100.0) < 0.02


def steered(rate: float, mu: float, noise: float, seed: int = 3) -> tuple[Array, Array, Array, Array]:
    """Time, angle, load and torque of a wheel that swings for 6 s; noise of a sample over `SLIDE`."""
    t = np.arange(0, 6, 1 / rate)
    psi = np.where(t < 0.5, 0, 0.2 * np.sin(1.4 * (t - 0.5)))
    tyre = RigTyre(a=0.045, e=0.009, k=K, mu=mu)
    M_z = simulate_bristles(free_path(t, psi, load=400.0, rate=rate), tyre, bristles=300).M_z
    drawn = np.random.default_rng(seed).standard_normal(t.size)
    return t, psi, np.full(t.size, 400.0), M_z + noise * SLIDE * drawn


@pytest.mark.parametrize("mu", [0.05, pytest.param(0.8, marks=pytest.mark.long)])
@pytest.mark.parametrize("noise", [pytest.param(0.001, marks=pytest.mark.long), 0.004, 0.02])
@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_undeclared_noise_leaves_friction_usable(rate: float, noise: float, mu: float) -> None:
    t, psi, F_N, M_z = steered(rate, mu, noise)
    estimates = run(Ekf(model=Model(), values={"k": K}, rig=Rig(a=0.045, e=0.009)), t, psi, F_N, M_z)

    assert estimates.usable.mean() > 0.25
    assert np.mean(estimates.status & Status.INCONSISTENT != 0) < 0.05
    assert not wrong_and_usable(estimates, mu).any()


def test_the_torque_of_a_lifted_wheel_is_not_its_noise() -> None:
    t, psi, F_N, M_z = steered(100.0, 0.8, 0.004)
    observer = Ekf(model=Model(), values={"k": K}, rig=Rig(a=0.045, e=0.009))
    light = (t > 0.1) & (t < 0.4)
    wild = np.where(light, M_z + 5 * (-1.0) ** np.arange(t.size), M_z)
    missing = np.where(light, np.nan, M_z)
    load = np.where(light, 1.0, F_N)
    one, other = (run(observer, t, psi, load, torque) for torque in (wild, missing))
    np.testing.assert_array_equal(one.mu, other.mu)
