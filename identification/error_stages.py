"""The errors of a model at each stage of a diagnosis: as declared, refitted, with the effects found."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.findings import Errors
from identification.fits.fitting import Fit, fit
from identification.fits.loss import Loss, rmse_of
from identification.fits.options import FitOptions
from identification.fits.problem import torque_range
from identification.fits.values import Values, initial_guess
from identification.prediction import predicted_friction, residual_of
from identification.reading.recordings import Recording
from identification.selection.trial_runner import Submit
from identification.selection.trials import RANKING, Trial, fit_own_parameters, model_of, thin
from symbolic import TOLERATED

Array = NDArray[np.float64]
WITHOUT_ONE = FitOptions(tolerance=1e-4)
"""For a fit that leaves one recording out; it begins at the fit of all."""


def declared_friction(recordings: Sequence[Recording], loss: Loss) -> dict[str, float]:
    """Mu of each recording as given, or fitted to the declared model, k as given, where none is [1]."""
    model, friction = model_of(()), {}
    for recording in recordings:
        given = recording.tyre.mu
        if given is None:
            own = initial_guess(model, [recording]).own
            start = Values(tyre={"k": recording.tyre.k}, own=own)
            exact = [(recording.name, name) for name in TOLERATED]
            options = FitOptions(free_shared=False, loss=loss, fixed=exact)
            given = fit(model, [recording], start, options).values.own[recording.name]["mu"]
        friction[recording.name] = given
    return friction


def declared_residuals(
    recordings: Sequence[Recording], friction: Mapping[str, float]
) -> dict[str, Array]:
    """Residuals of the declared model with k as given [N m].

    Args:
        recordings: the recordings.
        friction: mu of each.
    """
    return {
        r.name: residual_of(model_of(()), r, {"mu": friction[r.name], "k": r.tyre.k}) for r in recordings
    }


def declared_unrefitted(
    friction: Mapping[str, float], training: Sequence[Recording], holdout: Sequence[Recording]
) -> dict[str, Array]:
    """Residuals of held-out recordings, declared model, mu as given or that of their ground [N m]."""
    predicted = {
        r.name: predicted_friction(friction, training, r) if r.tyre.mu is None else r.tyre.mu
        for r in holdout
    }
    return declared_residuals(holdout, predicted)


def trial_residuals(trial: Trial) -> dict[str, Array]:
    """Residuals of training and held-out recordings [N m]."""
    return {**trial.fitted.residuals, **(trial.held_out.residuals if trial.held_out else {})}


def errors_of(
    residuals: Mapping[str, Array],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array] | None = None,
    unrefitted: Mapping[str, Array] | None = None,
) -> Errors:
    """The errors of these residuals [N m].

    Args:
        residuals: of all recordings.
        training: recordings that the shared parameters were fitted to.
        holdout: the others.
        left_out: what `left_out_residuals` returns.
        unrefitted: residuals of held-out recordings of which nothing was fitted.
    """
    everything = [*training, *holdout]
    rmse = {r.name: rmse_of(residuals[r.name]) for r in everything}
    return Errors(
        rmse=rmse,
        nrmse={r.name: rmse[r.name] / torque_range(r) for r in everything},
        training=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        left_out=_over_range(left_out or {}, training),
        unrefitted=_over_range(unrefitted or {}, holdout),
    )


def _over_range(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> dict[str, float]:
    return {
        r.name: rmse_of(residuals[r.name]) / torque_range(r) for r in recordings if r.name in residuals
    }


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
    return {name: future.result() for name, future in futures.items()}


def _left_out(trial: Trial, others: Sequence[Recording], left: Recording) -> Array:
    model, options = model_of(trial.effects, RANKING), replace(WITHOUT_ONE, loss=trial.fitted.loss)
    fitted = fit(model, others, trial.fitted.values, options)
    judged: Fit = fit_own_parameters(fitted, [left], WITHOUT_ONE)
    return judged.residuals[left.name]
