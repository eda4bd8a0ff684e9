"""More than five zones, made by bristles that know no zones: where the method of [Györök 2022] ends."""

import numpy as np
import pytest

from observers import Ekf, Mhe, Observer, RootObserver, Tuning, run
from reference_rig import MOTION_STEP as STEP
from reference_rig import RigTyre, SteeredMotion, Wheel, simulate_steering
from symbolic import Model, Rig

RIG, K, LOAD, SECONDS = Rig(a=0.04, e=0.01), 6e4, 180.0, 5.11
KNOTS = ((0.0, 0.4), (1.4, 0.8), (2.4, -0.4), (3.4, 0.5), (4.3, -0.2), (6.0, 0.8))
"""Steering torque for mu = 0.5, of which it is a multiple [s], [N m]; the wheel of [Györök 2022]."""
CLEAN = Tuning(noise=1e-3, error=1e-3, error_travel=0.0, mu_walk=1e-3, zero_std=1e-4, zero_walk=0.0)


@pytest.fixture(scope="module", params=[0.5, 1.4])
def motion(request: pytest.FixtureRequest) -> SteeredMotion:
    mu = request.param
    t = np.arange(round(SECONDS / STEP) + 1) * STEP
    tyre, wheel = RigTyre(mu=mu, k=K, a=RIG.a, e=RIG.e), Wheel(J_A=0.1, b_t=0.4827)
    torque, ones = 2 * mu * np.interp(t, *np.array(KNOTS).T), np.ones(t.size)
    return simulate_steering(torque, LOAD * ones, mu * ones, tyre=tyre, wheel=wheel).at(t[::100])


def errors(observer: Observer, motion: SteeredMotion) -> tuple[float, float]:
    """Greatest relative errors of mu in five zones and beyond."""
    estimates = run(observer, motion.t, motion.psi, motion.F_N, motion.M_z)
    error = np.abs(estimates.mu / motion.mu - 1)
    _, second, *others = np.flatnonzero(np.diff(np.sign(motion.psi_dot[1:]))) + 1
    assert len(others) == 2
    settled = motion.t >= 0.5
    five = np.arange(error.size) <= second
    return float(error[settled & five].max()), float(error[second + 10 :].max())


def test_the_root_solve_is_lost_beyond_five_zones(motion: SteeredMotion) -> None:
    five, beyond = errors(RootObserver(rig=RIG, k=K), motion)

    print(f"root: off by {five:.1%} in five zones, by {beyond:.0%} beyond")
    assert five < 0.05
    assert beyond > 1.0


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_the_filters_are_not(motion: SteeredMotion, kind: type[Ekf] | type[Mhe]) -> None:
    observer = kind(model=Model(), values={"k": K}, rig=RIG, tuning=CLEAN, acquire=False)
    five, beyond = errors(observer, motion)

    print(f"{kind.__name__}: off by {five:.2%} in five zones, by {beyond:.2%} beyond")
    assert max(five, beyond) <= 1e-3
