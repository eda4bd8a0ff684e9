"""The yaw rate of an angle, from the past alone."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MEMORY = 0.06
"""Time over which the past fades [s]."""


def causal_rate(t: Array, psi: Array, memory: float = MEMORY) -> Array:
    """Backward differences of the angle through a first-order low-pass filter.

    Args:
        t: time, increasing, shape (n,) [s].
        psi: angle, shape (n,) [rad].
        memory: time constant of the filter [s].

    Returns:
        Yaw rate, shape (n,), zero at the first sample [rad/s].
    """
    rate = np.zeros_like(psi)
    for i in range(1, psi.size):
        dt = t[i] - t[i - 1]
        share = dt / (memory + dt)
        rate[i] = rate[i - 1] + share * ((psi[i] - psi[i - 1]) / dt - rate[i - 1])
    return rate
