"""The errors of a model at each stage of a diagnosis: as declared, refitted, with the effects found."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.fits.fitting import Fit, Values, fit, initial_guess, signals_of, torque_range
from identification.fits.loss import Loss, rmse_of
from identification.fits.options import FitOptions
from identification.reading.recordings import Recording
from identification.results import Errors
from identification.selection.trial_runner import Submit
from identification.selection.trials import RANKING, Trial, fit_own_parameters, model_of, thin
from symbolic import simulate

Array = NDArray[np.float64]
WITHOUT_ONE = FitOptions(tolerance=1e-4)
"""For a fit that leaves one recording out; it begins at the fit of all."""


def declared_residuals(recordings: Sequence[Recording], loss: Loss) -> dict[str, Array]:
    """Residuals of the declared model with k as given; mu as given, or fitted where none is [N m]."""
    residuals: dict[str, Array] = {}
    for recording in recordings:
        model = model_of(())
        if recording.tyre.mu is None:
            own = initial_guess(model, [recording]).own
            start = Values(shared={"k": recording.tyre.k}, own=own)
            residuals |= fit(
                model, [recording], start, FitOptions(free_shared=False, loss=loss)
            ).residuals
        else:
            values = {"mu": recording.tyre.mu, "k": recording.tyre.k}
            theta = np.asarray(model.theta(values)).ravel()
            geometry = np.array([recording.rig.a, recording.rig.e])
            simulated = simulate(model, signals_of(recording), theta, geometry, np.eye(theta.size))
            residuals[recording.name] = simulated.M_z - recording.M_z
    return residuals


def trial_residuals(trial: Trial) -> dict[str, Array]:
    """Residuals of training and held-out recordings [N m]."""
    return {**trial.fitted.residuals, **(trial.held_out.residuals if trial.held_out else {})}


def errors_of(
    residuals: Mapping[str, Array],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array] | None = None,
) -> Errors:
    """The errors of these residuals [N m]; `left_out` are those of `left_out_residuals`."""
    everything = [*training, *holdout]
    rmse = {r.name: rmse_of(residuals[r.name]) for r in everything}
    return Errors(
        rmse=rmse,
        nrmse={r.name: rmse[r.name] / torque_range(r) for r in everything},
        training=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        left_out={r.name: rmse_of(left_out[r.name]) / torque_range(r) for r in training}
        if left_out
        else {},
    )


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
