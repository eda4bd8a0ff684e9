"""The smoother against the textbook, and what must hold of it."""

from typing import Any

import numpy as np
import pytest

from observers import Ekf, Mhe, SteeringTorque, Tuning, covariance_of, run, smooth
from observers.quality.slow_change_and_misfit_alarms import MONITOR
from reference_rig import RigRecording, SteeringRecording, make_recording
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from tests.observers.conftest import EXACT_RIG, K
from tests.observers.factories import (
    CLEAN_RIG,
    change_of_ground,
    columns_of,
    first_full_slide,
    found_model,
    samples_of,
    slide,
    states_of,
)
from tests.observers.textbook import StateSpace

pytestmark = pytest.mark.usefixtures("interpreted")

ALONE: dict[str, Any] = {"rig": EXACT_RIG, "acquire": False}
DECLARED, BRISTLES = found_model({}) | ALONE, found_model({"rate_friction.c": 0.04}, bristles=20) | ALONE


def filtered(observer: Ekf, columns: dict[str, Array]) -> tuple[Array, Array, list[Any]]:
    states, n = list(states_of(observer, samples_of(columns))), len(observer.states)
    P = [covariance_of(state["factor"].reshape(n, n, order="F")) for state in states]
    return np.array([state["x"] for state in states]), np.array(P), states


@pytest.mark.parametrize(
    "settings",
    [DECLARED, BRISTLES, {**DECLARED, "measurement_model": SteeringTorque()}],
    ids=["declared", "bristles", "steered"],
)
def test_equals_the_textbook(
    recording: RigRecording, steered: SteeringRecording, settings: dict[str, Any]
) -> None:
    walks = {"mu_walk": 0.05, "zero_walk": 0.01, "zero_time": 8.0, "error_travel": 0.0, "alarm": np.inf}
    tuning = Tuning(noise=0.1, error=np.inf, mu_floor=0.0, **walks)
    observer = Ekf(**settings, tuning=tuning)
    steers = observer.channel == "M"
    columns = columns_of(steered if steers else recording, slice(40, 400 if steers else 300))
    x, P, states = filtered(observer, columns)
    samples, space = samples_of(columns), StateSpace(observer)
    smoothed, cov = x.copy(), P.copy()
    places = [observer.states.index(name) for name in ("psi", "log_mu") if name in observer.states]
    for i in range(len(x) - 2, -1, -1):
        slopes = np.zeros(x.shape[1])
        slopes[places] = states[i]["slopes"]
        M_z = float(states[i]["M_z"][0])
        after, A, Q = space.motion(x[i], M_z, slopes, samples[i], samples[i + 1])
        before = A @ P[i] @ A.T + np.diag(Q)
        gain = P[i] @ A.T @ np.linalg.inv(before)
        smoothed[i] = x[i] + gain @ (smoothed[i + 1] - after)
        cov[i] = P[i] + gain @ (cov[i + 1] - before) @ gain.T
    at = observer.states.index("log_mu")
    made = smooth(observer, **columns)

    np.testing.assert_allclose(np.log(made.mu), smoothed[:, at], rtol=0, atol=1e-6)
    # A lag behind friction, and what later samples move it by beyond chance, are not left out.
    lag = np.array([float(state["monitor"][MONITOR.index("lag")]) for state in states])
    known, moved = P[:, at, at], smoothed[:, at] - x[:, at]
    variance = cov[:, at, at] + np.maximum(lag**2 - known, 0)
    variance += 0.25 * np.maximum(moved**2 - (known - cov[:, at, at]), 0)
    np.testing.assert_allclose((made.mu_std / made.mu) ** 2, variance, rtol=1e-4)
    assert np.abs(smoothed[:, at] - x[:, at]).max() > 0.04, "nothing was smoothed"


@pytest.mark.parametrize("settings", [DECLARED, BRISTLES], ids=["declared", "bristles"])
def test_it_ends_as_the_filter_and_knows_more_before(
    recording: RigRecording, settings: dict[str, Any]
) -> None:
    observer, columns = Ekf(**settings), columns_of(recording)
    causal, smoothed = run(observer, **columns), smooth(observer, **columns)

    for name in ("mu", "mu_std", "mu_eff", "mu_eff_std", "M_slide", "nis", "status"):
        assert getattr(smoothed, name)[-1] == pytest.approx(getattr(causal, name)[-1], rel=1e-9)
    relative = [made.mu_std / made.mu for made in (smoothed, causal)]
    assert (relative[0] <= relative[1] * (1 + 1e-12)).all()
    # Before the first slide the filter knows nothing; the smoother knows what comes.
    early = slice(0, int(np.argmax(causal.informed)))
    assert 40 < early.stop < first_full_slide(recording)
    assert smoothed.informed[early].all()
    if settings is DECLARED:
        assert np.abs(smoothed.mu[early] - recording.tyre.mu).max() < 0.06
    np.testing.assert_array_equal(smoothed.M_z_predicted, causal.M_z_predicted)


def test_a_change_of_the_ground_is_not_smoothed_over() -> None:
    t, psi, F_N, M_z = change_of_ground()
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3)
    smoothed = smooth(Ekf(**DECLARED, tuning=tuning), t, psi, F_N, M_z)

    assert smoothed.mu[np.abs(t - 6.0) < 0.5] == pytest.approx(1.5, abs=0.05)
    assert smoothed.mu[t > 10] == pytest.approx(1.1, abs=0.05)


@pytest.mark.parametrize(("first", "then"), [(0.08, 0.05), (0.3, 0.3)])
def test_what_is_usable_is_that_of_its_own_ground(first: float, then: float) -> None:
    t, psi, F_N, M_z = change_of_ground(first, then)
    observer, mu = Ekf(**{**DECLARED, "acquire": True}), np.where(t < 7, first, then)
    causal, smoothed = (call(observer, t, psi, F_N, M_z) for call in (run, smooth))
    wrong = np.abs(smoothed.mu_eff - mu) > 3 * smoothed.mu_eff_std

    # Until it is noticed a new ground is the filter's error, too.
    assert not (smoothed.usable & wrong & ((t < 7) | (t > 7.2))).any()
    assert not (smoothed.usable & (smoothed.status != 0)).any()
    assert not smoothed.usable[t < 0.2].any()
    assert smoothed.usable.sum() > 0.99 * causal.usable.sum() > 700
    # What is not usable before friction is known is that of this ground already.
    assert np.abs(smoothed.mu[0] - first) < 2 * smoothed.mu_std[0] < 0.3 * first


def test_what_later_samples_contradict_is_not_usable(
    recording: RigRecording, monkeypatch: pytest.MonkeyPatch
) -> None:
    observer, columns = Ekf(**DECLARED), columns_of(recording)
    monkeypatch.setattr("observers.interfaces.smoothing.DIFFERS", 0.1)
    causal, smoothed = run(observer, **columns), smooth(observer, **columns)
    differs = np.abs(np.log(smoothed.mu / causal.mu)) > 0.1 * causal.mu_std / causal.mu

    assert 0 < (causal.usable & differs).sum() < causal.usable.sum()
    np.testing.assert_array_equal(smoothed.usable, causal.usable & ~differs)


def test_samples_before_the_first_usable_one_take_its_friction(recording: RigRecording) -> None:
    observer, columns = Ekf(**DECLARED), columns_of(recording)
    columns["psi"] = np.where(columns["t"] < 0.3, np.nan, columns["psi"])
    smoothed = smooth(observer, **columns)
    first = int(np.argmax(np.isfinite(columns["psi"])))

    assert smoothed.mu[:first] == pytest.approx(smoothed.mu[first])
    walked = smoothed.mu_std[0] ** 2 - smoothed.mu_std[first] ** 2
    assert walked == pytest.approx((0.01 * smoothed.mu[first]) ** 2 * columns["t"][first], rel=1e-9)
    assert np.isnan(smoothed.mu_eff[:first]).all()
    assert np.isfinite(smoothed.mu_eff[first:]).all()


def test_it_needs_the_filter(recording: RigRecording) -> None:
    with pytest.raises(InvalidInputError, match=r"smooth needs an Ekf, .* got Mhe"):
        smooth(Mhe(**DECLARED), **columns_of(recording))  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [3, pytest.param(60, marks=pytest.mark.long)])
def test_its_band_covers_the_truth(count: int) -> None:
    inside = []
    for seed in range(count):
        mu = float(np.exp(np.random.default_rng([seed, 7]).normal(0.0, 0.4)))
        made = make_recording(seed, mu=mu, k=K, duration=6.0, bristles=400)
        # Noise of 0.4 % of range; mu does not walk there.
        level = 0.004 * np.ptp(made.M_z_true) / slide()
        tuning = Tuning(**{**CLEAN_RIG, "noise": level, "mu_walk": 1e-4})
        smoothed = smooth(Ekf(**DECLARED, tuning=tuning), **columns_of(made))
        off = np.log(smoothed.mu / mu) * smoothed.mu / smoothed.mu_std
        inside.append(np.abs(off[[0, 200, 500]]) < 1.96)

    assert np.mean(inside) > (0.6 if count < 20 else 0.88)
