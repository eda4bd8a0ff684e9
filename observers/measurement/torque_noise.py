"""White noise of a torque channel, estimated from its samples.

Means of the torque over blocks of `REFERENCE_STEP` are compared with their neighbours: of three in a row
the second difference has six times the variance of one, and a smooth torque contributes little to it.
What counts is noise by time, so that a sensor that measures every 10 ms or faster is not taken for less
noisy where it is sampled oftener; one that measures more slowly is. The corners of the torque are rare,
and their squares are limited.
"""

from typing import Any

import casadi as ca

from observers.layout import Expression, Parts
from observers.measurement.torque_error import is_known
from observers.tuning import REFERENCE_STEP

NOISE = ("time", "sum", "newer", "older", "variance", "blocks")
"""Time of the present block [s], and integral of its torque [N m s]; means of the last two blocks [N m];
variance of a block [N^2 m^2]; blocks so far."""
MAX_BLOCKS = 100.0
"""Blocks over which the variance is averaged."""
MAX_SQUARE = 9.0
"""Square of a second difference that counts at most, over its variance."""
JITTER = 0.99
"""Share of `REFERENCE_STEP` that fills a block [1]."""


def noise_after(
    before: Parts, M_z: Expression, dt: Expression, usual: Expression, least: Expression
) -> Parts:
    """The numbers of `NOISE` after a torque [N m], NaN where it is missing, of so long a step [s].

    usual is the variance of a block before one was seen, least that of a sensor without noise, about
    which the squares are limited [N^2 m^2].
    """
    known = is_known(M_z)
    time = before["time"] + dt
    total = before["sum"] + ca.if_else(known, M_z, 0) * dt
    mean = total / time
    closes = ca.logic_and(known, time >= JITTER * REFERENCE_STEP)
    variance = ca.if_else(before["blocks"] > 0, before["variance"], ca.fmax(before["variance"], usual))
    most = MAX_SQUARE * ca.fmax(variance, least)
    # A block may be longer than `REFERENCE_STEP`, of which the variance is counted.
    length = time / ca.fmax(REFERENCE_STEP, dt)
    square = ca.fmin(length * (mean - 2 * before["newer"] + before["older"]) ** 2 / 6, most)
    # The usual variance weighs as one block.
    seen = ca.fmax(before["blocks"], 1)
    grown = variance + ca.if_else(before["blocks"] >= 2, (square - variance) / seen, 0)
    closed = {
        "time": 0, "sum": 0, "newer": mean, "older": before["newer"], "variance": grown,
        "blocks": ca.fmin(before["blocks"] + 1, MAX_BLOCKS),
    }  # fmt: skip
    present = {**before, "time": time, "sum": total, "variance": variance}
    after: dict[str, Any] = {
        name: ca.if_else(closes, closed[name], ca.if_else(known, present[name], before[name]))
        for name in NOISE
    }
    return after


def sample_variance(noise: Expression, dt: Expression) -> Expression:
    """Variance of one sample whose step is dt [s], from that of `REFERENCE_STEP` [N^2 m^2]."""
    return noise * ca.fmax(1, REFERENCE_STEP / dt)
