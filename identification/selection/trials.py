"""One model tried on recordings: fitted, judged, and thinned where it is only ranked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.fits.fitting import Fit, Values, fit, initial_guess
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.fits.options import COARSE_FIT, FINE_FIT, FitOptions
from identification.reading.recordings import Recording
from identification.selection.scoring import Judgement, judged, leave_one_out
from symbolic import Model, effects_named

CORNERS = 16
"""Zone corners kept in identification; beyond this depth they carry less than 1e-6 of the torque."""
RANKING_STEP = 0.02
"""Recordings are thinned towards this time between samples while candidates are ranked [s]."""


@dataclass(frozen=True, kw_only=True)
class Precision:
    """How finely a model is fitted.

    Attributes:
        bristles: over the length of the patch, where the model has bristles.
        discretised: True takes bristles, which are quicker, even where the exact patch would do.
        options: of the fit; the loss is the task's.
    """

    bristles: int = 80
    discretised: bool = False
    options: FitOptions = FINE_FIT


FINE = Precision()
"""For whatever is reported."""
RANKING = Precision(discretised=True, options=COARSE_FIT)
"""For candidates that are only compared; the patch is right to 4e-4 of range."""
ROUGH = Precision(bristles=40, discretised=True, options=COARSE_FIT)
"""The same in half the time, where errors are above `ROUGH_ABOVE`."""
ROUGH_ABOVE = 0.015
"""Ten times the error over range that 40 bristles have [1]."""


@dataclass(frozen=True, eq=False)
class Task:
    """A trial to be made.

    Attributes:
        effects: names of the effects, in order of selection.
        training: recordings that the shared parameters are fitted to.
        holdout: recordings that judge; empty for leave-one-out over the training ones.
        start: values to begin with; None for those of `initial_guess`.
        precision: how finely.
        loss: what a residual costs.
    """

    effects: tuple[str, ...]
    training: Sequence[Recording]
    holdout: Sequence[Recording] = ()
    start: Values | None = None
    precision: Precision = FINE
    loss: Loss = LEAST_SQUARES


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """A model fitted to the training recordings and judged.

    Attributes:
        effects: names of its effects, in order of selection.
        fitted: the fit on the training recordings.
        held_out: the fit of what belongs to each held-out recording; None without any.
        judgement: how it does on the recordings by which it is judged.
    """

    effects: tuple[str, ...]
    fitted: Fit
    held_out: Fit | None
    judgement: Judgement

    @property
    def nrmse(self) -> float:
        """The judged error over range [1]."""
        return self.judgement.nrmse


def model_of(effects: Sequence[str], precision: Precision = FINE) -> Model:
    """The model with these effects as the search uses it."""
    return Model(
        effects=effects_named(effects),
        corners=CORNERS,
        discretised=precision.discretised,
        lengthways=precision.bristles,
    )


def attempt(task: Task) -> Trial:
    """Fit a model and judge it.

    With held-out recordings every shared parameter stays frozen on them. Without, each training
    recording is left out in turn (two or more of them), and the judged errors are those.
    """
    model = model_of(task.effects, task.precision)
    steered = replace(task.precision.options, loss=task.loss)
    fitted = fit(model, task.training, task.start, steered)
    held_out = freeze(fitted, task.holdout, steered) if task.holdout else None
    return judged_trial(task, fitted, held_out)


def judged_trial(task: Task, fitted: Fit, held_out: Fit | None) -> Trial:
    """The trial that these fits make."""
    if held_out:
        judgement = judged(held_out.residuals, task.holdout, task.loss)
    else:
        judgement = judged(leave_one_out(fitted, task.training), task.training, task.loss)
    return Trial(effects=task.effects, fitted=fitted, held_out=held_out, judgement=judgement)


def thinned(recording: Recording) -> Recording:
    """Every so many samples of a recording, such that they are at most `RANKING_STEP` apart.

    Between reversals it hardly matters how often the patch is looked at: without creep not at all, with
    it by 1e-3 of range rms at the strongest. A recording with missing torques stays as it is.
    """
    if not np.isfinite(recording.M_z).all():
        return recording
    stride = max(1, int(RANKING_STEP / float(np.diff(recording.t).max()) + 1e-6))
    arrays = ("t", "psi", "psi_dot", "M_z", "F_N")
    return replace(recording, M=None, **{name: getattr(recording, name)[::stride] for name in arrays})


def freeze(fitted: Fit, recordings: Sequence[Recording], options: FitOptions = FINE_FIT) -> Fit:
    """Fit only what belongs to these recordings, with the shared parameters of `fitted`."""
    own = initial_guess(fitted.model, recordings).own
    start = Values(shared=fitted.values.shared, own=own)
    return fit(fitted.model, recordings, start, replace(options, free_shared=False, loss=fitted.loss))
