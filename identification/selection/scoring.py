"""Figures by which models are compared: errors over range, information criterion, paired test."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.fitting import Fit, torque_range
from identification.fits.loss import LEAST_SQUARES, Loss, cost, influence
from identification.reading.recordings import Recording

Array = NDArray[np.float64]
BLOCK, LONG_BLOCK = 1.0, 4.0
"""Length of the blocks in which residuals are taken as independent [s]; the long one outlasts what the
residual of a real tyre remembers."""
LEAST_GAIN = 0.02
"""Something has to lower the judged error by this share to be worth it [1]."""
RESOLUTION = 5e-4
"""It has to explain more than this of the range, the accuracy of the discretised patch [1]."""
EARNED, CLEAR = 1.0, 2.0
"""Standard errors on the judged data by which it has to help, and by which two have to differ to be told
apart."""
STRONG = 6.0
"""Difference in the information criterion from which evidence is strong (Kass and Raftery, JASA 90
(1995) 773) [1]."""


def rmse_of(residual: Array) -> float:
    """Root mean square, missing samples left out."""
    return float(np.sqrt(np.nanmean(residual**2)))


def effective_samples(residuals: Mapping[str, Array]) -> float:
    """Number of independent samples in the residuals of several recordings."""
    return sum(
        float(np.isfinite(residual).sum()) / autocorrelation_time(residual)
        for residual in residuals.values()
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement:
    """How a model does on the recordings by which it is judged.

    Attributes:
        residuals: torque error of each recording [N m], outliers as small as the loss counts them.
        ranges: torque range of each [N m].
        times: time of each [s].
    """

    residuals: Mapping[str, Array]
    ranges: Mapping[str, float]
    times: Mapping[str, Array]

    @property
    def nrmse(self) -> float:
        """Root mean square error over range, averaged over recordings."""
        return float(np.mean([rmse_of(self.residuals[n]) / self.ranges[n] for n in self.ranges]))

    def squares(self, block: float = BLOCK) -> Array:
        """Mean squared error over range in blocks, all recordings in one row.

        Every recording is cut into equal blocks of about so many seconds; those of which less than half
        is there are left out.
        """
        blocks = []
        for name, residual in self.residuals.items():
            since = self.times[name] - self.times[name][0]
            count = max(1, round(float(since[-1]) / block))
            index = np.minimum((since / since[-1] * count).astype(int), count - 1)
            squared = (residual / self.ranges[name]) ** 2
            present = np.isfinite(squared)
            sums = np.bincount(index[present], squared[present], minlength=count)
            counts = np.bincount(index[present], minlength=count)
            there = 2 * counts >= counts.max()
            blocks.append(sums[there] / counts[there])
        return np.concatenate(blocks)


def judged(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], loss: Loss = LEAST_SQUARES
) -> Judgement:
    """The judgement of these residuals of these recordings."""
    ranges = {r.name: torque_range(r) for r in recordings}
    return Judgement(
        residuals={n: np.sqrt(loss((residuals[n] / span) ** 2)[0]) * span for n, span in ranges.items()},
        ranges=ranges,
        times={r.name: r.t for r in recordings},
    )


def leave_one_out(fitted: Fit, recordings: Sequence[Recording]) -> dict[str, Array]:
    """Residuals of every recording had it not been fitted, to first order of the parameters [N m].

    The shared parameters move by the Gauss-Newton step of the other recordings alone, as far as their
    ranges allow; then what belongs to the recording is refitted. A single recording keeps its residuals.
    """
    if len(recordings) < 2:
        return dict(fitted.residuals)
    owners = np.array([owner or "" for owner, _ in fitted.labels])
    blocks, at = {}, 0
    for recording in recordings:
        present = np.isfinite(fitted.residuals[recording.name])
        rows = slice(at, at + int(present.sum()))
        blocks[recording.name] = (rows, present, torque_range(recording))
        at = rows.stop
    stacked = np.concatenate(
        [fitted.residuals[name][present] / span for name, (_, present, span) in blocks.items()]
    )
    # An outlier pulls as little as the loss lets it: rows weighted as in reweighted least squares.
    weight = np.sqrt(fitted.loss(stacked**2)[1])
    jacobian = fitted.jacobian * weight[:, None]
    residuals = {}
    for name, (rows, present, span) in blocks.items():
        others, mine = owners != name, owners == name
        shared = owners == ""
        rest = np.ones(stacked.size, dtype=bool)
        rest[rows] = False
        step = np.zeros(owners.size)
        step[others] = _within(
            fitted.bound_distances[:, others], jacobian[np.ix_(rest, others)], -(weight * stacked)[rest]
        )
        moved = stacked[rows] + fitted.jacobian[rows][:, shared] @ step[shared]
        again = _within(fitted.bound_distances[:, mine], jacobian[rows][:, mine], -weight[rows] * moved)
        left = np.full(present.size, np.nan)
        left[present] = (moved + fitted.jacobian[rows][:, mine] @ again) * span
        residuals[name] = left
    return residuals


def _within(room: Array, matrix: Array, target: Array) -> Array:
    """Least squares that stops where the room ends, one after the other (active set)."""
    step = np.zeros(matrix.shape[1])
    free = np.ones(step.size, dtype=bool)
    while free.any():
        step[free] = _least_squares(matrix[:, free], target - matrix[:, ~free] @ step[~free])
        kept = np.clip(step, *room)
        free &= kept == step
        if np.array_equal(kept, step):
            break
        step = kept
    return step


def _least_squares(matrix: Array, target: Array) -> Array:
    """Least squares that leaves directions alone about which the data say nothing."""
    size = np.sqrt((matrix**2).sum(axis=0))
    known = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    solution = np.zeros(matrix.shape[1])
    scaled = matrix[:, known] / size[known]
    solution[known] = np.linalg.lstsq(scaled, target, rcond=1e-8)[0] / size[known]
    return solution


def advantage(better: Judgement, worse: Judgement, block: float = BLOCK) -> tuple[float, float]:
    """How much lower the mean squared error over range is, and the standard error of that.

    Paired over blocks of so many seconds of the same recordings; infinite for a single block.
    """
    difference = worse.squares(block) - better.squares(block)
    n = difference.size
    return float(difference.mean()), float(difference.std(ddof=1) / np.sqrt(n)) if n > 1 else np.inf


def falls_clearly(after: Judgement, before: Judgement) -> bool:
    """Whether the judged error falls by enough to be worth it, and by more than chance."""
    mean, error = advantage(after, before)
    return after.nrmse < (1 - LEAST_GAIN) * before.nrmse and mean > EARNED * error


def delta_bic(richer: Fit, poorer: Fit, recordings: Sequence[Recording]) -> float:
    """Change of the Bayesian information criterion from the poorer to the richer model.

    n ln(loss) + p ln(n) with n the effective number of samples of the richer model's residuals, as
    samples 10 ms apart are far from independent. Negative speaks for the richer model.
    """
    n = effective_samples(
        {r.name: influence(richer.loss, richer.residuals[r.name] / torque_range(r)) for r in recordings}
    )
    gain = np.log(_loss(richer, recordings) / _loss(poorer, recordings))
    return float(n * gain + (len(richer.labels) - len(poorer.labels)) * np.log(n))


def _loss(fitted: Fit, recordings: Sequence[Recording]) -> float:
    return sum(cost(fitted.loss, fitted.residuals[r.name] / torque_range(r)) for r in recordings)
