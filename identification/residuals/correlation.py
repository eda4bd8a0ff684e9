"""Correlation of residuals with signals, and how much of it chance explains.

An independent residual and signal correlate by chance, the more so the more slowly both vary. To first
order the sample correlation of two independent series of n samples has the variance

    1/n sum_k rho_x(k) rho_y(k),

k over all lags of both signs (Bartlett 1935; Box, Jenkins and Reinsel, Time Series Analysis, 3rd ed.
(1994), section 11.1.3). With sample autocorrelations over all lags the sum is that of a product of two
periodograms: it cannot be negative and needs no window. Only at frequency zero the periodogram of
residuals less their mean is empty; there the mean of its neighbours stands in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtri

from identification.fits.autocorrelation import lagged_products
from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import torque_range
from identification.reading.recordings import Recording
from symbolic.float_array_type import Array

CONFIDENCE = 0.99
"""Share of independent residuals whose correlation stays within its band [1]."""
NEIGHBOURS = 3
"""Frequencies of each recording that stand in for frequency zero."""
MIN_REMAINING_SHARE = 1e-3
"""A signal of which the projection leaves less than this share is not tested [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StackedResiduals:
    """The residuals of all recordings in one column, zero where missing."""

    residual: Array  # Simulated minus measured torque over range [1], shape (n,).
    present: NDArray[np.bool_]  # Whether the torque was measured, shape (n,).
    places: Mapping[str, slice]  # Name and rows of each recording.
    torque_ranges: tuple[float, ...]  # Torque range of each recording [N m].
    steps: tuple[float, ...]  # Time between samples of each recording [s].

    @property
    def rms(self) -> float:
        """Root mean square of the residual over the samples that are present [1]."""
        return float(np.sqrt(np.sum(self.residual**2) / self.present.sum()))

    def signal_columns(self, signals: Sequence[Array]) -> Array:
        """A column for each recording: its signal over its torque range, zero elsewhere."""
        columns = np.zeros((self.residual.size, len(self.places)))
        for i, (place, span) in enumerate(zip(self.places.values(), self.torque_ranges, strict=True)):
            columns[place, i] = np.where(self.present[place], signals[i] / span, 0.0)
        return columns

    def indicator_columns(self) -> Array:
        """A column of ones for each recording."""
        return self.signal_columns([np.ones(place.stop - place.start) for place in self.places.values()])

    def sensitivities(self, fits: Sequence[Fit]) -> Array:
        """The columns of these fits' Jacobians."""
        blocks = [np.zeros((self.residual.size, 0))]
        for fitted in fits:
            block, at = np.zeros((self.residual.size, fitted.jacobian.shape[1])), 0
            for name, residual in fitted.residuals.items():
                known = np.isfinite(residual)
                end = at + int(known.sum())
                if name in self.places:
                    block[self.places[name]][known] = fitted.jacobian[at:end]
                at = end
            blocks.append(block)
        return np.hstack(blocks)


def stack_residuals(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> StackedResiduals:
    """The residuals of these recordings in one column."""
    ends = np.cumsum([0, *(r.t.size for r in recordings)]).tolist()
    torque_ranges = tuple(torque_range(r) for r in recordings)
    over = [residuals[r.name] / span for r, span in zip(recordings, torque_ranges, strict=True)]
    stacked = np.concatenate(over)
    return StackedResiduals(
        residual=np.nan_to_num(stacked),
        present=np.isfinite(stacked),
        places={r.name: slice(*ends[i : i + 2]) for i, r in enumerate(recordings)},
        torque_ranges=torque_ranges,
        steps=tuple(float(np.median(np.diff(r.t))) for r in recordings),
    )


def orthonormal_basis(columns: Array) -> Array:
    """Orthonormal columns that span these."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    if not scaled.size:
        return np.zeros((columns.shape[0], 0))
    directions, strength, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(directions[:, strength > 1e-8 * strength[0]])


def orthogonal_part(columns: Array, orthonormal: Array) -> Array:
    """The columns less their projection on the span of orthonormal columns."""
    return np.asarray(columns - orthonormal @ (orthonormal.T @ columns))


def additional_basis(columns: Array, existing: Array) -> Array:
    """Orthonormal directions of these columns beyond those; none of columns that lie in their span."""
    remaining = orthogonal_part(columns, existing)
    new = np.linalg.norm(remaining, axis=0) > MIN_REMAINING_SHARE * np.linalg.norm(columns, axis=0)
    return orthonormal_basis(remaining[:, new])


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualNoise:
    """A process with the autocorrelation of the residuals."""

    rows: StackedResiduals  # Where its recordings are.
    lags: Array  # One for each sample of the longest recording [s].
    correlation: Array  # Pooled over recordings, tapered by the share of sample pairs at each lag [1].
    energies: Array  # Sum of squares of each recording [1].
    counts: Array  # Samples of each recording.

    @property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom of the estimate at frequency zero."""
        return 2 * NEIGHBOURS * self.counts.size

    def covariance_times(self, columns: Array) -> Array:
        """Covariance matrix of the noise times these columns."""
        product = np.zeros_like(columns)
        for i, (place, step) in enumerate(zip(self.rows.places.values(), self.rows.steps, strict=True)):
            n = place.stop - place.start
            half = np.interp(step * np.arange(n), self.lags, self.correlation, right=0.0)
            # A circle of 2 n samples, on which the covariance matrix is circulant.
            spectrum = np.fft.rfft(np.concatenate([half, [0.0], half[:0:-1]]))[:, None]
            level = self.energies[i] / self.counts[i]
            turned = np.fft.rfft(columns[place], 2 * n, axis=0) * spectrum
            product[place] = level * np.fft.irfft(turned, 2 * n, axis=0)[:n]
        return np.where(self.rows.present[:, None], product, 0.0)


def residual_noise(rows: StackedResiduals) -> ResidualNoise:
    """The process of which these residuals, less their means, may be a sample."""
    centred = orthogonal_part(rows.residual, orthonormal_basis(rows.indicator_columns()))
    longest = max(
        step * (p.stop - p.start) for p, step in zip(rows.places.values(), rows.steps, strict=True)
    )
    lags = np.arange(0.0, longest, min(rows.steps))
    total, energies, counts = np.zeros(lags.size), [], []
    for place, step in zip(rows.places.values(), rows.steps, strict=True):
        n = place.stop - place.start
        # A product counts as if none of the pairs of samples of its lag were missing.
        pairs = np.round(lagged_products(rows.present[place].astype(np.float64)))
        # Variance of the mean, from the lowest frequencies above zero.
        power = np.abs(np.fft.rfft(centred[place])[1 : NEIGHBOURS + 1]) ** 2
        mean = float(np.mean(power) / pairs[0] ** 2)
        products = (lagged_products(centred[place]) / np.maximum(pairs, 1) + mean) * (n - np.arange(n))
        total += np.interp(lags, step * np.arange(n), products * pairs[0] / n, right=0.0)
        energies.append(float(np.sum(centred[place] ** 2) + mean * pairs[0]))
        counts.append(int(pairs[0]))
    return ResidualNoise(
        rows=rows,
        lags=lags,
        correlation=total / max(float(total[0]), 1e-300),
        energies=np.array(energies),
        counts=np.array(counts),
    )


def partial_correlation(
    columns: Array, absorbed: Array, noise: ResidualNoise, degrees_of_freedom: float = 1e9
) -> tuple[float, float, Array]:
    """Partial correlation of the residual with a signal, one column for each strength it may have.

    Both are projected off the orthonormal directions in `absorbed`. For one column the correlation has a
    sign; for several it is the multiple correlation. By chance its square is a sum of squares of normal
    numbers, to which the gamma distribution of the same mean and variance is fitted (Satterthwaite
    1946); with one column that is exact.

    The variance by chance has `noise.degrees_of_freedom` where the columns are not centred, so that it
    rests on the lowest frequencies. Returned are the correlation, the half-width of its band, and the
    slope of each column.
    """
    remaining, residual = (orthogonal_part(c, absorbed) for c in (columns, noise.rows.residual))
    length = float(np.linalg.norm(residual))
    if not length > 0 or np.linalg.norm(remaining) <= MIN_REMAINING_SHARE * np.linalg.norm(columns):
        return 0.0, 1.0, np.zeros(columns.shape[1])
    directions, strength, axes = np.linalg.svd(remaining, full_matrices=False)
    used = strength > MIN_REMAINING_SHARE * strength[0]
    directions, axes = directions[:, used], axes[used] / strength[used, None]
    projection = directions.T @ residual
    by_chance = directions.T @ noise.covariance_times(directions)
    mean, spread = float(np.trace(by_chance)), float(np.sum(by_chance * by_chance.T))
    # mean is above 0: the residual is not zero, and its covariance is that of a moving average.
    quantile = fdtri(mean**2 / spread, degrees_of_freedom, CONFIDENCE)
    band = float(np.sqrt(mean * quantile)) / length
    slopes = axes.T @ projection
    sign = np.sign(slopes[0]) if slopes.size == 1 else 1.0
    return float(sign * np.linalg.norm(projection) / length), min(band, 1.0), slopes
