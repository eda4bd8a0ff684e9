"""The angle between two steps of an encoder: its likelihood, and the steps themselves.

An encoder of step D shows the angle's cell, not the angle: its error is a function of the angle, it is
neither white nor independent from sample to sample, and below one step it is all there is. So a reading
counts as what it says, y - D/2 <= psi + noise <= y + D/2, with the noise from a logistic distribution of
scale s:

    P = F((y + D/2 - psi)/s) - F((y - D/2 - psi)/s),     F(u) = 1/(1 + exp(-u)).

-log P is convex in psi, grows linearly outside of the cell, so that no outlier dominates, becomes the
cell's hard limits for s -> 0 and an ordinary density for D -> 0.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

Array = NDArray[np.float64]

_WHOLE = 0.05
"""How far from a whole number of steps two readings may be apart, in steps."""
_LEVELS, _SELDOM = 4, 200
"""So many levels tell the step, each met by more than one reading in so many."""
_NO_STEP = 1e-6
"""A channel without steps has cells as wide as this share of its range [1]."""


class Misfit(NamedTuple):
    """-log P of readings, and its first and second derivatives by the angle, shape (n,)."""

    cost: Array
    slope: Array
    curvature: Array


def encoder_step(psi: Array) -> float:
    """Step by which readings differ [rad]; for a channel without steps a very small one.

    Args:
        psi: readings [rad], shape (n,), not all equal.
    """
    least = _NO_STEP * float(np.ptp(psi))
    _, places, visits = np.unique(np.round(psi / least), return_index=True, return_counts=True)
    levels = psi[places]
    # A wrong reading stands alone; where the wheel turns back or comes to rest, levels are met often.
    often = visits > psi.size // _SELDOM
    if np.count_nonzero(often) >= _LEVELS:
        levels = levels[often]
    span = float(levels[-1] - levels[0])
    gaps = np.diff(levels)
    counts = gaps / gaps.min()
    # Rounding in the file moves every gap a little; all of the range together tells the step best.
    step = span / float(np.round(counts).sum())
    if np.abs(gaps / step - np.round(gaps / step)).max() > _WHOLE:
        return least
    return max(step, least)


def misfit(read: Array, angle: Array, step: float, scale: float) -> Misfit:
    """How ill an angle suits the readings.

    Args:
        read: readings [rad], shape (n,).
        angle: the angle [rad], shape (n,).
        step: of the encoder, D [rad].
        scale: of the logistic noise, s [rad].
    """
    upper, lower = (read + step / 2 - angle) / scale, (read - step / 2 - angle) / scale
    # F(u) - F(l) = F(u) F(-l) (1 - exp(l - u)), in which nothing cancels.
    width = np.log(-np.expm1(-step / scale))
    cost = np.logaddexp(0, -upper) + np.logaddexp(0, lower) - width
    above, below = expit(-upper), expit(lower)
    curvature = above * (1 - above) + below * (1 - below)
    return Misfit(cost, (above - below) / scale, curvature / scale**2)
