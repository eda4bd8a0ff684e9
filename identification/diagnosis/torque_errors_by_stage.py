"""The torque errors of a model at each stage of a diagnosis: as declared, refitted, with effects.

And how wrong it is on recordings to which its shared parameters were not fitted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from identification.diagnosis.result_parts import TorqueErrors
from identification.diagnosis.unrefitted_prediction import (
    friction_from_training,
    simulated_minus_measured,
    unrefitted_residuals,
)
from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.fitting import fit
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, Loss, influence, rmse_of
from identification.fits.options import FitOptions
from identification.fits.values_by_ground_and_recording import (
    Values,
    ground_of,
    initial_guess,
    rig_parameters,
)
from identification.reading.recordings import Recording
from identification.selection.trial import RANKING, Trial, fit_recording_parameters, model_of
from identification.selection.trial_runner import TrialRunner, results_of
from symbolic import ModelError, full_slide_torque
from symbolic.float_array_type import Array

LIFTED = 0.05
"""Share of the median load below which a wheel is lifted [1]."""
SLIDES, SLID, MIN_SLIDES = 0.9, 0.5, 4
"""Share of the largest torque between two changes of sign at which the patch slides, least such torque
over the largest of all for it to have slid [1], and fewest changes of level that make a walk."""


def model_error_on_unseen(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], loss: Loss = LEAST_SQUARES
) -> ModelError | None:
    """The model error that residuals [N m] of recordings show to which no shared parameter was fitted.

    Every recording counts alike, an outlier as much as it influences the fit. The correlation time is
    the mean over recordings, weighted by the mean squares, as the uncertainty of a mean is by spread and
    time together. None without recordings.
    """
    powers, relative, times = [], [], []
    for recording in recordings:
        span = torque_range(recording)
        counted = influence(loss, residuals[recording.name] / span) * span
        # A lifted wheel says nothing; over its small load any error would be large.
        load = np.where(LIFTED * np.median(recording.F_N) <= recording.F_N, recording.F_N, np.nan)
        share = counted / full_slide_torque(load, recording.rig.a)
        present = np.isfinite(share)
        # The autocorrelation time counts the samples that are there.
        period = float(recording.t[-1] - recording.t[0]) / max(int(present.sum()) - 1, 1)
        powers.append(float(np.mean(share[present] ** 2)))
        relative.append(float(np.mean((counted[present] / (span / 2)) ** 2)))
        times.append(autocorrelation_time(share) * period)
    if not powers:
        return None
    weights = np.array(powers) if sum(powers) > 0 else np.ones(len(powers))
    return ModelError(
        spread=float(np.sqrt(np.mean(powers))),
        correlation_time=float(np.average(times, weights=weights)),
        relative=float(np.sqrt(np.mean(relative))),
        friction_walk=_friction_random_walk_rate(residuals, recordings),
    )


def _friction_random_walk_rate(
    residuals: Mapping[str, Array], recordings: Sequence[Recording]
) -> float | None:
    """Change of ln of the friction level, measured torque over the model's, from slide to slide."""
    steps: list[float] = []  # Each over the root of the time between.
    for recording in recordings:
        # The model's torque has no noise, so that its sign changes once where the patch is loaded anew.
        torque, last = recording.M_z + residuals[recording.name], None
        known = np.isfinite(torque)
        t, M_z, torque = recording.t[known], recording.M_z[known], torque[known]
        size = np.abs(torque)
        borders = np.flatnonzero(np.diff(np.sign(torque)) != 0) + 1
        for place in np.split(np.arange(torque.size), borders):
            least = max(size[place].max(initial=0.0), SLID * size.max(initial=0.0))
            place = place[size[place] > SLIDES * least]
            level = np.sum((M_z * np.sign(torque))[place])
            if place.size > 1 and level > 0:
                now = float(t[place].mean()), float(np.log(level / np.sum(size[place])))
                steps += [(now[1] - last[1]) / np.sqrt(now[0] - last[0])] if last else []
                last = now
    return float(np.sqrt(np.mean(np.square(steps)))) if len(steps) >= MIN_SLIDES else None


WITHOUT_ONE = FitOptions(tolerance=1e-4)
"""For a fit that leaves one recording out; it begins at the fit of all."""


def declared_errors(
    training: Sequence[Recording], holdout: Sequence[Recording], loss: Loss
) -> TorqueErrors:
    """Errors of the declared model with k and mu as given.

    Where no mu is given, it is fitted; for the errors without any fit it is that of the ground.
    """
    everything = [*training, *holdout]
    friction = declared_or_fitted_mu(everything, loss)
    predicted = {
        r.name: friction_from_training(friction, training, r) if r.tyre.mu is None else r.tyre.mu
        for r in holdout
    }
    unrefitted = _declared_residuals(on_training_grounds(training, holdout), predicted)
    return _errors(_declared_residuals(everything, friction), training, holdout, {}, unrefitted)


def on_training_grounds(training: Sequence[Recording], holdout: Sequence[Recording]) -> list[Recording]:
    """The held-out recordings on a ground of training recordings; no friction is known of others."""
    grounds = {ground_of(recording) for recording in training}
    return [recording for recording in holdout if ground_of(recording) in grounds]


def declared_or_fitted_mu(recordings: Sequence[Recording], loss: Loss) -> dict[str, float]:
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
    return {
        r.name: simulated_minus_measured(model, r, {"mu": friction[r.name], "k": r.tyre.k})
        for r in recordings
    }


def torque_and_model_errors(
    trial: Trial,
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array],
) -> tuple[TorqueErrors, ModelError | None]:
    """The errors of a trial's model, and how wrong it is on what no shared parameter was fitted to."""
    unrefitted = unrefitted_residuals(trial.fitted, training, on_training_grounds(training, holdout))
    unseen = (trial.residuals, holdout) if holdout else (left_out, training if left_out else ())
    errors = _errors(trial.residuals, training, holdout, left_out, unrefitted)
    return errors, model_error_on_unseen(*unseen, trial.fitted.loss)


def _errors(
    residuals: Mapping[str, Array],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Mapping[str, Array],
    unrefitted: Mapping[str, Array],
) -> TorqueErrors:
    everything = [*training, *holdout]
    return TorqueErrors(
        rmse={r.name: rmse_of(residuals[r.name]) for r in everything},
        nrmse=_rms_over_torque_range(residuals, everything),
        training=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        left_out=_rms_over_torque_range(left_out, training),
        unrefitted=_rms_over_torque_range(unrefitted, holdout),
    )


def _rms_over_torque_range(
    residuals: Mapping[str, Array], recordings: Sequence[Recording]
) -> dict[str, float]:
    """Root mean square of the residuals that are known, over each recording's torque range [1]."""
    known = [r for r in recordings if r.name in residuals]
    return {r.name: rmse_of(residuals[r.name]) / torque_range(r) for r in known}


def left_out_residuals(trial: Trial, runner: TrialRunner) -> dict[str, Array]:
    """Residuals of each training recording by the shared parameters of all others [N m].

    The others are fitted anew without it, thinned; then what belongs to the recording is fitted to the
    whole of it, as on held-out data. Empty where recordings are held out or there is only one.
    """
    if runner.holdout or len(runner.training) < 2:
        return {}
    futures = {}
    for left in runner.training:
        others = [recording for recording in runner.thinned_training if recording.name != left.name]
        futures[left.name] = runner.submit(_left_out_residual, trial, others, left)
    return results_of(futures)


def _left_out_residual(trial: Trial, others: Sequence[Recording], left: Recording) -> Array:
    model, options = model_of(trial.effects, RANKING), replace(WITHOUT_ONE, loss=trial.fitted.loss)
    fitted = fit(model, others, trial.fitted.values, options)
    return fit_recording_parameters(fitted, [left], WITHOUT_ONE).residuals[left.name]
