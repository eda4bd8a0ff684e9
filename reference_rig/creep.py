"""Bristles whose friction grows with the logarithm of their own sliding speed, in closed form.

A bristle that a step loads to `size` slides at v with size = A v + L (1 + c ln(v/v_ref)), A v being the
stress that its slip takes off. That is Wright's omega function.
"""

import numpy as np
from scipy.special import wrightomega

from reference_rig.hooks import Array

REFERENCE_SPEED = 1e-3
REST_SPEED = 1e-4
"""Below it the limit stays what it is there."""


def borne(size: Array, limit: Array, c: float, relief: float) -> tuple[Array, Array]:
    """What friction bears of a stress, and the derivative of that by the stress.

    Args:
        size: stress before the slip, not negative [m], shape (n,).
        limit: friction bound at the reference speed, greater than 0 [m], shape (n,).
        c: growth of the bound with ln v; 0 for one that stays the same [1].
        relief: stress that a slip at 1 m/s takes off in the step [m].
    """
    if c == 0:
        return np.minimum(size, limit), (size <= limit).astype(float)
    least = limit * (1 + c * np.log(REST_SPEED / REFERENCE_SPEED))
    sticking = size <= least
    held, slope = np.where(sticking, size, least), sticking.astype(float)
    over = np.flatnonzero(~sticking)
    growth, size = c * limit[over], size[over]
    speed = (
        growth
        / relief
        * wrightomega((size - limit[over]) / growth + np.log(REFERENCE_SPEED * relief / growth))
    )
    sliding = speed > REST_SPEED
    over, growth, speed = over[sliding], growth[sliding], speed[sliding]
    held[over] = limit[over] * (1 + c * np.log(speed / REFERENCE_SPEED))
    slope[over] = growth / (growth + relief * speed)
    return held, slope
