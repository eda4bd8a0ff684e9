"""How sure the parameters of a fit are where its residuals are no white noise.

The covariance is the sandwich H^-1 S H^-1: H the curvature of the loss, S the variance of the sum of the
scores J' psi(r). It holds for residuals that are larger here than there, in one recording than in
another, and where the model is wrong (Huber 1967; White 1980). Scores of neighbouring samples belong
together. A kernel over the lags (Newey and West 1987) makes S too small where few samples are
independent, so the influences psi of every recording are whitened by an autoregression of their own
first, as Andrews and Monahan (1992) and den Haan and Levin (1997) do. With psi = u/A, the sum of J' psi
is that of K' u, where K is J filtered by 1/A backward in time; the scores K' u have hardly any
correlation left.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.fits.fitting import Fit, torque_range
from identification.fits.loss import curvature, influence
from identification.reading.recordings import Recording

Array = NDArray[np.float64]
_UNKNOWN = 1e-12
"""A direction with this share of the greatest information is one that the data say nothing about."""
_PART = 1e-3
"""A parameter takes part in such a direction from this component of the unit vector on."""


def deviations(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Standard deviation of every free coordinate, in the order of `fitted.labels`.

    Args:
        fitted: the fit.
        recordings: those that were fitted, in the same order.

    Returns:
        Shape (p,), in the parameters' coordinates; infinity where the data say nothing.
    """
    return np.sqrt(np.diag(covariance(fitted, recordings)))


def correlation(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Correlations of the free coordinates, shape (p, p); NaN where the data say nothing."""
    spread = covariance(fitted, recordings)
    size = np.sqrt(np.where(np.isfinite(np.diag(spread)), np.diag(spread), np.nan))
    correlated: Array = spread / np.outer(size, size)
    return correlated


def covariance(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Covariance of the free coordinates, in the order of `fitted.labels`, shape (p, p).

    A coordinate of which the data say nothing has infinite variance, and NaN with the others.
    """
    residuals = [fitted.residuals[r.name] / torque_range(r) for r in recordings]
    present = np.concatenate([np.isfinite(residual) for residual in residuals])
    curved = curvature(fitted.loss, np.concatenate(residuals)[present])
    inverse, known = _inverse(fitted.jacobian.T @ (curved[:, None] * fitted.jacobian))
    spread = np.full((known.size, known.size), np.nan)
    np.fill_diagonal(spread, np.inf)
    if not known.any():
        return spread
    jacobian = fitted.jacobian[:, known]
    # What share of a parameter each sample decides; these add up to the number of parameters.
    leverage = curved * np.einsum("ti,ij,tj->t", jacobian, inverse, jacobian)
    meat, at = np.zeros_like(inverse), 0
    for residual in residuals:
        rows = slice(at, at + int(np.isfinite(residual).sum()))
        influenced = influence(fitted.loss, residual)
        meat += scores_variance(jacobian[rows], influenced, float(leverage[rows].sum()))
        at = rows.stop
    spread[np.ix_(known, known)] = inverse @ meat @ inverse
    return spread * np.outer(fitted.scales, fitted.scales)


def _inverse(information: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Inverse over the parameters of which the data say something, and which those are."""
    size = np.sqrt(np.maximum(np.diag(information), 0))
    known = size > 1e-9 * size.max(initial=0.0)
    scaled = information[np.ix_(known, known)] / np.outer(size[known], size[known])
    shares, axes = np.linalg.eigh(scaled)
    blind = axes[:, shares < _UNKNOWN * shares.max(initial=0.0)]
    clear = ~(np.abs(blind) > _PART).any(axis=1)
    inverse = np.linalg.pinv(scaled, rcond=_UNKNOWN, hermitian=True)[np.ix_(clear, clear)]
    known[known] = clear
    return inverse / np.outer(size[known], size[known]), known


def scores_variance(jacobian: Array, influenced: Array, decided: float) -> Array:
    """Variance of the sum of one recording's scores, shape (p, p).

    Args:
        jacobian: rows of the samples that are present, shape (m, p).
        influenced: psi of every sample, NaN where missing, shape (n,).
        decided: how many parameters the recording decides. Fitting them has taken as many independent
            samples' worth out of the residuals.
    """
    weights = autoregression(influenced)
    filled = _filled(influenced, weights)
    innovations = lfilter(weights, 1.0, filled)
    rows = np.zeros((filled.size, jacobian.shape[1]))
    rows[np.isfinite(influenced)] = jacobian
    scores = lfilter([1.0], weights, rows[::-1], axis=0)[::-1] * innovations[:, None]
    independent = _independent(influenced, innovations, weights)
    # Small samples: as n / (n - p), with at least one sample left.
    share = independent / max(independent - decided, 1.0)
    variance: Array = share * (scores.T @ scores)
    return variance


def _independent(influenced: Array, innovations: Array, weights: Array) -> float:
    """How many independent samples the slow part of a series is worth.

    The variance over that of the mean, n gamma(0) / S(0), once what the spectrum S has at its upper end,
    the white part, is taken from both.
    """
    count = int(np.isfinite(influenced).sum())
    power, left = np.nansum(influenced**2), np.sum(innovations**2)
    slow = left / np.sum(weights) ** 2
    white = left / (weights[::2].sum() - weights[1::2].sum()) ** 2
    if not slow > power > white:
        return float(count)
    return float(count * (power - white) / (slow - white))


def _filled(series: Array, weights: Array) -> Array:
    """The series with what the autoregression expects where a sample is missing."""
    filled = np.nan_to_num(series)
    for at in np.flatnonzero(~np.isfinite(series)):
        before = filled[max(0, at - weights.size + 1) : at][::-1]
        filled[at] = -weights[1 : before.size + 1] @ before
    return filled


def autoregression(series: Array) -> Array:
    """Weights A = (1, a_1, ..., a_m), such that the sum of a_j x(t - j) is white.

    By Burg's recursion (1967), stable whatever the series; the order has the least of Akaike's criterion
    up to the usual 10 log10(n). A missing sample (NaN) breaks the series, and no term reaches across it.
    """
    weights, score = np.ones(1), 0.0
    best, least = weights, score
    ahead, behind = series[1:], series[:-1]
    for order in range(1, 1 + int(10 * np.log10(series.size))):
        both = np.isfinite(ahead * behind)
        size = float(np.sum(ahead[both] ** 2 + behind[both] ** 2))
        # Too few stretches without a gap are left to say anything.
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
