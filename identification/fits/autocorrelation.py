"""Serial correlation of a residual in which samples may be missing."""

from collections.abc import Mapping

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from symbolic.float_array_type import Array


def autocorrelation_time(residual: Array) -> float:
    """Integrated autocorrelation time in samples, 1 + 2 sum of the autocorrelation, at least 1.

    So many samples carry the information of one independent sample. The sum ends where the
    autocorrelation first falls below 0.05. Missing samples have no part in it, so that a residual with
    half of its samples has half the time. Lags at which few pairs of samples exist do not end the sum.
    """
    present, n = np.isfinite(residual), residual.size
    if not present.any() or not np.ptp(residual[present]) > 0:
        return 1.0
    products = lagged_products(np.where(present, residual - residual[present].mean(), 0.0))
    # Share of the present samples that have another one at the lag.
    share = np.ones(n)
    if not present.all():
        share = lagged_products(present.astype(float)) / present.sum() * n / np.arange(n, 0, -1)
    correlation = products / products[0]
    low = np.flatnonzero((correlation < 0.05 * share) & (share > 0.5 * present.mean()))
    end = int(low[0]) if low.size else n
    return float(max(1.0, 1 + 2 * correlation[1:end].sum()))


def effective_samples(residuals: Mapping[str, Array]) -> float:
    """Number of independent samples in the residuals of several recordings."""
    return sum(float(np.isfinite(r).sum()) / autocorrelation_time(r) for r in residuals.values())


def lagged_products(values: Array) -> Array:
    """Sum over t of values(t) values(t + lag), for lags from 0 to n - 1; shape (n,)."""
    n = values.size
    length = next_fast_len(2 * n, real=True)
    return np.asarray(irfft(np.abs(rfft(values, length)) ** 2, length)[:n])


def autoregression(series: Array) -> Array:
    """Weights A = (1, a_1, ..., a_m), such that the sum of a_j x(t - j) is white.

    Burg's recursion (1967) gives them, stable whatever the series. The order, up to the usual
    10 log10(n), has the least value of Akaike's criterion. A missing sample (NaN) breaks the series, and
    no term reaches across it.
    """
    weights, score = np.ones(1), 0.0
    best, least = weights, score
    ahead, behind = series[1:], series[:-1]
    for order in range(1, 1 + int(10 * np.log10(series.size))):
        both = np.isfinite(ahead * behind)
        size = float(np.sum(ahead[both] ** 2 + behind[both] ** 2))
        # Too few pairs without a gap between them determine no further weight.
        if both.sum() <= 10 * order or not size > 0:
            break
        reflection = -2 * float(ahead[both] @ behind[both]) / size
        longer = np.append(weights, 0.0)
        weights = longer + reflection * longer[::-1]
        ahead, behind = (ahead + reflection * behind)[1:], (behind + reflection * ahead)[:-1]
        score += int(both.sum()) * np.log(max(1 - reflection**2, 1e-12)) + 2
        if score < least:
            best, least = weights, score
    return best


def predict_gaps(series: Array, weights: Array) -> Array:
    """The series with the autoregression's prediction where a sample is missing."""
    filled = np.nan_to_num(series)
    for at in np.flatnonzero(~np.isfinite(series)):
        before = filled[max(0, at - weights.size + 1) : at][::-1]
        filled[at] = -weights[1 : before.size + 1] @ before
    return filled


def slow_part_effective_samples(influenced: Array, innovations: Array, weights: Array) -> float:
    """Number of independent samples that the slow part of a series is worth; it whitens to innovations.

    It is the variance of a sample over that of the mean, n gamma(0) / S(0), after the white part, the
    value of the spectrum S at its upper end, has been subtracted from both.
    """
    count = int(np.isfinite(influenced).sum())
    power, innovation = np.nansum(influenced**2), np.sum(innovations**2)
    slow = innovation / np.sum(weights) ** 2
    white = innovation / (weights[::2].sum() - weights[1::2].sum()) ** 2
    if not slow > power > white:
        return float(count)
    return float(count * (power - white) / (slow - white))
