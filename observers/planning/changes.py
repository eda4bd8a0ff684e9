"""Changes of a path that is steered: turn back, go on, swing wider or narrower, faster or slower."""

from typing import NamedTuple

import numpy as np

from observers.planning.path import SteeringLimits, SteeringPath, steer

SHORTER, LONGER = 0.6, 1.6
"""Factors on a leg, on the turning points behind it, and on the rate [1]."""
SWING = 0.005
"""A leg grows by at least this [rad]."""
FINAL_SWINGS = 3
"""Swings between both bounds that are appended behind a path's last turning point."""
AT_REST = 1e-9
"""Stopping distance below which the wheel counts as at rest [rad]."""
KINDS = ("none", "turn back", "shorter", "longer", "narrower", "wider", "slower", "faster")


class PathNow(NamedTuple):
    """Point on a path: angle and remaining turning points [rad], greatest rate and speed [rad/s].

    The speed is that toward the first of the points; bounds and middle are of the angle [rad].
    """

    psi: float
    points: tuple[float, ...]
    rate: float
    speed: float
    bounds: tuple[float, float]
    middle: float


def changed(present: PathNow, kind: str, limits: SteeringLimits, dt: float, time: float) -> SteeringPath:
    """The path with one of `KINDS` of changes, for at most a time [s]."""
    psi, (first, *rest), rate, speed, (low, high), middle = present
    heading = 1.0 if first >= psi else -1.0
    stop = psi + heading * speed**2 / (2 * limits.acceleration)
    if kind == "turn back":
        first = stop
    elif kind == "shorter":
        first = psi + SHORTER * (first - psi)
    elif kind == "longer":
        first = psi + LONGER * (first - psi) + heading * SWING
    elif kind in ("narrower", "wider"):
        factor = SHORTER if kind == "narrower" else LONGER
        rest = [middle + factor * (point - middle) for point in rest]
    elif kind in ("slower", "faster"):
        rate = float(
            np.clip(rate * (SHORTER if kind == "slower" else LONGER), limits.slowest, limits.rate)
        )
    points = [float(np.clip(point, low, high)) for point in (first, *rest)]
    points[0] = max(points[0], stop) if heading > 0 else min(points[0], stop)
    if kind == "turn back" and abs(stop - psi) < AT_REST:
        points = points[1:]
    # Behind its last point a path swings between the bounds.
    outward = bool(points) and points[-1] > middle
    points += [low, high] * FINAL_SWINGS if outward else [high, low] * FINAL_SWINGS
    return steer([psi, *points], rate, limits.acceleration, dt, time, speed)
