"""The yaw rate of an angle, from the past alone."""

import numpy as np

from symbolic.float_array_type import Array

FILTER_TIME_CONSTANT = 0.03
"""Time over which the past fades [s]; it lags by as much and takes the steps off an encoder."""


def next_rate(rate: float, turn: float, dt: float, memory: float = FILTER_TIME_CONSTANT) -> float:
    """The low-passed rate after one more sample, for a control loop [rad/s].

    Args:
        rate: what it was before, 0 at the start [rad/s].
        turn: change of the angle since the last sample [rad].
        dt: time since the last sample [s].
        memory: time constant of the filter [s].
    """
    # Not by turn / dt, which is infinite for the shortest steps.
    return rate + (turn - rate * dt) / (memory + dt)


def causal_rate(t: Array, psi: Array, memory: float = FILTER_TIME_CONSTANT) -> Array:
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
        rate[i] = next_rate(rate[i - 1], psi[i] - psi[i - 1], t[i] - t[i - 1], memory)
    return rate
