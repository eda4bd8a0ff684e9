"""Paths of the steering angle between turning points, within limits, and the family that a plan tries.

They swing to either side and grow evenly.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from math import ceil, floor, inf, log2, log10, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from observers.measurement.causal_yaw_rate import FILTER_TIME_CONSTANT, causal_rate
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

MAX_STEERING_LIMITS = {
    "angle": 20.0, "rate": 100.0, "slowest": 100.0, "torque": inf, "time": 600.0, "acceleration": 1e4,
}  # fmt: skip
"""Greatest value of each limit; time and angle bound the number of samples of a path."""


@dataclass(frozen=True, kw_only=True)
class SteeringLimits:
    """Limits on the motion of the wheel.

    Attributes:
        angle: either way from where it stands at first [rad].
        rate: greatest yaw rate [rad/s].
        slowest: least yaw rate [rad/s]: below it joints and gear stick and slip, and zeros drift.
        torque: greatest size of the torque that is measured [N m].
        time: duration [s].
        acceleration: greatest yaw acceleration [rad/s^2].

    Raises:
        InvalidInputError: one is not greater than 0 and at most what `MAX_STEERING_LIMITS` allows.
    """

    angle: float = 0.4
    rate: float = 0.5
    slowest: float = 0.05
    torque: float = inf
    time: float = 10.0
    acceleration: float = 10.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for field in fields(self):
            value, greatest = getattr(self, field.name), MAX_STEERING_LIMITS[field.name]
            if not 0 < value <= greatest:
                raise InvalidInputError(
                    f"limit {field.name} must be greater than 0 and at most {greatest:g}, got {value}"
                )
        if self.slowest > self.rate:
            raise InvalidInputError(
                f"limit rate must be at least the slowest one, {self.slowest:g} rad/s, got {self.rate:g}"
            )


@dataclass(frozen=True, eq=False)
class SteeringPath:
    """A path of the angle."""

    begin: float  # Angle one step before the first sample [rad].
    dt: float  # Between samples [s].
    psi: Array  # Angle, shape (n,) [rad].
    psi_dot: Array  # Yaw rate, shape (n,) [rad/s].
    points: Array  # Turning points after the begin [rad].
    leg: NDArray[np.int64]  # Index of the one that is turned to, shape (n,).
    rate: float  # Greatest yaw rate [rad/s].

    def first_samples(self, end: int) -> "SteeringPath":
        """Its first samples."""
        return replace(self, psi=self.psi[:end], psi_dot=self.psi_dot[:end], leg=self.leg[:end])

    @property
    def travel(self) -> Array:
        """Sum of the turns without their signs [rad]."""
        travel: Array = np.cumsum(np.abs(np.diff(self.psi, prepend=self.begin)), dtype=np.float64)
        return travel

    @cached_property
    def rate_from_past_angles(self) -> Array:
        """Yaw rate that an observer takes from the angle where none is measured [rad/s]."""
        psi: Array = np.concatenate([[self.begin], self.psi])
        t: Array = self.dt * np.arange(psi.size, dtype=np.float64)
        # The low-pass forgets the rate that there was before.
        before = self.psi_dot[0] * (1 + self.dt / FILTER_TIME_CONSTANT) ** (-t / self.dt)
        rate: Array = (causal_rate(t, psi) + before)[1:]
        return rate

    @property
    def t(self) -> Array:
        """Time since the begin [s]."""
        t: Array = self.dt * np.arange(1, self.psi.size + 1, dtype=np.float64)
        return t


def fastest_path(
    points: Sequence[float], rate: float, acceleration: float, dt: float, time: float,
    speed: float = 0.0, *, rest: float = 0.0,
) -> SteeringPath:  # fmt: skip
    """Fastest path from angle to angle within rate and acceleration, with a stop at each angle.

    The first of the turning points is the present angle, the first sample one step after it. The path
    ends where the last point is reached, or the time is over; `speed` is the present rate toward the
    second point, which is not nearer than the way to stop, `rest` the time before the wheel turns,
    where it has no speed. All in SI units.
    """
    begin = points[0] - np.sign(points[1] - points[0]) * speed**2 / (2 * acceleration)
    at = rest - speed / acceleration
    legs: list[tuple[float, ...]] = []
    for i, (start, end) in enumerate(pairwise([begin, *points[1:]])):
        if (length := abs(end - start)) == 0:
            continue
        fastest = min(max(rate, 0 if legs else speed), sqrt(length * acceleration))
        v, ramp, cruise = np.sign(end - start) * fastest, fastest / acceleration, length / fastest
        legs.append((at, start, v, cruise, ramp, i))
        at += cruise + ramp
        if at > time:
            break
    t = dt * np.arange(1, int(min(at, time) / dt + 1e-6) + 1)
    columns = np.array(legs).T
    begun, start, v, cruise, ramp, leg = columns[:, np.searchsorted(columns[0, 1:], t, side="right")]
    tau = t - begun
    # A trapezium of the rate: its integral is the difference of two ramps.
    psi = start + v * (_ramped_rate_integral(tau, ramp) - _ramped_rate_integral(tau - cruise, ramp))
    psi_dot = v * (np.clip(tau / ramp, 0, 1) - np.clip((tau - cruise) / ramp, 0, 1))
    ends = np.array(points[1:], dtype=float)
    return SteeringPath(points[0], dt, psi, psi_dot, ends, leg.astype(int), rate)


def _ramped_rate_integral(tau: Array, duration: Array) -> Array:
    """Integral of a rate that grows from 0 to 1 in a duration [s]."""
    within = np.clip(tau, 0, duration)
    return within**2 / (2 * duration) + np.maximum(tau - duration, 0)


SHORTER, LONGER = 0.6, 1.6
"""Factors on a leg, on the turning points behind it, and on the rate [1]."""
SWING = 0.005
"""A leg grows by at least this [rad]."""
FINAL_SWINGS = 3
"""Swings between both bounds that are appended behind a path's last turning point."""
AT_REST = 1e-9
"""Stopping distance below which the wheel counts as at rest [rad]."""
KINDS = ("none", "turn back", "shorter", "longer", "narrower", "wider", "slower", "faster")


class PathPoint(NamedTuple):
    """Point on a path."""

    psi: float  # Angle [rad].
    remaining_points: tuple[float, ...]  # Turning points [rad].
    rate: float  # Greatest one [rad/s].
    speed: float  # Toward the first of the points [rad/s].
    bounds: tuple[float, float]  # Of the angle [rad].
    middle: float  # Of the angle [rad].


def changed_path(
    present: PathPoint, kind: str, limits: SteeringLimits, dt: float, time: float
) -> SteeringPath:
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
        factor = SHORTER if kind == "slower" else LONGER
        rate = float(np.clip(factor * rate, limits.slowest, limits.rate))
    points = [float(np.clip(point, low, high)) for point in (first, *rest)]
    points[0] = max(points[0], stop) if heading > 0 else min(points[0], stop)
    if kind == "turn back" and abs(stop - psi) < AT_REST:
        points = points[1:]
    # Behind its last point a path swings between the bounds.
    outward = bool(points) and points[-1] > middle
    points += [low, high] * FINAL_SWINGS if outward else [high, low] * FINAL_SWINGS
    return fastest_path([psi, *points], rate, limits.acceleration, dt, time, speed)


RAMP = 0.2
"""Time in which a path comes to its rate [s]: a limit of the acceleration is one of the rate."""
MIN_FIRST_TURN, POINTS_PER_DECADE = 10**-2.5, 10
"""Least first turning point [rad], and the number of points per decade above it."""


class Swing(NamedTuple):
    """A path of the family: greatest rate [rad/s], first and farthest turning point [rad]."""

    rate: float
    first: float
    farthest: float


def swings_within_limits(limits: SteeringLimits, *, coarse: bool = False) -> list[Swing]:
    """The paths of the family that begin within limits; refused where none of its rates is.

    Narrower limits begin with some of them.
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
