"""Sensitivity of the memory to the tyre: what a random walk and a change of the ground leave of it."""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, Sample, Status, Tuning
from observers.measurement.measurement_model import CLEAN
from observers.patch.update import sensitivity_retention
from symbolic import Model
from symbolic.float_array_type import Array
from tests.observers.conftest import make

pytestmark = pytest.mark.usefixtures("interpreted")

BRISTLES = Model(discretised=True, bristles=20)
TYRE = [AligningTorque(zero=False), AligningTorque(zero=False, stiffness=True)]


def retention(measurement_model: AligningTorque, P: Array, Q: Array) -> Array:
    n = len(measurement_model.states)
    x = np.array([np.log(0.7), 1.1])[:n]
    made = sensitivity_retention(measurement_model, ca.MX(P), ca.MX(Q), ca.MX(x), ca.MX(len(CLEAN), 1))
    return np.asarray(ca.evalf(made))


@pytest.mark.parametrize("measurement_model", TYRE, ids=repr)
@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-3, 1.0])
def test_nothing_is_lost_where_nothing_walks(measurement_model: AligningTorque, size: float) -> None:
    n = len(measurement_model.states)
    P = size * np.array([[1.0, 0.3], [0.3, 0.2]])[:n, :n]

    np.testing.assert_array_equal(retention(measurement_model, P, np.zeros(n)), np.eye(n))


@pytest.mark.parametrize("measurement_model", TYRE, ids=repr)
@pytest.mark.parametrize("size", [1e-12, 1e-3, 1.0])
def test_a_walk_leaves_the_regression_of_the_past_on_the_present(
    measurement_model: AligningTorque, size: float
) -> None:
    n = len(measurement_model.states)
    P, Q = size * np.array([[1.0, 0.3], [0.3, 0.2]])[:n, :n], size * np.array([0.5, 0.1])[:n]
    scale = np.diag([0.7, 1.0][:n])
    expected = scale @ P @ np.linalg.inv(P + np.diag(Q)) @ np.linalg.inv(scale)

    np.testing.assert_allclose(retention(measurement_model, P, Q), expected, rtol=1e-9)


def before_a_change(kind: Any) -> tuple[Any, Any, Sample]:
    """An observer on bristles, its state while the patch slides, and a sample far off the model."""
    usual = {"model": BRISTLES, "gate": 5.0, **({"window": 5} if kind is Mhe else {})}
    observer = make(kind, reset_after=5, **usual)
    sample = Sample(psi=0.0, psi_dot=0.5, F_N=400.0, dt=0.01, M_z=0.0)
    state = observer.init(sample)
    for i in range(12):
        state = observer.step(state, replace(sample, psi=0.01 * i, M_z=-0.5 * i))
    return observer, state, replace(sample, psi=0.12, M_z=-60.0)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_a_change_of_the_ground_discounts_the_newest_memory_alone(kind: Any) -> None:
    observer, state, sample = before_a_change(kind)
    changing = replace(observer, tuning=Tuning(gate=5.0, reset_after=1))
    stays, changes = (one.step(state, sample) for one in (observer, changing))
    assert observer.estimate(stays).status & Status.REJECTED
    assert changing.estimate(changes).status & Status.RESET
    change, n = 2 * observer.tuning.prior_log_mu_std**2, len(observer.states)
    # The patch was updated at the same states in both; a memory of the old ground knows less of the new.
    if kind is Mhe:
        variance = state["P_newest"].reshape(n, n)[0, 0]
        old, new = (made["memory_sensitivity"] for made in (stays, changes))
        np.testing.assert_array_equal(new[:, :-1], old[:, :-1])
        assert np.abs(old[:, :-1]).max() > 0
        old, new = old[:, -1], new[:, -1]
    else:
        variance = stays["factor"].reshape(n, n, order="F")[0, 0]
        factor = stays["factor"].reshape(n, n, order="F")
        variance = factor[0, 0] + factor[0, 1] ** 2 * factor[1, 1]
        old, new = stays["memory_sensitivity"], changes["memory_sensitivity"]

    assert np.abs(old).max() > 0
    np.testing.assert_allclose(new, variance / (variance + change) * old, rtol=1e-9)
