"""How the friction that an observer found over a recording agrees with its own final estimate.

The recording's own final estimate is the reference: how soon the estimate stays near it, how far it
still moves, and whether the bands on the way held it. That they did is necessary, not evidence of
accuracy: the filter is compared with itself. Another reference may be given beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from observers.estimates import Estimates
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

NEAR_FINAL = 0.1
"""Share of the final estimate within which an estimate has settled [1]."""
BAND_95 = 1.96
"""Standard deviations to either side of an estimate that hold 95 % of a normal distribution [1]."""
LATE_SHARE = 0.5
"""The drift is that over the last part of a recording, this share of its duration [1]."""


@dataclass(frozen=True, kw_only=True)
class SelfConsistency:
    """Effective friction at the end of a recording, and how the estimate came there.

    Attributes:
        mu_eff: effective friction at the last sample [1].
        mu_eff_std: its standard deviation [1].
        settling: time from the first sample after which mu_eff stays within `NEAR_FINAL` of its final
            value [s].
        drift: greatest minus least mu_eff over the second half of the recording, as a share of the final
            one [1].
        coverage: share of the informed samples whose 95 % band holds the final mu_eff [1]; None where no
            sample is informed.
        reference_coverage: share of the informed samples whose 95 % band holds a reference from
            elsewhere [1]; None without one.
        relative_band: median over the informed samples of mu_eff_std over mu_eff [1]; None likewise.
    """

    mu_eff: float
    mu_eff_std: float
    settling: float
    drift: float
    coverage: float | None
    relative_band: float | None
    reference_coverage: float | None = None


def self_consistency(estimates: Estimates, reference: float | None = None) -> SelfConsistency:
    """How estimates over one recording agree with the last of them; they need a standard deviation.

    Args:
        estimates: of an observer, over a recording.
        reference: the recording's mu_eff [1] from elsewhere, such as a fit to the whole recording.

    Raises:
        InvalidInputError: the last estimate has no standard deviation, as that of a root solver.
    """
    mu_eff, std, t = estimates.mu_eff, estimates.mu_eff_std, estimates.t
    final = float(mu_eff[-1])
    if not np.isfinite(std[-1]):
        raise InvalidInputError(
            "the quality of an estimate needs its standard deviation; use Ekf or Mhe, the root solver"
            " has none"
        )
    away = np.flatnonzero(~(np.abs(mu_eff - final) <= NEAR_FINAL * final))
    settled = 0 if away.size == 0 else int(away[-1]) + 1
    late = mu_eff[t >= t[-1] - LATE_SHARE * (t[-1] - t[0])]
    known = estimates.informed.astype(bool)
    coverage = relative_band = reference_coverage = None
    if known.any():
        coverage = _share_within_band(mu_eff[known], std[known], final)
        reference_coverage = (
            None if reference is None else _share_within_band(mu_eff[known], std[known], reference)
        )
        relative_band = float(np.median(std[known] / mu_eff[known]))
    return SelfConsistency(
        mu_eff=final,
        mu_eff_std=float(std[-1]),
        settling=float(t[settled] - t[0]),
        drift=float(np.ptp(late)) / final,
        coverage=coverage,
        relative_band=relative_band,
        reference_coverage=reference_coverage,
    )


def _share_within_band(mu_eff: Array, std: Array, reference: float) -> float:
    return float(np.mean(np.abs(mu_eff - reference) <= BAND_95 * std))


def friction_spread(consistencies: Sequence[SelfConsistency]) -> float | None:
    """Coefficient of variation of the final mu_eff of recordings on one ground [1]; None below two."""
    if len(consistencies) < 2:
        return None
    finals = np.array([one.mu_eff for one in consistencies])
    return float(finals.std(ddof=1) / finals.mean())
