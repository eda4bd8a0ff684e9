"""The state before the first sample against the prior written out in NumPy."""

from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, Sample, SteeringTorque, covariance_of
from symbolic import Model, effects_named
from tests.observers.conftest import K, make
from tests.observers.textbook import StateSpace

FIRST = Sample(psi=0.3, psi_dot=0.1, F_N=411.0, dt=0.013)
FOUND = {
    "model": Model(effects=effects_named(["rate_friction", "carcass_torsion"])),
    "values": {"k": K, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0},
}


@pytest.mark.parametrize(
    "measurement_model",
    [AligningTorque(), AligningTorque(stiffness=True), SteeringTorque(zero=True)],
    ids=repr,
)
@pytest.mark.parametrize("model", [{}, FOUND], ids=["declared", "effects"])
def test_filter_begins_with_the_prior(measurement_model: Any, model: dict[str, Any]) -> None:
    observer = make(Ekf, measurement_model=measurement_model, mu=0.9, psi_dot_std=0.7, **model)
    state, n = observer.init(FIRST), len(observer.states)
    x, P, history = StateSpace(observer).prior(FIRST)

    np.testing.assert_allclose(state["x"], x, rtol=1e-14, atol=0)
    np.testing.assert_allclose(covariance_of(state["factor"].reshape(n, n)), P, rtol=1e-14, atol=0)
    np.testing.assert_array_equal(state["memory"], history.memory)
    np.testing.assert_array_equal(state["output"], [0.9, observer.tuning.mu_std, *[np.nan] * 5, 0.0])
    for part in ("M_z", "slopes", "counts"):
        assert not state[part].any(), part


@pytest.mark.parametrize("measurement_model", [AligningTorque(), SteeringTorque()], ids=repr)
def test_window_begins_empty_at_the_prior(measurement_model: Any) -> None:
    observer = make(Mhe, measurement_model=measurement_model, window=5)
    filtered = make(Ekf, measurement_model=measurement_model).init(FIRST)
    state, n = observer.init(FIRST), len(observer.states)

    np.testing.assert_array_equal(state["x"], np.tile(filtered["x"].reshape(n, 1), 5))
    np.testing.assert_array_equal(state["mean"], filtered["x"])
    for part in ("factor", "P_newest"):
        np.testing.assert_array_equal(state[part], filtered["factor"], err_msg=part)
    first = {"psi": FIRST.psi, "F_N": FIRST.F_N}
    expected = [first.get(name, 0.0) for name in ("psi", "psi_dot", "F_N", *"1234", "F_N", *"1234567")]
    np.testing.assert_array_equal(state["samples"], np.tile(np.reshape(expected, (15, 1)), 5))
    if "psi" in observer.states:
        np.testing.assert_array_equal(state["angle_slope"], np.tile([[FIRST.psi], [0.0]], 5))
