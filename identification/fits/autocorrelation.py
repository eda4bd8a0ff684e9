"""How long a series remembers: its autocorrelation where samples may be missing."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def autocorrelation_time(residual: Array) -> float:
    """How many samples of a residual count as one: 1 + 2 sum of its autocorrelation, >= 1.

    The sum ends where the autocorrelation first falls below 0.05. Missing samples have no part in it, so
    of a residual that is seen half as often only half as many count as one. Lags at which hardly any two
    samples are there do not end it.
    """
    present, n = np.isfinite(residual), residual.size
    if np.unique(residual[present]).size < 2:
        return 1.0
    products = lagged_products(np.where(present, residual - residual[present].mean(), 0.0))
    # Of the present samples, those that have another one so much later.
    share = lagged_products(present.astype(float)) / present.sum() * n / np.arange(n, 0, -1)
    correlation = products / products[0]
    low = np.flatnonzero((correlation < 0.05 * share) & (share > 0.5 * present.mean()))
    end = int(low[0]) if low.size else n
    return float(max(1.0, 1 + 2 * correlation[1:end].sum()))


def effective_samples(residuals: Mapping[str, Array]) -> float:
    """Number of independent samples in the residuals of several recordings."""
    return sum(
        float(np.isfinite(residual).sum()) / autocorrelation_time(residual)
        for residual in residuals.values()
    )


def lagged_products(values: Array) -> Array:
    """Sum over t of values(t) values(t + lag), for lags from 0 to n - 1; shape (n,)."""
    n = values.size
    return np.asarray(np.fft.irfft(np.abs(np.fft.rfft(values, 2 * n)) ** 2, 2 * n)[:n])
