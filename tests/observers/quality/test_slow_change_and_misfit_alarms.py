"""Page's cumulative sums and the consistency, written out once more in NumPy."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from observers import AligningTorque, Ekf, Mhe, Status, Tuning, innovations, run, smooth
from observers.quality.slow_change_and_misfit_alarms import (
    CHANGE,
    FORGETTING_SAMPLES,
    MIN_SAMPLES,
    MONITOR,
    build_innovation_monitor,
)
from reference_rig import RigRecording, RigTyre, make_ground_recording
from symbolic import Model
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import columns_of, wrong_and_usable
from tests.observers.surface_changes import HIGH, LOW, counted_turn, crossing
from tests.refusal import refused


def watched(nu: Array, slope: float = 1.0, variance: float = 0.01, share: float = 1.0,
            **tuning: Any) -> tuple[Array, Array, Array]:  # fmt: skip
    """Alarms, inconsistency and the state after each innovation."""
    vector = Tuning(**tuning).vector
    state, rows = np.zeros(len(MONITOR)), []
    for each in nu:
        made = build_innovation_monitor()(each, slope, variance, share, 1.0, 0.0, 0.0, state, vector)
        alarm, inconsistent, after = (np.asarray(part).ravel() for part in made)
        state = after
        rows.append([alarm[0], inconsistent[0], *state])
    table = np.array(rows)
    return table[:, 0], table[:, 1], table[:, 2:]


@pytest.mark.parametrize("side", [1, -1])
def test_sums_are_those_of_the_log_likelihood_ratio(side: int) -> None:
    rng = np.random.default_rng(3)
    nu, variance = 0.3 * side + 0.2 * rng.standard_normal(40), 0.04
    _, _, states = watched(nu, 0.8, variance, 0.1, alarm=1e3)
    shift, rise, squares, samples = 0.8 * CHANGE, 0.0, 0.0, 0.0
    for each, state in zip(side * nu, states, strict=True):
        ratio = (each**2 - (each - shift) ** 2) / (2 * variance)
        rise = max(0.0, rise + 0.1 * ratio / (1 + max(0.0, squares - samples) / FORGETTING_SAMPLES))
        squares, samples = ((1 - 0.1 / FORGETTING_SAMPLES) * s for s in (squares, samples))
        squares, samples = squares + 0.1 * min(25.0, each**2 / variance), samples + 0.1
        assert state[0 if side > 0 else 1] == pytest.approx(rise, abs=1e-12)
        assert state[2:4] == pytest.approx([squares, samples])
    assert rise > 1


def test_an_alarm_takes_several_samples_and_starts_anew() -> None:
    alarms, _, states = watched(np.full(12, 5.0), share=1e-2, alarm=7.0, reset_after=5)

    first = int(np.argmax(alarms))
    assert first >= 5
    np.testing.assert_array_equal(states[first, :2], 0.0)


@pytest.mark.parametrize("limits", [{"alarm": inf}, {"gate": inf}])
def test_no_alarm_where_none_is_wanted(limits: dict[str, float]) -> None:
    assert not watched(np.full(200, 5.0), **limits)[0].any()


def test_in_stick_nothing_counts() -> None:
    alarms, _, states = watched(np.full(200, 5.0), slope=0.0)

    assert not alarms.any()
    np.testing.assert_array_equal(states[:, :2], 0.0)


def test_inconsistent_beyond_the_mean_square_that_is_explained() -> None:
    # Samples of a tenth, of which those long ago are forgotten.
    gone, lost = 1 - MIN_SAMPLES / FORGETTING_SAMPLES, 1 - 0.1 / FORGETTING_SAMPLES
    few = int(np.ceil(np.log(gone) / np.log(lost)))
    for size, expected in ((1.05, True), (0.95, False)):
        _, inconsistent, _ = watched(np.full(200, size * 0.1), slope=0.0, share=0.1, explained=1.0)
        assert not inconsistent[: few - 1].any()
        assert inconsistent[few:].all() == expected


def test_the_lag_is_that_of_a_filter_behind_a_ramp() -> None:
    """A filter of a constant gain lags behind a ramp by its rise in 1 / gain samples."""
    gain, rise, friction, estimate = 0.05, 0.004, 0.0, 0.0
    noise, state, vector = np.random.default_rng(4), np.zeros(len(MONITOR)), Tuning().vector
    lags, seen = list[float](), list[float]()
    for _ in range(600):
        friction += rise
        correction = gain * (friction + 0.01 * noise.standard_normal() - estimate)
        *_, state = build_innovation_monitor()(0.0, 1.0, 1.0, 0.0, 1.0, correction, gain, state, vector)
        estimate += correction
        lags.append(friction - estimate)
        seen.append(float(state[MONITOR.index("lag")]))
    assert np.mean(lags[200:]) == pytest.approx(rise * (1 - gain) / gain, rel=0.1)
    assert np.mean(seen[200:]) == pytest.approx(rise / gain, rel=0.1)
    # After a sample that takes all of the variance, and all of the error, none of either is left.
    *_, state = build_innovation_monitor()(0.0, 1.0, 1.0, 0.0, 1.0, 0.3, 1.0, state, vector)
    assert float(state[MONITOR.index("lag")]) == pytest.approx(0.0)


@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize(
    ("estimate", "kind", "noise"),
    [
        (run, Ekf, None),
        pytest.param(run, Ekf, 0.01, marks=pytest.mark.long),
        pytest.param(smooth, Ekf, None, marks=pytest.mark.long),
        pytest.param(run, Mhe, None, marks=pytest.mark.long),
    ],
    ids=["ekf", "noise declared", "smoothed", "mhe"],
)
def test_friction_that_changes_steadily_is_not_usable_and_wrong(
    estimate: Any, kind: Any, noise: float | None, factor: float
) -> None:
    observer = kind(model=Model(), values={"k": K}, rig=replace(RIG, noise=noise))
    length, wrong = 15.0, list[float]()
    for seed in range(4):
        tyre = RigTyre(a=RIG.a, e=RIG.e, k=K, mu=0.4)
        made = make_ground_recording(
            seed, lambda t: 0.4 * factor ** (t / length), tyre=tyre, duration=length, bristles=500
        )
        estimates = estimate(observer, **columns_of(made))
        assert estimates.usable.mean() > 0.3
        wrong.append(float(wrong_and_usable(estimates, made.mu_true).mean()))
    assert max(wrong) < 0.02


@pytest.mark.parametrize(("before", "after"), [(HIGH, LOW), (LOW, HIGH)])
def test_the_usual_tuning_knows_a_new_ground_soon(before: float, after: float) -> None:
    case = crossing(0, 0.2, before, after)
    estimates = run(make(Ekf, mu_floor=0.04), **columns_of(case.made))

    assert np.count_nonzero(estimates.status & Status.RESET) == 1
    assert counted_turn(case, estimates) <= 0.2


def test_density_is_normal_and_the_variance_that_of_the_sensor(recording: RigRecording) -> None:
    columns = columns_of(recording)
    noise = 0.004 * np.ptp(recording.M_z_true)
    white = {"noise": noise / 6.75, "error": inf, "gate": inf, "mu_walk": 0.0}
    observer = make(Ekf, measurement_model=AligningTorque(zero=False), **white)
    made = innovations(run(observer, **columns), columns["M_z"])
    late = slice(800, None)

    assert np.median(made.variance[late]) == pytest.approx(noise**2, rel=0.05)
    assert np.std(made.innovation[late]) == pytest.approx(noise, rel=0.15)
    expected = norm.logpdf(made.innovation, scale=np.sqrt(made.variance))
    np.testing.assert_allclose(made.log_likelihood, expected, rtol=1e-9)


def test_missing_samples_have_none_and_shapes_are_checked(recording: RigRecording) -> None:
    columns = columns_of(recording, slice(0, 200))
    columns["M_z"] = np.where(np.arange(200) == 120, np.nan, columns["M_z"])
    estimates = run(make(Ekf), **columns)

    assert np.isnan(innovations(estimates, columns["M_z"]).log_likelihood[120])
    assert "shape of the estimates" in refused(innovations, estimates, columns["M_z"][1:])
