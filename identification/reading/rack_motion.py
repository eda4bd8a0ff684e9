"""Way, force, speed and acceleration of a car's rack at one instant, sample by sample.

A derivative that is late against its force makes drag and inertia look like friction. So all are taken
at the middle of the last `WINDOW`: the samples there as they are, derivatives by the parabola through
all of them. Nothing is taken from later samples; the whole is late by half the window.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WINDOW = 0.06
"""Time over which the parabola is laid [s]."""
LEAST_SAMPLES = 5
"""Samples of a window; before there are as many, speed and acceleration are 0."""


class RackInstant(NamedTuple):
    """Way [m], force [N], speed [m/s] and acceleration [m/s^2] of the rack; numbers or arrays (n,)."""

    s: float | Array
    force: float | Array
    speed: float | Array
    acceleration: float | Array


class RackMotion:
    """The rack of one standstill, from its first sample on."""

    def __init__(self) -> None:
        """Begin without a sample."""
        self._samples: deque[tuple[float, float, float]] = deque()

    def __call__(self, t: float, s: float, force: float) -> RackInstant:
        """The instant that is known with one more sample.

        Args:
            t: time [s].
            s: way of the rack [m], NaN where it is missing.
            force: on the rack [N].
        """
        samples = self._samples
        samples.append((t, s, force))
        while len(samples) > LEAST_SAMPLES and samples[0][0] < t - 1.05 * WINDOW:
            samples.popleft()
        at, way, held = samples[len(samples) // 2]
        table = np.array(samples)
        known = table[np.isfinite(table[:, 1])]
        if len(known) < LEAST_SAMPLES or not np.isfinite(way):
            return RackInstant(way, held, 0.0, 0.0)
        u = known[:, 0] - at
        powers = np.stack([np.ones_like(u), u, u**2])
        fit = np.linalg.lstsq(powers.T, known[:, 1], rcond=None)[0]
        return RackInstant(way, held, float(fit[1]), 2 * float(fit[2]))


def rack_motion(t: Array, s: Array, force: Array, stretch: NDArray[np.int64]) -> RackInstant:
    """The instants of a recording; `stretch` numbers its standstills, each of which begins anew."""
    rows, motion, before = [], RackMotion(), None
    for number, *sample in zip(stretch.tolist(), t.tolist(), s.tolist(), force.tolist(), strict=True):
        motion = motion if number == before else RackMotion()
        rows.append(motion(*sample))
        before = number
    return RackInstant(*np.array(rows).T)
