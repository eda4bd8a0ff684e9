"""Way, force, speed and acceleration of a car's rack at one instant, sample by sample.

A derivative that is late against its force makes drag and inertia look like friction. So all are taken
at the middle of the last `SMOOTHING_TIME`: the samples there as they are, derivatives by the parabola
through all of them. Nothing is taken from later samples; the whole is late by half the window.
"""

from collections import deque
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbolic.float_array_type import Array

SMOOTHING_TIME = 0.06
"""Time over which the parabola is laid [s]."""
MIN_SAMPLES = 5
"""Samples of a window; before there are as many, speed and acceleration are 0."""


class RackInstant(NamedTuple):
    """Way [m], force [N], speed [m/s] and acceleration [m/s^2] of the rack; numbers or arrays (n,)."""

    s: float | Array
    force: float | Array
    speed: float | Array
    acceleration: float | Array


class RackTimeDerivatives:
    """The rack of one standstill, from its first sample on."""

    def __init__(self) -> None:
        """Begin without a sample."""
        self._samples: deque[tuple[float, float, float]] = deque()

    def __call__(self, t: float, s: float, force: float) -> RackInstant:
        """The instant that one more sample [s, m, N] makes known; the way is NaN where it is missing."""
        samples = self._samples
        samples.append((t, s, force))
        # A time that is later than the newest one, or not known, is no part of the window either.
        while len(samples) > MIN_SAMPLES and not t - 1.05 * SMOOTHING_TIME <= samples[0][0] <= t:
            samples.popleft()
        at, way, held = samples[len(samples) // 2]
        near = [((then - at) / SMOOTHING_TIME, s - way) for then, s, _ in samples if isfinite(s)]
        if len(near) < MIN_SAMPLES or not isfinite(way):
            return RackInstant(way, held, 0.0, 0.0)
        slope, bend = _slope_half_curvature(near)
        return RackInstant(way, held, slope / SMOOTHING_TIME, 2 * bend / SMOOTHING_TIME**2)


def _slope_half_curvature(points: list[tuple[float, float]]) -> tuple[float, float]:
    """Slope and half the curvature at 0 of the parabola through points, by least squares."""
    # In plain sums: a library's depend in their last digit on where arrays lie. In one pass, as there
    # are sixty points at 1 kHz.
    n, (u1, u2, u3, u4), (v0, v1, v2) = len(points), [0.0] * 4, [0.0] * 3
    for u, v in points:
        square = u**2
        u1, u2, u3, u4 = u1 + u, u2 + square, u3 + u**3, u4 + u**4
        v0, v1, v2 = v0 + v, v1 + v * u, v2 + v * square
    # Less their means.
    a, b, c = u2 - u1 * u1 / n, u3 - u1 * u2 / n, u4 - u2 * u2 / n
    p, q = v1 - u1 * v0 / n, v2 - u2 * v0 / n
    determinant = a * c - b * b
    if not determinant > 0:
        # Samples of fewer than three times.
        return 0.0, 0.0
    return (c * p - b * q) / determinant, (a * q - b * p) / determinant


def differentiated_rack_signals(
    t: Array, s: Array, force: Array, stretch: NDArray[np.int64]
) -> RackInstant:
    """The instants of a recording; `stretch` numbers its standstills, each of which begins anew."""
    rows, motion, before = [], RackTimeDerivatives(), None
    for number, *sample in zip(stretch.tolist(), t.tolist(), s.tolist(), force.tolist(), strict=True):
        motion = motion if number == before else RackTimeDerivatives()
        rows.append(motion(*sample))
        before = number
    return RackInstant(*np.ascontiguousarray(np.array(rows).T))
