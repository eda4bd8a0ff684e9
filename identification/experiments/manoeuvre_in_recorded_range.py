"""Standard manoeuvres within the range that the recordings show: turns, rests, steps of the load.

Angles and loads stay within those of the recordings and no turn is faster than theirs; slower ones and
rests are always possible.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from identification.reading.recordings import Recording
from identification.reading.trimming_and_thinning import MIN_REVERSAL
from symbolic.float_array_type import Array

SAMPLE_PERIOD = 0.02
"""Time between samples of a manoeuvre [s]."""
LENGTH = 40.0
"""A manoeuvre is repeated until it lasts about this long [s]."""
MIN_TURN_RATE = 0.02
"""Slowest turning, where the rig has been turned clearly faster [rad/s]."""
MAX_RATE_QUANTILE = 0.99
"""The fastest turning is this quantile of the recorded speeds: differentiated angles have spikes."""
_EDGE, _STOP = 0.3, 0.45
"""Time in which a turn begins or ends, and duration of the stop at a reversal [s]."""
_QUICKEST = 0.5
"""Shortest duration of a turn [s]."""
_LOADED = (0.01, 0.99)
"""Least and greatest load are these quantiles of the loads recorded."""


class ManoeuvreLeg(NamedTuple):
    """A turn to an angle, from their middle as a share of the amplitude [1], or a rest there."""

    share: float
    seconds: float


@dataclass(frozen=True, kw_only=True)
class RecordedRange:
    """Least and greatest angle [rad], fastest turning [rad/s]; least, usual and greatest load [N]."""

    low: float
    high: float
    speed: float
    loads: tuple[float, float, float]

    @property
    def slowest_speed(self) -> float:
        """Slowest turning of a manoeuvre [rad/s]."""
        return min(MIN_TURN_RATE, self.speed / 4)

    @property
    def centre(self) -> float:
        """Middle of the angles [rad]."""
        return (self.low + self.high) / 2

    @property
    def amplitude(self) -> float:
        """Half the range of angles [rad]."""
        return (self.high - self.low) / 2

    def angle_range_text(self, share: float = 1.0) -> str:
        """An interval about the middle of the angles, in words."""
        low, high = (self.centre + sign * share * self.amplitude for sign in (-1, 1))
        return f"between {low:.2f} and {high:.2f} rad"

    def turn_legs(
        self, shares: Sequence[float], speed: float, start: float | None = None
    ) -> list[ManoeuvreLeg]:
        """Turns to shares of the amplitude at a speed [rad/s], from a start or, in a cycle, the last."""
        first = shares[-1] if start is None else start
        return [
            ManoeuvreLeg(to, max(abs(to - before) * self.amplitude / speed, _QUICKEST))
            for before, to in pairwise([first, *shares])
        ]


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledManoeuvre:
    """An instruction in words; time [s], angle [rad], its rate [rad/s] and load [N], shape (n,)."""

    instruction: str
    t: Array
    psi: Array
    psi_dot: Array
    F_N: Array

    @property
    def signals(self) -> Array:
        """psi, psi_dot, F_N, dt as rows, as `symbolic.simulate` takes them, shape (4, n)."""
        return np.vstack([self.psi, self.psi_dot, self.F_N, np.full(self.t.size, SAMPLE_PERIOD)])

    @property
    def first_stroke_sentence(self) -> str:
        """Where it begins and which way it turns first, in a sentence."""
        way = self.psi[np.argmax(np.abs(self.psi - self.psi[0]) > MIN_REVERSAL)] - self.psi[0]
        back = np.flatnonzero(way * np.diff(self.psi) < 0)
        ends = self.psi[0], self.psi[back[0] if back.size else -1]
        begin, to = (f"{round(float(np.degrees(angle)))}°".replace("-", "−") for angle in ends)
        return f"It begins at {begin} and turns to {to} first."

    @property
    def seconds(self) -> float:
        """How long it lasts [s]."""
        return float(self.t[-1])


def recorded_range(recordings: Sequence[Recording]) -> RecordedRange:
    """The range of angle, speed and load of these recordings."""
    speeds = np.concatenate([np.abs(r.psi_dot) for r in recordings])
    loads = np.concatenate([r.F_N for r in recordings])
    least, usual, greatest = np.quantile(loads, [_LOADED[0], 0.5, _LOADED[1]])
    return RecordedRange(
        low=min(float(r.psi.min()) for r in recordings),
        high=max(float(r.psi.max()) for r in recordings),
        speed=float(np.quantile(speeds, MAX_RATE_QUANTILE)),
        loads=(float(least), float(usual), float(greatest)),
    )


def sampled_manoeuvre(
    reach: RecordedRange,
    instruction: str,
    cycle: Sequence[ManoeuvreLeg],
    *,
    load_step: float | None = None,
) -> SampledManoeuvre:
    """A manoeuvre: from rest in the middle to where the cycle begins, then the cycle, again and again.

    The instruction is the cycle in words; load and time are added. Its first turn begins where the last
    ends. The load goes from the least to the greatest and back after every `load_step` [s], if given.
    """
    lasts = sum(leg.seconds for leg in _insert_stops_at_reversals([*cycle, cycle[0]])) - cycle[0].seconds
    begin = reach.turn_legs([cycle[-1].share], reach.speed, 0.0)
    cycles, end = max(1, round(LENGTH / lasts)) * list(cycle), ManoeuvreLeg(cycle[-1].share, 0.5)
    legs = _insert_stops_at_reversals([ManoeuvreLeg(0, 0.5), *begin, *cycles, end])
    corners = np.cumsum([0.0, *(leg.seconds for leg in legs)])
    t: Array = np.arange(int(corners[-1] / SAMPLE_PERIOD) + 1, dtype=np.float64) * SAMPLE_PERIOD
    angles = reach.centre + reach.amplitude * np.array([0.0, *(leg.share for leg in legs)])
    psi = _smooth_by_moving_average(np.interp(t, corners, angles))
    light, usual, heavy = reach.loads
    F_N, constant = np.full(t.size, usual), f", load {usual:.0f} N"
    if load_step is not None:
        F_N, constant = _smooth_by_moving_average(np.where((t // load_step) % 2 == 0, light, heavy)), ""
    return SampledManoeuvre(
        instruction=f"{instruction}{constant}, {t[-1]:.0f} s".replace("-", "−"),
        t=t,
        psi=psi,
        psi_dot=np.gradient(psi, SAMPLE_PERIOD),
        F_N=F_N,
    )


def _insert_stops_at_reversals(legs: Sequence[ManoeuvreLeg]) -> list[ManoeuvreLeg]:
    """These legs with a stop at every reversal."""
    # Friction that depends on speed is sensitive to standstill, else shorter than a sample.
    stopped, heading = [legs[0]], 0.0
    for before, leg in pairwise(legs):
        turn = np.sign(leg.share - before.share)
        if turn * heading < 0 and stopped[-1].share != stopped[-2].share:
            stopped.append(ManoeuvreLeg(before.share, _STOP))
        stopped.append(leg)
        heading = turn or heading
    return stopped


def _smooth_by_moving_average(steps: Array) -> Array:
    """The series without corners: a moving average over `_EDGE`, which stays within its range."""
    half = round(_EDGE / SAMPLE_PERIOD / 2)
    window = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(steps, half, mode="edge")
    return np.convolve(padded, window / window.sum(), mode="valid")
