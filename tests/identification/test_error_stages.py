"""Errors with each recording left out: against fits of the others, made here."""

import numpy as np
import pytest

from identification import Fit, FitOptions, Recording, Values, fit, initial_guess
from identification.error_stages import declared_friction, declared_residuals, left_out_residuals
from identification.fits.loss import rmse_of
from identification.fits.problem import torque_range
from identification.selection.leave_one_out import leave_one_out
from identification.selection.trial_runner import workers
from identification.selection.trials import Trial, TrialTask, run_trial
from symbolic import Model, effects_named
from tests.identification.factories import read_campaign

EFFECTS = effects_named(["contact_damping"])


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return read_campaign("contact_damping", 3, recordings=3, duration=6.0)[1]


@pytest.fixture(scope="module")
def trial(recordings: list[Recording]) -> Trial:
    return run_trial(TrialTask(EFFECTS, recordings))


def predicted(fitted: Fit, left: Recording) -> float:
    """Error on a recording that the fit has not seen, mu alone fitted to it."""
    own = initial_guess(fitted.model, [left]).own
    start = Values(tyre=fitted.values.tyre, own=own)
    alone = fit(fitted.model, [left], start, FitOptions(free_shared=False))
    return rmse_of(alone.residuals[left.name]) / torque_range(left)


@pytest.mark.long
def test_left_out_in_turn(trial: Trial, recordings: list[Recording]) -> None:
    model = Model(effects=EFFECTS)
    with workers(1) as submit:
        residuals = left_out_residuals(trial, recordings, submit)
    errors = {r.name: rmse_of(residuals[r.name]) / torque_range(r) for r in recordings}

    assert list(residuals) == [r.name for r in recordings]
    first_order = leave_one_out(trial.fitted, recordings)
    for left in recordings:
        others = [r for r in recordings if r is not left]
        fitted = fit(model, others, initial_guess(model, others))
        assert errors[left.name] == pytest.approx(predicted(fitted, left), rel=2e-3)
        near = rmse_of(first_order[left.name]) / torque_range(left)
        assert errors[left.name] == pytest.approx(near, rel=0.02)


def test_one_recording_cannot_be_left_out(trial: Trial, recordings: list[Recording]) -> None:
    with workers(1) as submit:
        assert left_out_residuals(trial, recordings[:1], submit) == {}


def test_declared_residuals(recordings: list[Recording], trial: Trial) -> None:
    residuals = declared_residuals(recordings, declared_friction(recordings, trial.fitted.loss))

    assert set(residuals) == {r.name for r in recordings}
    for recording in recordings:
        assert np.isfinite(residuals[recording.name]).all()
        fitted = rmse_of(trial.fitted.residuals[recording.name])
        assert rmse_of(residuals[recording.name]) > fitted
