"""Size and correlation time of a model's torque error on recordings that it was not fitted to."""

from collections.abc import Mapping, Sequence

import numpy as np

from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.loss import LEAST_SQUARES, Loss, influence
from identification.fits.problem import torque_range
from identification.reading.recordings import Recording
from symbolic import ModelError, full_slide_torque
from symbolic.arrays import Array

LIFTED = 0.05
"""Share of the median load below which a wheel is lifted [1]."""
SLIDES, SLID, MIN_SLIDES = 0.9, 0.5, 4
"""Share of the largest torque between two changes of sign at which the patch slides, least such torque
over the largest of all for it to have slid [1], and fewest changes of level that make a walk."""


def error_on_unseen(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], loss: Loss = LEAST_SQUARES
) -> ModelError | None:
    """The model error that these residuals show; every recording counts alike.

    Args:
        residuals: simulated minus measured torque of these recordings [N m], NaN where missing; on
            recordings to which no shared parameter was fitted.
        recordings: the recordings.
        loss: what a residual costs; an outlier counts as much as it influences the fit.

    Returns:
        None without recordings. The correlation time is the mean over recordings, weighted by the mean
        squares, as the uncertainty of a mean is by spread and time together.
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
        friction_walk=_friction_walk(residuals, recordings),
    )


def _friction_walk(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> float | None:
    """Change of ln of the friction level from slide to slide over the root of the time between.

    A slide is where the model's torque is near its largest before it changes sign; the level of friction
    there is the measured torque over the model's. None for fewer than `MIN_SLIDES` changes.
    """
    steps: list[float] = []
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
