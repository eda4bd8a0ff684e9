"""The filter against filterpy, against the minimum of its own cost, and against the whole history."""

from collections.abc import Callable
from dataclasses import replace
from math import exp, nan
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from observers import AligningTorque, Ekf, Sample, SteeringTorque, covariance_of
from reference_rig import RigRecording, SteeringRecording
from symbolic import Model
from symbolic.float_array_type import Array
from tests.observers.factories import (
    CLEAN_RIG,
    columns_of,
    found_model,
    samples_of,
    slide,
    sparse,
    states_of,
)
from tests.observers.textbook import Filter, StateSpace

pytestmark = pytest.mark.usefixtures("interpreted")

Make = Callable[..., Ekf]


def assert_equals_filterpy(observer: Ekf, samples: list[Sample], close: float) -> None:
    oracle = Filter(observer, samples[0])
    moved = 0.0
    for sample, state in zip(samples, states_of(observer, samples), strict=True):
        expected = oracle.step(sample)
        said = observer.estimate(state)
        assert said.M_z_predicted == pytest.approx(expected, abs=close * slide())
        assert said.nis == pytest.approx(oracle.nis, rel=1e-3, abs=1e3 * close, nan_ok=True)
        scale = np.sqrt(np.diag(oracle.P))
        np.testing.assert_allclose(state["x"], oracle.x, rtol=0, atol=close)
        P = covariance_of(state["factor"])
        np.testing.assert_allclose(P / np.outer(scale, scale), oracle.P / np.outer(scale, scale),
                                   rtol=0, atol=10 * close)  # fmt: skip
        mu, std = exp(oracle.x[0]), max(scale[0], abs(oracle.lag) * (observer.tuning.mu_walk > 0))
        assert (said.mu, said.mu_std) == pytest.approx((mu, mu * std), abs=10 * close)
        moved = max(moved, abs(mu - observer.tuning.mu))
    assert moved > 0.05, "the comparison saw no correction"


EFFECTS = [
    pytest.param({}, 1e-9, id="declared"),
    pytest.param({"sensor_delay.delay": 0.013}, 1e-9, id="delay"),
    # A compliant wheel at rest turns by rounding alone; that leaves deep corners, which round again.
    pytest.param({"carcass_torsion.k_t": 400}, 1e-4, id="carcass"),
    pytest.param({"rate_friction.c": 0.04}, 1e-9, id="bristles"),
]


@pytest.mark.parametrize(("values", "close"), EFFECTS)
@pytest.mark.parametrize("noise", [0.3, pytest.param(0.01, marks=pytest.mark.long)])
def test_equals_filterpy(
    recording: RigRecording, ekf: Make, values: Any, close: float, noise: float
) -> None:
    observer = ekf(**found_model(values), **{**CLEAN_RIG, "noise": noise})
    assert_equals_filterpy(observer, sparse(samples_of(columns_of(recording, slice(40, 190)))), close)


@pytest.mark.parametrize(
    "measurement_model",
    [
        AligningTorque(zero=False),
        AligningTorque(stiffness=True),
        AligningTorque(zero=False, stiffness=True),
    ],
    ids=repr,
)
@pytest.mark.parametrize("discretised", [False, True], ids=["exact", "bristles"])
def test_equals_filterpy_with_the_tyre_as_a_state(
    recording: RigRecording, ekf: Make, measurement_model: AligningTorque, discretised: bool
) -> None:
    observer = ekf(
        model=Model(discretised=discretised), measurement_model=measurement_model,
        stiffness_walk=0.03, mu_walk=0.1,
        zero_time=5.0, **CLEAN_RIG,
    )  # fmt: skip
    assert_equals_filterpy(observer, sparse(samples_of(columns_of(recording, slice(40, 190)))), 1e-8)


@pytest.mark.parametrize(
    "measurement_model",
    [
        SteeringTorque(stiffness=True),
        *(
            pytest.param(m, marks=pytest.mark.long)
            for m in (SteeringTorque(), SteeringTorque(zero=True))
        ),
    ],
    ids=repr,
)
def test_equals_filterpy_where_the_steering_torque_is_measured(
    steered: SteeringRecording, ekf: Make, measurement_model: SteeringTorque
) -> None:
    observer = ekf(measurement_model=measurement_model, **CLEAN_RIG)
    assert_equals_filterpy(observer, sparse(samples_of(columns_of(steered, slice(250, 600)))), 1e-8)


@pytest.mark.parametrize("at", [90, *(pytest.param(n, marks=pytest.mark.long) for n in (120, 200))])
def test_iterations_minimise_the_cost_of_one_sample(recording: RigRecording, ekf: Make, at: int) -> None:
    observer = ekf(**{**CLEAN_RIG, "noise": 0.03}, iterations=12)
    samples = samples_of(columns_of(recording, slice(0, at)))
    space = StateSpace(observer)
    mean, P, history = space.prior(samples[0])
    # All but the last sample pass without their torque, so that the last one has far to go.
    for sample in samples:
        mean, _, Q = space.motion(mean, 0.0, np.zeros(2), None, sample)
        history = space.predicted_history(history, P, Q, mean)
        before, P = history, P + np.diag(Q)
        history = space.update_patch(history, mean, sample)[0]
    last = samples[-1]
    state = None
    for sample in [*(replace(s, M_z=nan) for s in samples[:-1]), last]:
        state = observer.step(observer.init(sample) if state is None else state, sample)

    def cost(x: Array) -> float:
        update = space.update_patch(before, x, last)
        measured, expected, _, weight = space.measurement(x, *update[1:], last)
        return float((x - mean) @ np.linalg.solve(P, x - mean) + weight * (measured - expected) ** 2)

    scale = np.sqrt(np.diag(P))
    found = minimize(
        lambda y: cost(mean + scale * y), np.zeros(2), method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-14, "maxiter": 2000},
    )  # fmt: skip
    assert state is not None
    np.testing.assert_allclose(state["x"], mean + scale * found.x, rtol=0, atol=1e-6)
    once = replace(observer, iterations=1)
    assert cost(state["x"]) < cost(_one_step(once, samples)) - 1e-9


def _one_step(observer: Ekf, samples: list[Sample]) -> Array:
    *_, last = states_of(observer, [*(replace(s, M_z=nan) for s in samples[:-1]), samples[-1]])
    return np.asarray(last["x"])
