"""The estimator against the filter, dense least squares and a general optimiser, and on the rig."""

from math import inf, nan
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque, run
from reference_rig import RigRecording, SteeringRecording, make_recording
from symbolic import Model, effects_named
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import (
    CLEAN_RIG,
    FIELDS,
    columns_of,
    first_full_slide,
    found_model,
    samples_of,
    sparse,
    states_of,
)
from tests.observers.oracles import WindowOracle

pytestmark = pytest.mark.usefixtures("interpreted")

LONG = pytest.mark.long
WINDOWS = [(1, 1), pytest.param(2, 1, marks=LONG), pytest.param(20, 1, marks=LONG), (7, 3)]


@pytest.mark.parametrize(("window", "iterations"), WINDOWS)
def test_wheel_at_rest_leaves_the_kalman_filter(window: int, iterations: int) -> None:
    # Nothing but the torque zero is seen: a linear problem, in which every window is the filter.
    t, rng = np.arange(150) / 100, np.random.default_rng(3)
    M_z = 0.3 + 0.1 * rng.standard_normal(t.size)
    M_z[rng.random(t.size) < 0.2] = nan
    columns = {"t": t, "psi": np.zeros(t.size), "F_N": np.full(t.size, 400.0), "M_z": M_z}
    believed = {"noise": 0.02, "zero_walk": 0.05, "error": inf, "gate": inf, "zero_time": 3.0}
    filtered = run(make(Ekf, **believed), **columns)
    estimated = run(make(Mhe, window=window, iterations=iterations, **believed), **columns)

    for name in FIELDS:
        np.testing.assert_allclose(getattr(estimated, name), getattr(filtered, name), rtol=0, atol=1e-9)
    assert filtered.M_z_predicted[-1] == pytest.approx(0.3, abs=0.1)


ORACLES = [
    pytest.param({}, id="aligning"),
    pytest.param(
        {"measurement_model": AligningTorque(stiffness=True), "stiffness_walk": 0.02, "mu_walk": 0.1},
        id="stiffness",
    ),
    # The error of the damping, which lasts, grows with the rate, at which the book linearises elsewhere.
    pytest.param({"measurement_model": SteeringTorque(), "error_travel": 0.0}, id="steering"),
    pytest.param({"greatest": 1.25}, id="on its bound"),
    pytest.param({"model": Model(discretised=True, bristles=20)}, id="bristles"),
]


@pytest.mark.parametrize("settings", ORACLES)
@pytest.mark.parametrize(("window", "iterations"), [(1, 1), (7, 1), pytest.param(20, 2, marks=LONG)])
def test_moving_window_equals_dense_equations_by_the_book(
    recording: RigRecording, steered: SteeringRecording, settings: Any, window: int, iterations: int
) -> None:
    observer = make(Mhe, window=window, iterations=iterations, **{**CLEAN_RIG, **settings})
    made, part = (
        (steered, slice(0, 1200, 10)) if "psi" in observer.states else (recording, slice(40, 160, 2))
    )
    samples = sparse(samples_of(columns_of(made, part)))
    oracle = WindowOracle(observer).run(samples)
    moved = 0.0
    for state, (x, P) in zip(states_of(observer, samples), oracle, strict=True):
        ours = state["x"].reshape(len(observer.states), window)[:, window - len(x) :]
        np.testing.assert_allclose(ours, x.T, rtol=0, atol=1e-9)
        scale = np.sqrt(np.diag(P))
        size, found = np.outer(scale, scale), state["P_newest"]
        np.testing.assert_allclose(found / size, P / size, rtol=0, atol=1e-8)
        moved = max(moved, np.abs(x[:, 0]).max())
    assert moved > 0.1, "the comparison saw no correction"


@pytest.mark.parametrize("error", [0.02, inf])
def test_huber_bears_bouts_of_model_error(recording: RigRecording, error: float) -> None:
    rng = np.random.default_rng(8)
    columns = columns_of(recording)
    M_z = columns["M_z"] + 5.0 * (rng.random(recording.t.size) < 0.05)
    late = slice(first_full_slide(recording), None)
    observer = make(Mhe, **{**CLEAN_RIG, "error": error})
    worst = np.abs(run(observer, **{**columns, "M_z": M_z}).mu[late] - 1.4).max()

    assert worst < 0.01 if error < 1 else worst > 0.15


@pytest.mark.parametrize("name", ["carcass_torsion", pytest.param("backlash", marks=LONG)])
def test_behind_a_compliance_an_observer_takes_bristles(name: str) -> None:
    # The corners of the exact patch depend on mu there: after a reversal mu ran to its bound.
    (effect,) = effects_named([name])
    planted = {p.name: p.start for p in effect.parameters}
    recording = make_recording(4, {name: planted}, duration=6.0, k=K, mu=1.0, bristles=400)
    found = found_model({f"{name}.{p}": value for p, value in planted.items()})
    estimates = run(Mhe(**found, rig=RIG, window=20, acquire=False), **columns_of(recording))

    assert found["model"].uses_exact_patch
    assert make(Mhe).model.uses_exact_patch
    assert estimates.mu.min() > 0.5
    assert estimates.mu.max() < 1.6
