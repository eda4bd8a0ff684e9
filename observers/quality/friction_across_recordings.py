"""Friction of a ground from several recordings, and what a further recording on it will have.

A two-level model. Recordings on one ground scatter by more than each one's own deviation says: another
spot, another temperature, a wheel put down anew. Their own errors are in part common to them all, as of
a load or a half-length, which no number of recordings shows. So the own deviation is not taken off the
scatter, and comes on top of it undivided.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import stdtrit

from observers.quality.agreement_with_final_estimate import BAND_95
from symbolic import InvalidInputError

MIN_RECORDINGS = 3
"""Recordings that a band for a further one takes: of two, the scatter is hardly known."""


@dataclass(frozen=True, kw_only=True)
class GroundFriction:
    """Effective friction on a ground.

    Attributes:
        recordings: how many it rests on.
        mu_eff: their mean [1].
        scatter: their standard deviation [1]; None of a single one.
        further: half-width of the interval about `mu_eff` that holds the friction of a further recording
            with a probability of 95 % [1]; None of fewer than `MIN_RECORDINGS`.
    """

    recordings: int
    mu_eff: float
    scatter: float | None = None
    further: float | None = None

    @property
    def scatter_share(self) -> float | None:
        """Share of the square of `further` that the scatter makes [1]; None where there is none."""
        if self.scatter is None or not self.further:
            return None
        return (_scatter_half_width(self.recordings, self.scatter) / self.further) ** 2

    def further_half_width(self, recordings: int) -> float:
        """What `further` would be of so many recordings that scatter as these do; nan if unknown [1]."""
        if self.scatter is None or self.further is None:
            return float("nan")
        own = self.further**2 - _scatter_half_width(self.recordings, self.scatter) ** 2
        return float(np.sqrt(_scatter_half_width(recordings, self.scatter) ** 2 + max(0.0, own)))

    def ratio_to(self, other: "GroundFriction", comparisons: int = 1) -> tuple[float, float]:
        """Ratio of the means and half of its 95 % band [1], of both more than one recording.

        What both share as a factor, such as an error of load, lengths or the torque's scale, cancels.
        By Welch's test of one mean against the other times the ratio; by chance one of so many
        comparisons is beyond its band in 5 of 100 cases at most.
        """
        ratio = self.mu_eff / other.mu_eff
        squares = [
            (scale * (one.scatter or 0.0)) ** 2 / one.recordings
            for one, scale in ((self, 1.0), (other, ratio))
        ]
        whole, counts = sum(squares), (self.recordings - 1, other.recordings - 1)
        if not whole:
            return ratio, 0.0
        freedom = whole**2 / sum(square**2 / n for square, n in zip(squares, counts, strict=True))
        half = stdtrit(freedom, 1 - 0.025 / comparisons) * np.sqrt(whole)
        return ratio, float(half / other.mu_eff)


def ground_friction(mu_eff: Sequence[float], mu_eff_std: Sequence[float]) -> GroundFriction:
    """Friction of a ground and the prediction interval for a further recording, by Student's t.

    The further recording is one as these: same tyre and rig, loads, ways of steering and weather among
    theirs.

    Args:
        mu_eff: of each recording [1], shape (n,).
        mu_eff_std: standard deviation of each [1], shape (n,).

    Raises:
        InvalidInputError: there is no recording, or a value is not finite.
    """
    values, own = np.asarray(mu_eff, dtype=float), np.asarray(mu_eff_std, dtype=float)
    if values.shape != own.shape or not values.size or not np.isfinite([values, own]).all():
        raise InvalidInputError(
            "friction of a ground takes finite mu_eff and mu_eff_std of each recording"
        )
    n, mean = values.size, float(values.mean())
    if n == 1:
        return GroundFriction(recordings=n, mu_eff=mean)
    scatter, further = float(values.std(ddof=1)), None
    if n >= MIN_RECORDINGS:
        further = float(np.hypot(_scatter_half_width(n, scatter), BAND_95 * np.sqrt(np.mean(own**2))))
    return GroundFriction(recordings=n, mu_eff=mean, scatter=scatter, further=further)


def _scatter_half_width(n: int, scatter: float) -> float:
    """Half-width of the 95 % interval for one more of n values with a standard deviation [1]."""
    return float(stdtrit(n - 1, 0.975) * scatter * np.sqrt(1 + 1 / n))


def kendall_load_test(load_and_friction: Sequence[Sequence[tuple[float, float]]]) -> tuple[float, bool]:
    """How likely chance orders friction by load so clearly, and whether friction falls with the load.

    Kendall's test (Biometrika 30 (1938) 81), its pairs within grounds alone: by chance every order of
    the recordings of a ground is as likely, which gives the exact distribution of its inversions. Load
    [N] and friction [1] are those of each recording, ground by ground.
    """
    chances, falls, pairs = np.ones(1), 0.0, 0
    for own in load_and_friction:
        for one, other in combinations(own, 2):
            # A pair of one load or one friction counts for either way.
            falls += (1 - np.sign((one[0] - other[0]) * (one[1] - other[1]))) / 2
        pairs += len(own) * (len(own) - 1) // 2
        for place in range(2, len(own) + 1):
            chances = np.convolve(chances, np.full(place, 1 / place))
    tail = float(chances[: int(np.ceil(min(falls, pairs - falls))) + 1].sum())
    return min(1.0, 2 * tail), bool(2 * falls > pairs)
