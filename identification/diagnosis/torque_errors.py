"""The torque errors of a model at each stage of a diagnosis: as declared, refitted, with effects."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from identification.diagnosis.findings import Errors
from identification.diagnosis.prediction import predicted_friction, residual_of, unrefitted_residuals
from identification.fits.fitting import fit
from identification.fits.loss import Loss, rmse_of
from identification.fits.options import FitOptions
from identification.fits.problem import torque_range
from identification.fits.values import Values, initial_guess, rig_parameters
from identification.reading.recordings import Recording
from identification.residuals.error_on_unseen import error_on_unseen
from identification.selection.trial_runner import Submit, results_of
from identification.selection.trials import RANKING, Trial, fit_own_parameters, model_of, thin
from symbolic import ModelError
from symbolic.arrays import Array

WITHOUT_ONE = FitOptions(tolerance=1e-4)
"""For a fit that leaves one recording out; it begins at the fit of all."""


def declared_errors(training: Sequence[Recording], holdout: Sequence[Recording], loss: Loss) -> Errors:
    """Errors of the declared model with k and mu as given.

    Where no mu is given, it is fitted; for the errors without any fit it is that of the ground.
    """
    everything = [*training, *holdout]
    friction = declared_friction(everything, loss)
    predicted = {
        r.name: predicted_friction(friction, training, r) if r.tyre.mu is None else r.tyre.mu
        for r in holdout
    }
    unrefitted = _declared_residuals(holdout, predicted)
    return _errors(_declared_residuals(everything, friction), training, holdout, {}, unrefitted)


def declared_friction(recordings: Sequence[Recording], loss: Loss) -> dict[str, float]:
    """Mu of each recording as given, or fitted to the declared model, k as given, where none is [1]."""
    model, friction = model_of(()), {}
    for recording in recordings:
        given = recording.tyre.mu
        if given is None:
            own = initial_guess(model, [recording]).own
            start = Values(tyre={"k": recording.tyre.k}, own=own)
            exact = [(recording.name, name) for name in rig_parameters(recording)]
            options = FitOptions(free_shared=False, loss=loss, fixed=exact)
            given = fit(model, [recording], start, options).values.own[recording.name]["mu"]
        friction[recording.name] = given
    return friction


def _declared_residuals(
    recordings: Sequence[Recording], friction: Mapping[str, float]
) -> dict[str, Array]:
    model = model_of(())
    return {r.name: residual_of(model, r, {"mu": friction[r.name], "k": r.tyre.k}) for r in recordings}


def errors_of(
    trial: Trial,
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array],
) -> Errors:
    """The errors of a trial's model.

    Args:
        trial: the model, fitted.
        training: recordings that the shared parameters were fitted to.
        holdout: the others.
        left_out: what `left_out_residuals` returns, or nothing.
    """
    unrefitted = unrefitted_residuals(trial.fitted, training, holdout)
    return _errors(trial.residuals, training, holdout, left_out, unrefitted)


def _errors(
    residuals: Mapping[str, Array],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array],
    unrefitted: Mapping[str, Array],
) -> Errors:
    everything = [*training, *holdout]
    return Errors(
        rmse={r.name: rmse_of(residuals[r.name]) for r in everything},
        nrmse=_relative(residuals, everything),
        training=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        left_out=_relative(left_out, training if left_out else ()),
        unrefitted=_relative(unrefitted, holdout),
    )


def _relative(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> dict[str, float]:
    """Root mean square of each residual over its recording's torque range [1]."""
    return {r.name: rmse_of(residuals[r.name]) / torque_range(r) for r in recordings}


def error_on_unseen_of(
    trial: Trial,
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array],
) -> ModelError | None:
    """How wrong a trial's model is on recordings that no shared parameter was fitted to."""
    if holdout:
        return error_on_unseen(trial.residuals, holdout, trial.fitted.loss)
    return error_on_unseen(left_out, training if left_out else (), trial.fitted.loss)


def left_out_residuals(
    trial: Trial, recordings: Sequence[Recording], submit: Submit
) -> dict[str, Array]:
    """Residuals of each recording by the shared parameters of all others [N m].

    The others are fitted anew without it, thinned; then what belongs to the recording is fitted to the
    whole of it, as on held-out data. Empty for fewer than two recordings.
    """
    if len(recordings) < 2:
        return {}
    thinned = {recording.name: thin(recording) for recording in recordings}
    futures = {
        left.name: submit(_left_out, trial, [r for n, r in thinned.items() if n != left.name], left)
        for left in recordings
    }
    return results_of(futures)


def _left_out(trial: Trial, others: Sequence[Recording], left: Recording) -> Array:
    model, options = model_of(trial.effects, RANKING), replace(WITHOUT_ONE, loss=trial.fitted.loss)
    fitted = fit(model, others, trial.fitted.values, options)
    return fit_own_parameters(fitted, [left], WITHOUT_ONE).residuals[left.name]
