"""The test of a stroke against the last one the same way, in NumPy and on bristles."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import CLEAN, Ekf, Mhe, Status, Tuning, run
from observers.measurement.directional_friction import EXCHANGED
from observers.quality.friction_change_by_stroke import (
    REFERENCE,
    STEADY_WALK,
    has_friction_changed,
    predict_reference_friction,
    reset_reference_friction,
    update_change_statistic,
)
from observers.quality.slow_change_and_misfit_alarms import FORGETTING_SAMPLES
from tests.observers.measurement.test_directional_friction import F_N, directed, torque

AS_MEASURED: Any = {"noise": 0.005, "error": 0.09, "error_travel": 0.03, "explained": 2.5, "alarm": 7.0}


def test_ratio_is_that_of_gaussian_densities() -> None:
    # Two samples of a stroke whose friction is the reference's plus a normal step, or plus the best one.
    slope, weight, V, about = 0.8, 50.0, 0.01, np.array([0.5, 0.3])
    kept: Any = dict(zip(REFERENCE, (0.0, V, 0.0, 0.0, 0.0, 0.0), strict=True))
    for each in about:
        kept = update_change_statistic(kept, each, slope, weight, 0.0)
    S = np.eye(2) / weight + V * slope**2
    shift, inverse = slope * np.ones(2), np.linalg.inv(S)
    step = (shift @ inverse @ about) / (shift @ inverse @ shift)
    rest = about - step * shift
    ratio = (about @ inverse @ about - rest @ inverse @ rest) / 2

    for alarm, expected in ((0.999 * ratio, 1), (1.001 * ratio, 0)):
        assert float(has_friction_changed(kept, Tuning(alarm=alarm).vector)) == expected
    assert not float(has_friction_changed(kept, Tuning(alarm=np.inf).vector))


def test_a_reference_is_held_in_a_stroke_corrected_at_its_end_and_begins_anew_after_a_reset() -> None:
    now = np.zeros(len(CLEAN))
    now[CLEAN.index("dt")] = 0.1
    first = predict_reference_friction(ca.DM.zeros(len(REFERENCE)), 0.3, 0.04, now)
    after = update_change_statistic(first, 0.2, 1.0, 25.0, 1.0)
    now[CLEAN.index(EXCHANGED)] = 1
    turned = predict_reference_friction(reset_reference_friction(after, 0), -0.5, 0.09, now)
    back = predict_reference_friction(reset_reference_friction(turned, 0), 9.0, 9.0, now)
    anew = predict_reference_friction(reset_reference_friction(after, 1), 0.7, 0.5, np.zeros(len(CLEAN)))

    assert [float(turned[name]) for name in ("reference", "variance")] == pytest.approx([-0.5, 0.09])
    # Of equal variances, half of the difference and half of the variance, which walks on.
    walked = 0.02 + 2 * 0.1 * STEADY_WALK**2
    assert [float(back[name]) for name in ("reference", "variance")] == pytest.approx([0.4, walked])
    assert float(back["score"]) == float(back["information"]) == 0
    assert [float(anew[name]) for name in ("reference", "variance")] == pytest.approx([0.7, 0.5])
    without_slope = update_change_statistic(after, 0.0, 0.0, 0.0, 1.0)["information"]
    assert float(without_slope) == pytest.approx(25 * (1 - 1 / FORGETTING_SAMPLES))


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize("every", [1, 2, 4])
@pytest.mark.parametrize(
    ("factor", "ahead"), [(1.0, True), (1.35, True), (1.35, False), (0.7, True), (0.7, False)]
)
def test_a_change_alarms_in_its_stroke(kind: Any, every: int, factor: float, ahead: bool) -> None:
    fine = np.arange(0, 14, 0.005)
    psi = 0.25 * np.sin(np.pi * fine)
    forth, back = np.full(fine.size, 1.2), np.full(fine.size, 0.8)
    # It changes while the wheel turns back, or forth, to the other side.
    when, end = (7.5, 8.5) if ahead else (8.5, 9.5)
    (forth if ahead else back)[fine > when] *= factor
    error = 0.03 * np.random.default_rng(5).standard_normal(fine.size // 20)
    M_z = torque(psi, forth, back, 100) * (1 + np.repeat(error, 20))
    t = fine[::every]
    observer = directed(kind, mu_walk=0.14, noise=0.005, error=0.05, error_travel=0.02, explained=2.5)
    found = run(observer, t, psi[::every], np.full(t.size, F_N), M_z[::every])
    changed = t[(found.status & Status.RESET) > 0]

    assert changed.size == (factor != 1)
    assert ((when < changed) & (changed < end)).all()
    last = np.searchsorted(t, end - 0.02)
    level = (1.2 if ahead else 0.8) * factor
    assert found.mu[last] == pytest.approx(level, rel=0.1)


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize("falls", [True, False])
def test_friction_that_changes_within_every_stroke_is_followed(kind: Any, falls: bool) -> None:
    t = np.arange(0, 12, 0.01)
    psi, phase = 0.25 * np.sin(np.pi * t), np.mod(t - 0.5, 1)
    change = 0.8 * np.exp(-3 * np.maximum(4 * phase - 1, 0) ** 2)
    mu = 0.4 + change if falls else 1.2 - change
    observer = directed(kind, mu_walk=0.133, **AS_MEASURED)
    found = run(observer, t, psi, np.full(t.size, F_N), torque(psi, mu, mu, 100))
    # Until the patch slides, nothing shows that friction is not that of the end of the last stroke.
    slides = (t > 4) & (phase > 0.25)
    usable, late = slides & found.usable, (t > 4) & (phase > 0.8)

    assert usable.sum() > 0.7 * slides.sum()
    assert (np.abs(found.mu - mu) < 3 * found.mu_std)[usable].mean() > 0.95
    assert found.mu[late] == pytest.approx(mu[late], rel=0.1 if falls else 0.2)


@pytest.mark.parametrize("torque_is_there", [True, False])
def test_evidence_of_a_change_widens_nothing_at_rest_or_without_a_torque(torque_is_there: bool) -> None:
    t = np.arange(0, 12, 0.01)
    moves = np.minimum(t, 8.95)
    psi, mu = 0.25 * np.sin(np.pi * moves), np.where(t < 8.72, 1.2, 0.72)
    M_z = torque(psi, mu, mu, 100)
    observer = directed(Ekf, mu_walk=0.133, **AS_MEASURED)
    if not torque_is_there:
        psi, M_z = 0.25 * np.sin(np.pi * t), np.where(t < 8.95, M_z, np.nan)
    found = run(observer, t, psi, np.full(t.size, F_N), M_z)
    stops, later = (np.searchsorted(t, at) for at in (8.95, 9.4))

    assert found.mu_std[stops] > 0.1
    assert found.mu_std[later] < found.mu_std[stops] + 0.05
    assert not (found.status & Status.RESET)[stops:].any()
