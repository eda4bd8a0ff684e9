"""Errors with each recording left out, against fits of the others, and of residuals of known size."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Huber, Recording, fit, initial_guess
from identification.diagnosis.torque_errors_by_stage import (
    declared_errors,
    left_out_residuals,
    model_error_on_unseen,
    torque_and_model_errors,
)
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, rmse_of
from identification.selection.leave_one_out_linearised import leave_one_out
from identification.selection.trial import Trial, TrialTask, fit_recording_parameters, run_trial
from identification.selection.trial_runner import TrialRunner, run_in_this_process
from symbolic import InvalidInputError, Model, ModelError, Rig, effects_named
from tests.identification.factories import first_order, read_campaign, recording

pytestmark = pytest.mark.usefixtures("interpreted")
EFFECTS = effects_named(["contact_damping"])


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return read_campaign("contact_damping", 3, recordings=3, duration=6.0)[1]


@pytest.fixture(scope="module")
def trial(recordings: list[Recording]) -> Trial:
    return run_trial(TrialTask(EFFECTS, recordings))


def runner_of(recordings: list[Recording]) -> TrialRunner:
    return TrialRunner(training=recordings, holdout=(), loss=LEAST_SQUARES, submit=run_in_this_process)


@pytest.mark.long
def test_left_out_in_turn(trial: Trial, recordings: list[Recording]) -> None:
    residuals = left_out_residuals(trial, runner_of(recordings))

    assert list(residuals) == [r.name for r in recordings]
    first_order = leave_one_out(trial.fitted, recordings)
    for left in recordings:
        others = [r for r in recordings if r is not left]
        model = Model(effects=EFFECTS)
        fitted = fit(model, others, initial_guess(model, others))
        exact = rmse_of(fit_recording_parameters(fitted, [left]).residuals[left.name])
        assert rmse_of(residuals[left.name]) == pytest.approx(exact, rel=2e-3)
        assert rmse_of(residuals[left.name]) == pytest.approx(rmse_of(first_order[left.name]), rel=0.02)


def test_one_recording_cannot_be_left_out(trial: Trial, recordings: list[Recording]) -> None:
    assert left_out_residuals(trial, runner_of(recordings[:1])) == {}


def test_friction_of_a_ground_that_was_not_fitted_is_not_predicted(
    recordings: list[Recording], trial: Trial
) -> None:
    here, there = recordings[:2], [replace(recordings[2], ground="wet"), recordings[2]]
    there[1] = replace(there[1], name="dry")
    fitted, _ = torque_and_model_errors(run_trial(TrialTask((), here, there)), here, there, {})
    for errors in (declared_errors(here, there, trial.fitted.loss), fitted):
        assert set(errors.nrmse) == {"recording_a", "recording_b", "recording_c", "dry"}
        assert list(errors.unrefitted) == ["dry"]


def test_declared_errors_are_above_those_of_a_fit(recordings: list[Recording], trial: Trial) -> None:
    errors = declared_errors(recordings[:2], recordings[2:], trial.fitted.loss)

    assert (errors.training, errors.holdout) == (("recording_a", "recording_b"), ("recording_c",))
    assert list(errors.unrefitted) == ["recording_c"]
    for one in recordings:
        relative = errors.rmse[one.name] / torque_range(one)
        assert errors.nrmse[one.name] == pytest.approx(relative)
        assert np.isfinite(relative)
        assert errors.rmse[one.name] > rmse_of(trial.fitted.residuals[one.name])


PERIOD, A = 0.01, 0.04


def turned(name: str, seconds: float = 400.0, load: float = 300.0) -> Recording:
    psi = 0.2 * np.sin(np.arange(round(seconds / PERIOD)) * PERIOD)
    return recording(name, psi=psi, period=PERIOD, load=load, rig=Rig(a=A, e=0.0))


def coloured(recording: Recording, share: float, time: float, seed: int = 0) -> np.ndarray:
    """A first-order process of this standard deviation, over full slide, and time constant."""
    rng = np.random.default_rng(seed)
    return share * 0.375 * recording.F_N * A * first_order(np.exp(-PERIOD / time), recording.t.size, rng)


def error_of(residuals: dict[str, np.ndarray], recordings: list[Recording], *loss: Huber) -> ModelError:
    found = model_error_on_unseen(residuals, recordings, *loss)
    assert found is not None
    return found


def test_spread_and_time_of_a_first_order_error() -> None:
    one = turned("one")
    found = error_of({"one": coloured(one, 0.05, 0.2)}, [one])

    assert found.spread == pytest.approx(0.05, rel=0.1)
    # The sum of the autocorrelation ends where that is below 0.05.
    assert found.correlation_time == pytest.approx(2 * 0.2 * 0.95, rel=0.15)


@pytest.mark.parametrize(("every", "other"), [(2, 200.0), (50, 1.0)], ids=["half", "lifted"])
def test_the_load_of_every_sample_counts_unless_the_wheel_is_lifted(every: int, other: float) -> None:
    one = turned("one", seconds=40.0)
    loads = np.where(np.arange(one.t.size) % every, 400.0, other)
    residual = 0.03 * 0.375 * A * (loads if every == 2 else np.full(one.t.size, 400.0))
    found = error_of({"one": residual}, [replace(one, F_N=loads)])

    assert found.spread == pytest.approx(0.03, rel=1e-12)


def test_friction_that_walks_from_slide_to_slide() -> None:
    one = turned("one", seconds=2000.0)
    slides = np.cos(np.arange(one.t.size) * PERIOD)
    count = np.cumsum(np.diff(np.sign(slides), prepend=1.0) != 0)
    walk = 0.03 * np.sqrt(np.pi) * np.random.default_rng(4).standard_normal(count[-1] + 1)
    torque = np.clip(-3 * slides, -1, 1)
    measured = torque * np.exp(np.cumsum(walk))[count]
    measured[::7] = np.nan
    found = error_of({"one": torque - measured}, [replace(one, M_z=measured)])
    short = error_of({"s": (torque - measured)[:700]}, [replace(turned("s", 7.0), M_z=measured[:700])])

    assert found.friction_walk == pytest.approx(0.03, rel=0.05)
    assert short.friction_walk is None


def test_recordings_count_alike_and_their_times_by_their_power() -> None:
    large, small = turned("large", 100.0, load=1000.0), turned("small", 50.0)
    residuals = {"large": coloured(large, 0.06, 0.5, 1), "small": coloured(small, 0.02, 0.05, 2)}
    both = error_of(residuals, [large, small])
    alone = [error_of(residuals, [r]) for r in (large, small)]

    assert both.spread == pytest.approx(np.hypot(alone[0].spread, alone[1].spread) / np.sqrt(2))
    power = [a.spread**2 for a in alone]
    times = [a.correlation_time for a in alone]
    assert both.correlation_time == pytest.approx(np.average(times, weights=power))


def test_missing_samples_change_nothing() -> None:
    one = turned("one")
    residual = coloured(one, 0.05, 0.2)
    whole = error_of({"one": residual}, [one])
    gaps = residual.copy()
    gaps[1::2] = np.nan
    half = error_of({"one": gaps}, [one])

    assert half.spread == pytest.approx(whole.spread, rel=0.02)
    assert half.correlation_time == pytest.approx(whole.correlation_time, rel=0.05)


def test_outliers_count_as_in_the_fit() -> None:
    one = turned("one")
    residual = coloured(one, 0.01, 0.02)
    spiked = residual.copy()
    spiked[::500] += 5.0
    found = [error_of({"one": r}, [one], Huber(threshold=0.2)) for r in (residual, spiked)]

    assert found[1].spread < 1.5 * found[0].spread


def test_nothing_seen_is_nothing_known() -> None:
    one = turned("one", seconds=1.0)
    assert model_error_on_unseen({}, []) is None
    exact = error_of({"one": np.zeros(one.t.size)}, [one])
    assert (exact.spread, exact.correlation_time) == (0.0, pytest.approx(PERIOD))


@pytest.mark.parametrize("values", [(-0.1, 1.0), (0.1, 0.0), (float("nan"), 1.0), (0.1, float("inf"))])
def test_ranges(values: tuple[float, float]) -> None:
    with pytest.raises(InvalidInputError, match=r"spread|correlation_time"):
        ModelError(spread=values[0], correlation_time=values[1])
