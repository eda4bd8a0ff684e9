"""Covariance of a fit's parameters where its residuals are not white noise.

The covariance is the sandwich H^-1 S H^-1 with H the curvature of the loss and S the variance of the sum
of the scores J' psi(r). It holds for residuals of uneven size, within a recording and between them, and
for a model that is wrong (Huber 1967; White 1980). Scores of neighbouring samples are correlated. A
kernel over the lags (Newey and West 1987) makes S too small where few samples are independent, so the
influences psi of every recording are prewhitened by an autoregression of their own, as Andrews and
Monahan (1992) and den Haan and Levin (1997) do. With psi = u/A, the sum of J' psi is that of K' u, where
K is J filtered by 1/A backward in time; the scores K' u are nearly uncorrelated.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtbtrs

from identification.fits.autocorrelation import autoregression, predict_gaps, slow_part_effective_samples
from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import shares_of_torque_range
from identification.fits.loss import curvature, influence
from identification.reading.recordings import Recording
from symbolic.float_array_type import Array

_UNKNOWN = 1e-12
"""Below this share of the greatest information, the data do not determine a direction [1]."""
_PART = 1e-3
"""A parameter belongs to such a direction from this component of the unit vector on [1]."""


def standard_deviations(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Standard deviation of every free coordinate, in the order of `fitted.labels`, shape (p,)."""
    return np.sqrt(np.diag(covariance(fitted, recordings)))


def parameter_correlation(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Correlations of the free coordinates, shape (p, p); NaN where the data do not determine one."""
    covariances = covariance(fitted, recordings)
    variances = np.diag(covariances)
    size = np.sqrt(np.where(np.isfinite(variances), variances, np.nan))
    return np.asarray(covariances / np.outer(size, size))


def covariance(fitted: Fit, recordings: Sequence[Recording]) -> Array:
    """Covariance of the free coordinates, in the order of `fitted.labels`, shape (p, p).

    A coordinate that the data do not determine has infinite variance, and NaN with the others.
    """
    residuals = list(shares_of_torque_range(fitted.residuals, recordings).values())
    present = np.concatenate([np.isfinite(residual) for residual in residuals])
    curved = curvature(fitted.loss, np.concatenate(residuals)[present])
    prior = fitted.prior_weights**2
    data = fitted.jacobian.T @ (curved[:, None] * fitted.jacobian)
    inverse, known = _inverse(data + np.diag(prior))
    covariances = np.full((known.size, known.size), np.nan)
    np.fill_diagonal(covariances, np.inf)
    if not known.any():
        return covariances
    jacobian = fitted.jacobian[:, known]
    # Leverages of the samples add up to the number of parameters.
    leverage = curved * np.einsum("ti,ij,tj->t", jacobian, inverse, jacobian)
    variance, at = np.zeros_like(inverse), 0
    for residual in residuals:
        rows = slice(at, at + int(np.isfinite(residual).sum()))
        influenced = influence(fitted.loss, residual)
        variance += scores_variance(jacobian[rows], influenced, float(leverage[rows].sum()))
        at = rows.stop
    # The score of a declared value: its weight times a residual of that standard deviation.
    variance += np.diag(prior[known] ** 2)
    covariances[np.ix_(known, known)] = inverse @ variance @ inverse
    return covariances * np.outer(fitted.scales, fitted.scales)


def _inverse(information: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Inverse over the parameters that the data determine, and a mask of these."""
    size = np.sqrt(np.maximum(np.diag(information), 0))
    known = size > 1e-9 * size.max(initial=0.0)
    scaled = information[np.ix_(known, known)] / np.outer(size[known], size[known])
    shares, axes = np.linalg.eigh(scaled)
    blind = axes[:, shares < _UNKNOWN * shares.max(initial=0.0)]
    clear = ~(np.abs(blind) > _PART).any(axis=1)
    inverse = np.linalg.pinv(scaled, rcond=_UNKNOWN, hermitian=True)[np.ix_(clear, clear)]
    known[known] = clear
    return inverse / np.outer(size[known], size[known]), known


def scores_variance(jacobian: Array, influenced: Array, total_leverage: float) -> Array:
    """Variance of the sum of one recording's scores, shape (p, p).

    `influenced` is psi, NaN where missing, shape (n,); the Jacobian has rows of the others alone. The
    sum of leverages is the number of parameters that the recording determines; fitting takes as many
    independent samples out of the residuals.
    """
    weights = autoregression(influenced)
    filled = predict_gaps(influenced, weights)
    # The filter A and, backwards, the one over A; `scipy.signal` takes half a second to load.
    innovations = np.convolve(filled, weights)[: filled.size]
    bands = np.repeat(weights[:, None], filled.size, axis=1)
    rows = np.zeros((filled.size, jacobian.shape[1]))
    rows[np.isfinite(influenced)] = jacobian
    scores = dtbtrs(bands, rows[::-1], uplo="L")[0][::-1] * innovations[:, None]
    independent = slow_part_effective_samples(influenced, innovations, weights)
    # The correction n / (n - p) for small samples, with n - p at least 1.
    share = independent / max(independent - total_leverage, 1.0)
    return np.asarray(share * (scores.T @ scores))
