"""The yaw rate from a quantised yaw angle."""

import numpy as np
from numpy.typing import NDArray

from symbolic.array_alias import Array

SMOOTHING_TIME = 0.11
"""Length of the smoothing window [s]: long against the encoder's steps, short against a turn."""

_MIN_SAMPLES = 5
_FAR_WEIGHT = 1e-6
_BLOCK = 1 << 16


def smoothed_rate(t: Array, psi: Array) -> Array:
    """Slope at every sample of the parabola fitted to its neighbours, by least squares.

    The filter of Savitzky and Golay (1964), in the samples' own times, so that sampling need not be
    uniform. The first and the last samples share the first and the last full window. Not causal.

    Args:
        t: increasing times [s], shape (n,), n >= 3.
        psi: angles [rad], shape (n,), without NaN.

    Returns:
        d psi/dt [rad/s], shape (n,).
    """
    per_window = 2 * int(SMOOTHING_TIME / (2 * float(np.median(np.diff(t))))) + 1
    width = min(max(per_window, _MIN_SAMPLES), t.size)
    first = np.clip(np.arange(t.size) - width // 2, 0, t.size - width)
    rows = max(1, _BLOCK // width)
    blocks = [
        _slopes(t, psi, np.arange(start, min(start + rows, t.size)), first, width)
        for start in range(0, t.size, rows)
    ]
    return np.concatenate(blocks)


def _slopes(t: Array, psi: Array, at: NDArray[np.intp], first: NDArray[np.intp], width: int) -> Array:
    near = first[at, None] + np.arange(width)
    distance = t[near] - t[at, None]
    reach = np.abs(distance).max(axis=1, keepdims=True)
    u = distance / reach
    # Beyond a pause of the clock samples only keep the fit determined, they do not shape it.
    weights = np.where(np.abs(distance) <= 1.01 * SMOOTHING_TIME, 1.0, _FAR_WEIGHT)
    weighted = np.stack([weights * u**power for power in range(3)])
    normal = np.stack([(weighted * u**power).sum(axis=2) for power in range(3)])
    right = (weighted * (psi[near] - psi[at, None])).sum(axis=2)
    fits = np.linalg.solve(normal.transpose(2, 0, 1), right.T[..., None])
    slopes: Array = fits[:, 1, 0] / reach[:, 0]
    return slopes
