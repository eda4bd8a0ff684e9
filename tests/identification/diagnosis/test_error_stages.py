"""Errors with each recording left out: against fits of the others, made here."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording, fit, initial_guess
from identification.diagnosis.error_stages import declared_errors, errors_of, left_out_residuals
from identification.fits.loss import rmse_of
from identification.fits.problem import torque_range
from identification.selection.leave_one_out_linearised import leave_one_out
from identification.selection.trial_runner import workers
from identification.selection.trials import Trial, TrialTask, fit_own_parameters, run_trial
from symbolic import Model, effects_named
from tests.identification.factories import read_campaign

EFFECTS = effects_named(["contact_damping"])


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return read_campaign("contact_damping", 3, recordings=3, duration=6.0)[1]


@pytest.fixture(scope="module")
def trial(recordings: list[Recording]) -> Trial:
    return run_trial(TrialTask(EFFECTS, recordings))


@pytest.mark.long
def test_left_out_in_turn(trial: Trial, recordings: list[Recording]) -> None:
    with workers(1) as submit:
        residuals = left_out_residuals(trial, recordings, submit)

    assert list(residuals) == [r.name for r in recordings]
    first_order = leave_one_out(trial.fitted, recordings)
    for left in recordings:
        others = [r for r in recordings if r is not left]
        model = Model(effects=EFFECTS)
        fitted = fit(model, others, initial_guess(model, others))
        exact = rmse_of(fit_own_parameters(fitted, [left]).residuals[left.name])
        assert rmse_of(residuals[left.name]) == pytest.approx(exact, rel=2e-3)
        assert rmse_of(residuals[left.name]) == pytest.approx(rmse_of(first_order[left.name]), rel=0.02)


def test_one_recording_cannot_be_left_out(trial: Trial, recordings: list[Recording]) -> None:
    with workers(1) as submit:
        assert left_out_residuals(trial, recordings[:1], submit) == {}


def test_friction_of_a_ground_that_was_not_fitted_is_not_predicted(
    recordings: list[Recording], trial: Trial
) -> None:
    here, there = recordings[:2], [replace(recordings[2], ground="wet"), recordings[2]]
    there[1] = replace(there[1], name="dry")
    for errors in (
        declared_errors(here, there, trial.fitted.loss),
        errors_of(run_trial(TrialTask((), here, there)), here, there, {}),
    ):
        assert set(errors.nrmse) == {"recording_a", "recording_b", "recording_c", "dry"}
        assert list(errors.unrefitted) == ["dry"]


def test_declared_errors_are_above_those_of_a_fit(recordings: list[Recording], trial: Trial) -> None:
    errors = declared_errors(recordings[:2], recordings[2:], trial.fitted.loss)

    assert (errors.training, errors.holdout) == (("recording_a", "recording_b"), ("recording_c",))
    assert list(errors.unrefitted) == ["recording_c"]
    for recording in recordings:
        relative = errors.rmse[recording.name] / torque_range(recording)
        assert errors.nrmse[recording.name] == pytest.approx(relative)
        assert np.isfinite(relative)
        assert errors.rmse[recording.name] > rmse_of(trial.fitted.residuals[recording.name])
