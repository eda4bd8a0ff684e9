"""A trial: one model fitted to the training recordings and judged, by held-out ones if there are any."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.fits.fitting import Fit, fit
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, Loss, rmse_of
from identification.fits.options import COARSE_FIT, FINE_FIT, FitOptions
from identification.fits.values_by_ground_and_recording import Values, initial_guess
from identification.reading.recordings import Recording
from identification.reading.trimming_and_thinning import recording_at_samples
from identification.selection.leave_one_out_linearised import leave_one_out
from symbolic import SEARCH_STEPS, Effect, Model
from symbolic.float_array_type import Array

CORNERS = 16
"""Zone corners kept in identification; beyond this depth they carry less than 1e-6 of the torque."""
RANKING_STEP = 0.02
"""Recordings are thinned towards this time between samples while candidates are ranked [s]."""
ROUGH_STEP = 0.04
"""The same where the error is large."""


@dataclass(frozen=True, kw_only=True)
class Precision:
    """How finely a model is fitted."""

    bristles: int = 80  # Over the length of the patch, where the model has bristles.
    # Newton steps of what is in series with the patch; after two the torque is right to 1e-6 of range
    # rms where samples are 20 ms apart.
    newton_steps: int = SEARCH_STEPS
    step: float = RANKING_STEP  # Towards which recordings are thinned where candidates are compared [s].
    discretised: bool = False  # Bristles, which are quicker, even where the exact patch would do.
    options: FitOptions = FINE_FIT  # Of the fit; the loss is the task's.


FINE = Precision()
"""For whatever is reported."""
RANKING = Precision(discretised=True, newton_steps=2, options=COARSE_FIT)
"""For candidates that are only compared; the patch is right to 4e-4 of range."""
ROUGH = replace(RANKING, bristles=40, step=ROUGH_STEP)
"""The same in a quarter of the time, for errors far above that of 40 bristles, 1.5e-3 of range."""


@dataclass(frozen=True, eq=False)
class TrialTask:
    """The inputs of a trial; can be pickled where the classes of its effects can be imported."""

    effects: tuple[Effect, ...]  # In order of selection.
    training: Sequence[Recording]  # Recordings that the shared parameters are fitted to.
    # Recordings that judge, with every shared parameter as fitted; empty for leave-one-out over the
    # training ones.
    holdout: Sequence[Recording] = ()
    # Values to begin with, of held-out recordings too where they are known; None for those of
    # `initial_guess`.
    start: Values | None = None
    precision: Precision = FINE
    loss: Loss = LEAST_SQUARES


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement:
    """The errors of a model on the recordings by which it is judged."""

    residuals: Mapping[str, Array]  # Torque errors [N m], outliers as small as the loss counts them.
    ranges: Mapping[str, float]  # Torque ranges [N m].
    times: Mapping[str, Array]  # [s].

    @property
    def nrmse(self) -> float:
        """Root mean square error, divided by the torque range, averaged over recordings [1]."""
        return float(np.mean([rmse_of(self.residuals[n]) / self.ranges[n] for n in self.ranges]))

    def block_errors(self, seconds: float) -> Array:
        """Mean squared error over range in blocks, the blocks of all recordings in one row [1].

        Every recording is cut into equal blocks of about so many seconds; blocks in which less than half
        of the samples have a torque are left out.
        """
        blocks = []
        for name, residual in self.residuals.items():
            since = self.times[name] - self.times[name][0]
            count = max(1, round(float(since[-1]) / seconds))
            index = np.minimum((since / since[-1] * count).astype(int), count - 1)
            squared = (residual / self.ranges[name]) ** 2
            present = np.isfinite(squared)
            sums = np.bincount(index[present], squared[present], minlength=count)
            counts = np.bincount(index[present], minlength=count)
            enough = 2 * counts >= counts.max()
            blocks.append(sums[enough] / counts[enough])
        return np.concatenate(blocks)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """A model fitted to the training recordings and judged."""

    fitted: Fit  # The fit on the training recordings.
    held_out: Fit | None  # The fit of what belongs to each held-out recording; None without any.
    judgement: Judgement  # Its errors on the recordings by which it is judged.

    @property
    def values(self) -> Values:
        """All fitted values, those of held-out recordings too: where a further trial begins."""
        own, rig = (
            {name: place for fitted in self.fits for name, place in getattr(fitted.values, of).items()}
            for of in ("own", "rig")
        )
        return replace(self.fitted.values, own=own, rig=rig)

    @property
    def fits(self) -> tuple[Fit, ...]:
        """The fit on the training recordings and, if there is one, that on the held-out ones."""
        return (self.fitted, self.held_out) if self.held_out else (self.fitted,)

    @property
    def residuals(self) -> dict[str, Array]:
        """Residuals of training and held-out recordings [N m]."""
        return {name: r for fitted in self.fits for name, r in fitted.residuals.items()}

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Its effects, in order of selection."""
        return self.fitted.model.effects

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its effects."""
        return tuple(effect.name for effect in self.effects)

    @property
    def nrmse(self) -> float:
        """The judged error, divided by the torque range [1]."""
        return self.judgement.nrmse


def model_of(effects: Sequence[Effect], precision: Precision = FINE) -> Model:
    """The model with these effects as the search uses it."""
    return Model(
        effects=tuple(effects),
        corners=CORNERS,
        discretised=precision.discretised,
        bristles=precision.bristles,
        search_steps=precision.newton_steps,
    )


def run_trial(task: TrialTask, threads: int = 1) -> Trial:
    """Fit a model and judge it, simulating so many recordings at a time."""
    model = model_of(task.effects, task.precision)
    options = replace(task.precision.options, loss=task.loss, threads=threads)
    start, names = task.start, [recording.name for recording in task.training]
    if start:
        own, rig = ({n: of[n] for n in names if n in of} for of in (start.own, start.rig))
        start = replace(start, own=own, rig=rig)
    fitted = fit(model, task.training, start, options)
    held_out = (
        fit_recording_parameters(fitted, task.holdout, options, task.start) if task.holdout else None
    )
    return trial_of(task, fitted, held_out)


def trial_of(task: TrialTask, fitted: Fit, held_out: Fit | None) -> Trial:
    """The trial with these fits, judged."""
    if held_out:
        judgement = judge(held_out.residuals, task.holdout, task.loss)
    else:
        judgement = judge(leave_one_out(fitted, task.training), task.training, task.loss)
    return Trial(fitted=fitted, held_out=held_out, judgement=judgement)


def thin_for_ranking(recording: Recording, step: float = RANKING_STEP) -> Recording:
    """Every so many samples of a recording, such that they are at most `step` [s] apart.

    The torque between reversals hardly depends on the time between samples: without creep not at all,
    with the strongest creep by 1e-3 of range rms. A recording with missing torques stays as it is.
    """
    if not np.isfinite(recording.M_z).all():
        return recording
    stride = max(1, int(step / float(np.diff(recording.t).max()) + 1e-6))
    return recording_at_samples(replace(recording, M=None), np.arange(0, recording.t.size, stride))


def fit_recording_parameters(
    fitted: Fit,
    recordings: Sequence[Recording],
    options: FitOptions = FINE_FIT,
    begin: Values | None = None,
) -> Fit:
    """Fit only what belongs to these recordings, with the shared parameters of `fitted`.

    It begins with what `begin` knows of them, else with `initial_guess`. A recording on a ground of
    which `fitted` knows nothing gets the mean over the grounds that it knows.
    """
    guess = initial_guess(fitted.model, recordings).own
    known = begin or Values(tyre={}, own={})
    own = {name: {**values, **known.own.get(name, {})} for name, values in guess.items()}
    start = replace(fitted.values, own=own, rig={n: known.rig[n] for n in own if n in known.rig})
    weights = options.prior_weights
    if not own.keys() <= known.own.keys():
        # The residuals of a first guess say nothing of those that the model will leave.
        weights = {**fitted.prior_weights_of_recordings, **(weights or {})}
    own_only = replace(options, free_shared=False, loss=fitted.loss, prior_weights=weights)
    return fit(fitted.model, recordings, start, own_only)


def with_prior_weights(precision: Precision, present: Trial) -> Precision:
    """The precision at which rivals of a model are compared with it.

    What was declared with a tolerance weighs the same in all of them: as in the present model.
    """
    weights = {n: w for fitted in present.fits for n, w in fitted.prior_weights_of_recordings.items()}
    return replace(precision, options=replace(precision.options, prior_weights=weights or None))


def judge(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], loss: Loss = LEAST_SQUARES
) -> Judgement:
    """The judgement by these residuals of these recordings [N m]."""
    ranges = {r.name: torque_range(r) for r in recordings}
    return Judgement(
        residuals={n: np.sqrt(loss((residuals[n] / span) ** 2)[0]) * span for n, span in ranges.items()},
        ranges=ranges,
        times={r.name: r.t for r in recordings},
    )
