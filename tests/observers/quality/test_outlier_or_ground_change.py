"""Outliers and changes of the ground: which samples are believed, and what is taken back."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Mhe, Sample, Status, Tuning, covariance_of
from observers.quality.outlier_or_ground_change import build_innovation_gate
from symbolic import Model
from symbolic.float_array_type import Array
from tests.observers.conftest import make
from tests.observers.factories import UNLIMITED, full_slide, slide, states_of

pytestmark = pytest.mark.usefixtures("interpreted")

KINDS = [pytest.param(Ekf, {}, id="ekf"), pytest.param(Mhe, {"window": 20}, id="mhe")]
SHARP: dict[str, Any] = {
    "noise": 0.02, "error": inf, "gate": 8.0, "zero_std": 0.0, "zero_walk": 0.0, "iterations": 4,
    **UNLIMITED,
}  # fmt: skip
"""Believes what lies within eight times 2 % of full slide."""


def judged(innovation: float, streak: float = 0.0, *, weight: float = 4.0, ordinary: float = inf,
           left_open: float = 0.0, **tuning: Any) -> tuple[bool, bool, int, Array]:  # fmt: skip
    vector = Tuning(**{"gate": 3.0, "reset_after": 4, **tuning}).vector
    made = build_innovation_gate()(innovation, left_open, weight, ordinary, [streak, 2.0], vector)
    believed, reset, run, counts = (np.asarray(part).ravel() for part in made)
    return bool(believed[0]), bool(reset[0]), int(run[0]), counts


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    ("settings", "limit"),
    [
        ({}, 3 * 0.5),
        ({"ordinary": 0.04}, 3 * 0.2),
        ({"ordinary": 9.0}, 3 * 0.5),
        ({"left_open": 0.75}, 3 * 1.0),
        ({"gate": 12.0}, 12 * 0.5),
    ],
)
def test_gate_is_so_many_ordinary_innovations(side: int, settings: Any, limit: float) -> None:
    assert judged(side * 0.999 * limit, **settings)[0]
    believed, reset, run, counts = judged(side * 1.001 * limit, **settings)
    assert (believed, reset, run) == (False, False, 1)
    np.testing.assert_array_equal(counts, [side, 2.0])


def test_the_other_side_begins_a_run_anew_a_good_sample_ends_it_and_a_missing_one_does_neither() -> None:
    assert judged(-9.0, 3.0)[:3] == (False, False, 1)
    np.testing.assert_array_equal(judged(-9.0, 3.0)[3], [-1.0, 2.0])
    assert judged(0.1, 3.0)[:3] == (True, False, 0)
    np.testing.assert_array_equal(judged(0.1, 3.0)[3], [0.0, 2.0])
    believed, reset, run, counts = judged(0.0, 3.0, weight=0.0)
    assert (believed, reset, run) == (True, False, 0)
    np.testing.assert_array_equal(counts, [3.0, 2.0])


def settled(count: int, mu: float = 1.2, later: float | None = None, change: int = 60) -> list[Sample]:
    """Samples in full slide, the ground changing at `change` if it is to."""
    levels = np.full(count, mu)
    levels[change:] = mu if later is None else later
    return full_slide(levels, every=10_000)


def struck(sample: Sample, share: float) -> Sample:
    return replace(sample, M_z=sample.M_z + share * slide(sample.F_N))


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_an_outlier_is_flagged_and_changes_nothing(kind: Any, settings: Any) -> None:
    observer = make(kind, **SHARP, **settings)
    samples = settled(80)
    faulty = [struck(s, 0.5) if i == 60 else s for i, s in enumerate(samples)]
    missing = [replace(s, M_z=np.nan) if i == 60 else s for i, s in enumerate(samples)]
    rejected, gone = ([observer.estimate(s) for s in states_of(observer, x)] for x in (faulty, missing))

    assert [i for i, e in enumerate(rejected) if Status.REJECTED in e.status] == [60]
    assert rejected[60].status == Status.REJECTED
    assert gone[60].status == Status.MISSING
    assert "gate" in rejected[60].status.remedy
    for one, other in zip(rejected, gone, strict=True):
        assert (one.mu, one.mu_std) == pytest.approx((other.mu, other.mu_std), abs=1e-13)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("later", [0.5, 2.2])
def test_a_change_of_the_ground_resets(kind: Any, settings: Any, later: float) -> None:
    observer = make(kind, **SHARP, **settings)
    states = list(states_of(observer, settled(100, later=later)))
    said = [observer.estimate(state) for state in states]

    assert [e.status for e in said[60:64]] == [Status.REJECTED] * 4
    assert said[63].mu == pytest.approx(1.2, abs=0.01)
    assert Status.RESET in said[64].status
    assert Status.REJECTED not in said[64].status
    streaks, resets = np.array([state["counts"] for state in states]).T
    np.testing.assert_array_equal(np.abs(streaks[59:66]), [0, 1, 2, 3, 4, 0, 0])
    np.testing.assert_array_equal(resets[59:66], [0, 0, 0, 0, 0, 1, 1])
    assert said[64].mu_std > said[63].mu_std
    assert said[-1].mu == pytest.approx(later, abs=0.02)
    assert "learnt anew" in said[64].status.remedy


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_after_a_reset_the_estimate_rests_on_the_prior_again(kind: Any, settings: Any) -> None:
    # A cautious tuning: one sample that is believed does not inform.
    observer = make(kind, noise=1.0, error=0.02, error_travel=0.0, gate=8.0, **UNLIMITED, **settings)
    said = [observer.estimate(s) for s in states_of(observer, settled(400, later=0.5, change=300))]
    reset = next(i for i, e in enumerate(said) if Status.RESET in e.status)

    assert said[reset - 1].informed
    assert not said[reset].informed
    assert said[reset].mu_std > 0.8 * observer.tuning.mu_std * said[reset].mu / observer.tuning.mu


def test_the_sample_that_resets_is_blamed_no_more_than_is_unknown() -> None:
    # In full slide M_z is proportional to mu, so that its slope by ln mu is M_z itself.
    certain = {"error_travel": 0.0, "zero_std": 0.0, "zero_walk": 0.0, **UNLIMITED}
    observer = make(Ekf, noise=0.1, error=0.02, gate=5.0, **certain)
    samples = settled(70, later=0.5)
    states = list(states_of(observer, samples))
    before, after = (covariance_of(states[i]["factor"])[0, 0] for i in (63, 64))
    level = samples[64].M_z / 0.5
    expected = level * observer.estimate(states[63]).mu
    open_now = before + 0.01 * observer.tuning.mu_walk**2 + 2 * observer.tuning.mu_std**2
    # The model's error is a share of the torque at the mu that is believed.
    error = np.hypot(0.02 * observer.estimate(states[63]).mu, 0.1) * slide()
    limit = np.sqrt(error**2 + expected**2 * open_now)
    share = min(1.0, limit / abs(samples[64].M_z - expected))
    weight = share / (0.1 * slide()) ** 2

    assert Status.RESET in observer.estimate(states[64]).status
    assert after == pytest.approx(1 / (1 / open_now + weight * expected**2), rel=1e-6)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_alternating_outliers_never_reset(kind: Any, settings: Any) -> None:
    observer = make(kind, **SHARP, **settings)
    faulty = [struck(s, 0.6 * (-1) ** i) if i >= 60 else s for i, s in enumerate(settled(100))]
    states = list(states_of(observer, faulty))
    said = [observer.estimate(state) for state in states]

    assert all(e.status == Status.REJECTED for e in said[60:])
    assert states[-1]["counts"].tolist()[1] == 0
    assert said[-1].mu == pytest.approx(1.2, abs=0.01)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_resets_after_as_many_as_asked_for(kind: Any, settings: Any) -> None:
    for asked in (1, 3, 8):
        observer = make(kind, **SHARP, reset_after=asked, **settings)
        said = [observer.estimate(s) for s in states_of(observer, settled(80, later=0.5))]
        assert [i for i, e in enumerate(said) if Status.RESET in e.status] == [60 + asked - 1]


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_bristles_are_reset_too(kind: Any, settings: Any) -> None:
    # Their memory stands for a mu, and is not taken along to the new ground.
    observer = make(kind, model=Model(discretised=True, bristles=20), **SHARP, **settings)
    samples = [replace(s, psi=s.psi + 0.01 * i) for i, s in enumerate(settled(80, later=0.5))]
    said = [observer.estimate(s) for s in states_of(observer, samples)]

    assert [i for i, e in enumerate(said) if Status.RESET in e.status] == [64]
    assert said[63].mu == pytest.approx(1.2, abs=0.01)
    assert [e.mu for e in said[64:]] == pytest.approx([0.5] * 16, abs=0.02)


@pytest.mark.parametrize("window", [1, 3, 5, 6, 20])
def test_the_window_takes_back_what_it_rejected(window: int) -> None:
    filter_, estimator = make(Ekf, **SHARP), make(Mhe, **SHARP, window=window)
    samples = settled(100, later=0.5)
    filtered = [filter_.estimate(s) for s in states_of(filter_, samples)]
    states = list(states_of(estimator, samples))
    estimated = [estimator.estimate(s) for s in states]

    assert [e.status & ~Status.UNSETTLED for e in estimated] == [e.status for e in filtered]
    back = min(window, 5)
    # As if those of the run that are still in the window had been the first on the new ground.
    assert estimated[64].mu_std == pytest.approx(filtered[64].mu_std / np.sqrt(back), rel=0.1)
    assert estimated[64].mu == pytest.approx(0.5, abs=0.02)
    believed = states[64]["samples"][-2]
    np.testing.assert_array_equal(believed, 1.0)
