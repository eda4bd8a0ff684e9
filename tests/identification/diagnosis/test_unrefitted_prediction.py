"""Friction of a ground by load, and recordings of which nothing is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording, fit
from identification.diagnosis.unrefitted_prediction import (
    friction_from_training,
    unrefitted_residuals,
    values_from_training,
)
from identification.fits.least_squares_problem import torque_range
from symbolic import Model, Tolerances, effects_named, simulate
from tests.identification.factories import recording, with_torque

pytestmark = pytest.mark.usefixtures("interpreted")
A, E, K, PERIOD = 0.045, 0.009, 2.4e6, 0.02
T = np.arange(300) * PERIOD
PSI = 0.03 * T * np.sin(2 * np.pi * T / 3)


def recorded(name: str, load: float, ground: str | None) -> Recording:
    return recording(name, ground, PSI, period=PERIOD, load=load, k=K)


def simulated(of: Recording, mu: float) -> Recording:
    signals = np.vstack([of.psi, of.psi_dot, of.F_N, np.full(T.size, PERIOD)])
    return with_torque(of, simulate(Model(), signals, np.array([mu, K]), np.array([A, E])).M_z)


STEEL = [recorded(f"s{i}", load, "steel") for i, load in enumerate((300.0, 400.0, 500.0))]
EMERY = [recorded("e0", 350.0, "emery")]
MU = {"s0": 1.0, "s1": 1.1, "s2": 1.2, "e0": 2.0}


def test_the_mean_of_its_ground_in_the_middle_of_the_loads_or_of_all_grounds() -> None:
    middle = float(np.exp(np.mean(np.log([300.0, 400.0, 500.0]))))

    steel = friction_from_training(MU, [*STEEL, *EMERY], recorded("new", middle, "steel"))
    assert steel == pytest.approx((1.0 * 1.1 * 1.2) ** (1 / 3))
    assert friction_from_training(MU, [*STEEL, *EMERY], recorded("new", 900.0, "emery")) == 2.0
    all_alike = dict.fromkeys(MU, 1.5)
    new = recorded("new", 600.0, "ice")
    assert friction_from_training(all_alike, [*STEEL, *EMERY], new) == pytest.approx(1.5)


def test_the_slope_over_the_load_is_the_posteriors() -> None:
    # The same by the normal equations with the prior of the slope as one more row.
    x = np.log([300.0, 400.0, 500.0])
    y = np.log([1.0, 1.1, 1.2])
    matrix = np.vstack([np.column_stack([np.ones(3), x - x.mean()]) / 0.05, [[0, 3.0]]])
    level, slope = np.linalg.lstsq(matrix, np.append(y / 0.05, 0.0), rcond=None)[0]
    expected = np.exp(level + slope * (np.log(600.0) - x.mean()))

    new = recorded("new", 600.0, "steel")
    assert friction_from_training(MU, [*STEEL, *EMERY], new) == pytest.approx(expected)
    assert 0 < slope < np.polyfit(x, y, 1)[0]


def test_nothing_of_a_recording_is_fitted() -> None:
    training = [simulated(r, 1.1) for r in STEEL[:2]]
    fitted = fit(Model(effects=effects_named(["torque_offset"])), training)
    tolerated = replace(STEEL[2], rig=replace(STEEL[2].rig, tolerances=Tolerances(a=0.002)))
    judged = simulated(tolerated, 1.1)
    values = values_from_training(fitted, STEEL[:2], judged)
    (residual,) = unrefitted_residuals(fitted, STEEL[:2], [judged]).values()

    assert values.own == {judged.name: {"mu": pytest.approx(1.1), "torque_offset.M_0": 0.0}}
    assert values.rig == {judged.name: {"a": A}}
    assert np.sqrt(np.mean(residual**2)) < 1e-4 * torque_range(judged)
    shifted = with_torque(judged, judged.M_z + 0.5)
    (residual,) = unrefitted_residuals(fitted, STEEL[:2], [shifted]).values()
    assert residual.mean() == pytest.approx(-0.5, abs=0.01)
