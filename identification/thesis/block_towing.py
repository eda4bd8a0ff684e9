"""The friction of a plate by towing a loaded block over it: [Györök 2022], (5.1) and section 5.2.1.

The samples of a tow share the place on the plate, the zero of the sensor and the state of the rubber, so
they are one observation of F = mu N. Every tow counts by its means, and the deviation comes from the
scatter between tows. [Györök 2022] takes F = sqrt(F_x^2 + F_y^2) sample by sample, which turns noise
into force; here the components are averaged first.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from identification.fits.values_by_ground_and_recording import ParameterEstimate
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

MIN_TOWS = 4
"""Two parameters, and two more tows for their deviation."""
MIN_LOAD_VARIATION = 0.05
"""Standard deviation of the loads over their mean below which the offset is not determined [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tow:
    """One pull at one load, the samples while the block slides; arrays of shape (n,).

    Attributes:
        F_x: force along the plate [N].
        F_y: force along the plate, across F_x [N].
        F_z: normal force, positive where the block presses [N].
    """

    F_x: Array
    F_y: Array
    F_z: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class TowedFriction:
    """Friction from tows; deviations follow Student's t.

    Attributes:
        mu: coefficient of friction of F = mu N.
        mu_with_offset: coefficient of friction of F = mu N + F_0.
        offset: F_0, caused by adhesion or a zero error of the sensor [N].
        proportional: True where the offset is within its 95 % interval of zero, so that F = mu N holds.
        N: normal force of every tow, shape (tows,) [N].
        F: friction force of every tow, shape (tows,) [N].
    """

    mu: ParameterEstimate
    mu_with_offset: ParameterEstimate
    offset: ParameterEstimate
    proportional: bool
    N: Array
    F: Array

    def interval(self, probability: float = 0.95) -> tuple[float, float]:
        """Confidence interval of mu of F = mu N for a probability [1]."""
        half = _quantile(probability, len(self.N) - 1) * (self.mu.std or 0.0)
        return self.mu.value - half, self.mu.value + half


def friction_by_towing(tows: Sequence[Tow]) -> TowedFriction:
    """Fit F = mu N, with and without an offset, by least squares over tows at several loads.

    The scatter of F grows with the load, or is constant where the sensor's zero causes it. A variance
    proportional to the load is between the two; with it mu is the sum of F over the sum of N. The
    deviations hold in either case (HC3, MacKinnon and White 1985).

    Raises:
        InvalidInputError: too few tows or loads, or a tow is unusable.
    """
    if len(tows) < MIN_TOWS:
        raise InvalidInputError(f"towing needs at least {MIN_TOWS} tows, got {len(tows)}")
    N, F = np.array([_mean_forces(tow, place) for place, tow in enumerate(tows, start=1)]).T
    if np.std(N) < MIN_LOAD_VARIATION * np.mean(N):
        raise InvalidInputError(
            f"the tows' loads must differ, got {np.min(N):.4g} N to {np.max(N):.4g} N"
        )
    root = np.sqrt(N)
    ((mu, mu_std),) = _fit(root[:, None], F / root)
    (slope, slope_std), (offset, offset_std) = _fit(np.column_stack([root, 1 / root]), F / root)
    return TowedFriction(
        mu=ParameterEstimate(value=mu, std=mu_std, unit="1"),
        mu_with_offset=ParameterEstimate(value=slope, std=slope_std, unit="1"),
        offset=ParameterEstimate(value=offset, std=offset_std, unit="N"),
        proportional=abs(offset) <= _quantile(0.95, len(N) - 2) * offset_std,
        N=N,
        F=F,
    )


def _mean_forces(tow: Tow, place: int) -> tuple[float, float]:
    """Normal force and friction force of a tow [N]."""
    channels = [np.asarray(channel, dtype=np.float64) for channel in (tow.F_x, tow.F_y, tow.F_z)]
    if len({channel.shape for channel in channels}) > 1 or channels[0].ndim != 1 or not channels[0].size:
        raise InvalidInputError(f"tow {place}: F_x, F_y and F_z must have the same shape (n,)")
    if not all(np.isfinite(channel).all() for channel in channels):
        raise InvalidInputError(f"tow {place}: forces must be finite numbers")
    F_x, F_y, N = (float(channel.mean()) for channel in channels)
    if not N > 0:
        raise InvalidInputError(f"tow {place}: F_z must be positive on average, got {N:.4g} N")
    return N, float(np.hypot(F_x, F_y))


def _fit(columns: Array, values: Array) -> list[tuple[float, float]]:
    """Least squares: every coefficient with its standard deviation."""
    inverse = np.linalg.inv(columns.T @ columns)
    solution = inverse @ columns.T @ values
    leverage = np.einsum("ij,jk,ik->i", columns, inverse, columns)
    jackknifed = (values - columns @ solution) / (1 - leverage)
    influence = inverse @ columns.T * jackknifed
    stds = np.sqrt(np.sum(influence**2, axis=1))
    return list(zip(solution.tolist(), stds.tolist(), strict=True))


def _quantile(probability: float, degrees_of_freedom: int) -> float:
    if not 0 < probability < 1:
        raise InvalidInputError(f"probability must lie between 0 and 1, got {probability:g}")
    return float(stdtrit(degrees_of_freedom, 0.5 + 0.5 * probability))
