"""The family of paths among which a plan is sought: swings to either side that grow evenly."""

from math import ceil, floor, log2, log10
from typing import NamedTuple

from observers.planning.path import SteeringLimits
from symbolic import InvalidInputError

RAMP = 0.2
"""Time in which a path comes to its rate [s]: a limit of the acceleration is one of the rate."""
MIN_FIRST_TURN, POINTS_PER_DECADE = 10**-2.5, 10
"""Least first turning point [rad], and the number of points per decade above it."""


class Swing(NamedTuple):
    """A path of the family: greatest rate [rad/s], first and farthest turning point [rad]."""

    rate: float
    first: float
    farthest: float


def swings(limits: SteeringLimits, *, coarse: bool = False) -> list[Swing]:
    """The paths of the family that begin within limits; narrower ones begin with some of them.

    Raises:
        InvalidInputError: no rate of the family is within the limits.
    """
    fastest = min(limits.rate, limits.acceleration * RAMP)
    rates = [2.0**i for i in range(floor(log2(fastest)), ceil(log2(limits.slowest)) - 1, -1)]
    if not rates:
        raise InvalidInputError(
            f"limit rate must be at least {2 * limits.slowest:g} rad/s and acceleration"
            f" {2 * limits.slowest / RAMP:g} rad/s^2, twice what the slowest rate,"
            f" {limits.slowest:g} rad/s, needs; got {limits.rate:g} and {limits.acceleration:g}"
        )
    step, apart = (3, 1) if coarse else (1, 2)
    # The last one lies beyond the limit: it stands for a turn without an end.
    many = max(1, ceil(POINTS_PER_DECADE * log10(limits.angle / MIN_FIRST_TURN) / step + 1e-9)) * step
    angles = [MIN_FIRST_TURN * 10 ** (i / POINTS_PER_DECADE) for i in range(0, many + 1, step)]
    return [
        Swing(rate, first, farthest)
        for rate in rates
        for i, first in enumerate(angles)
        for farthest in angles[i::apart]
    ]
