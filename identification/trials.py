"""One model tried on recordings: fitted, judged, and thinned where it is only ranked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.fitting import COARSE, TOLERANCE, Fit, Values, first_values, fit
from identification.recordings import Recording
from identification.scoring import Judgement, judged, leave_one_out
from symbolic import Model, effects_named

CORNERS = 16
"""Zone corners kept in identification; beyond this depth they carry less than 1e-6 of the torque."""
RANKING_STEP = 0.02
"""Recordings are thinned towards this time between samples while candidates are ranked [s]."""


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


def model_of(effects: Sequence[str], *, coarse: bool = False) -> Model:
    """The model with these effects as the search uses it; `coarse` takes bristles, which are quicker."""
    return Model(effects=effects_named(effects), corners=CORNERS, discretised=coarse)


def attempt(
    effects: Sequence[str],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    start: Values | None = None,
    tolerance: float = TOLERANCE,
) -> Trial:
    """Fit a model and judge it.

    With held-out recordings every shared parameter stays frozen on them. Without, each training
    recording is left out in turn (two or more of them), and the judged errors are those.
    """
    model = model_of(effects, coarse=tolerance >= COARSE)
    begin = start or first_values(model, training)
    fitted = fit(model, training, begin, tolerance=tolerance)
    if holdout:
        held_out = freeze(fitted, holdout, tolerance)
        return Trial(
            effects=tuple(effects),
            fitted=fitted,
            held_out=held_out,
            judgement=judged(held_out.residuals, holdout),
        )
    judgement = judged(leave_one_out(fitted, training), training)
    return Trial(effects=tuple(effects), fitted=fitted, held_out=None, judgement=judgement)


def thinned(recording: Recording) -> Recording:
    """Every so many samples of a recording, such that they are at most `RANKING_STEP` apart.

    The patch is rate-independent: between reversals it does not matter how often it is looked at. A
    recording with missing torques stays as it is.
    """
    if not np.isfinite(recording.M_z).all():
        return recording
    stride = max(1, int(RANKING_STEP / float(np.diff(recording.t).max()) + 1e-6))
    arrays = ("t", "psi", "psi_dot", "M_z", "F_N")
    return replace(recording, M=None, **{name: getattr(recording, name)[::stride] for name in arrays})


def freeze(fitted: Fit, recordings: Sequence[Recording], tolerance: float = TOLERANCE) -> Fit:
    """Fit only what belongs to these recordings, with the shared parameters of `fitted`."""
    own = first_values(fitted.model, recordings).own
    start = Values(shared=fitted.values.shared, own=own)
    return fit(fitted.model, recordings, start, free_shared=False, tolerance=tolerance)
