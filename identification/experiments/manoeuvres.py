"""The standard manoeuvres among which the discriminating experiment is chosen."""

from itertools import pairwise

import numpy as np

from identification.experiments.manoeuvre_in_recorded_range import (
    LENGTH,
    ManoeuvreLeg,
    RecordedRange,
    SampledManoeuvre,
    sampled_manoeuvre,
)

Cycles = dict[str, list[ManoeuvreLeg]]
"""Turns and rests of a manoeuvre, by its instruction."""
LOAD_STEP = 2.0
"""Time between changes of the load, in manoeuvres where it changes [s]."""


def manoeuvres(reach: RecordedRange) -> tuple[SampledManoeuvre, ...]:
    """The library within reach, each about `LENGTH` long, from rest in the middle of the angles."""
    steady = (
        _sweeps(reach) | _turns_at_several_speeds(reach) | _turns_with_rests(reach) | _minor_loops(reach)
    )
    return (
        *(sampled_manoeuvre(reach, words, cycle) for words, cycle in steady.items()),
        *(
            sampled_manoeuvre(reach, words, cycle, load_step=LOAD_STEP)
            for words, cycle in _turns_with_load_steps(reach).items()
        ),
    )


def _sweeps(reach: RecordedRange) -> Cycles:
    """Sweeps to both ends, to one, fast or slow throughout."""
    fast = reach.speed
    return {
        f"sweep {reach.angle_range_text()} at {fast:.2g} rad/s": reach.turn_legs([1, -1], fast),
        f"turn to and fro between {reach.centre:.2f} and {reach.high:.2f} rad at {fast / 2:.2g} rad/s": (
            reach.turn_legs([1, 0], fast / 2)
        ),
        f"sweep {reach.angle_range_text(0.5)} at {fast / 8:.2g} rad/s": reach.turn_legs(
            [0.5, -0.5], fast / 8
        ),
    }


def _turns_at_several_speeds(reach: RecordedRange) -> Cycles:
    """The same turn at several speeds."""
    fast, slowest = reach.speed, reach.slowest_speed
    ladder = zip((0.5, 0.5, 0.5, 0.5, 0.3), np.geomspace(fast, slowest, 5), strict=True)
    # On the second half of each sweep, where the patch slides, the two speeds take turns.
    places, paces = (-1.0, 0.0, 0.15, 0.6, 0.75, 1.0), (fast, slowest, fast, slowest, fast)
    changing = [
        leg
        for sign in (1.0, -1.0)
        for (start, to), pace in zip(pairwise(places), paces, strict=True)
        for leg in reach.turn_legs([sign * to], pace, sign * start)
    ]
    slow = min(max(slowest, 4 * reach.amplitude / (LENGTH / 2)), fast / 4)
    many = max(1, int(LENGTH / 2 * fast / (4 * reach.amplitude)))
    angles = reach.angle_range_text()
    return {
        f"sweep {angles}, {many} to and fro at {fast:.2g} rad/s and one at {slow:.2g} rad/s": [
            *many * reach.turn_legs([1, -1], fast),
            *reach.turn_legs([1, -1], slow),
        ],
        f"sweep {reach.angle_range_text(0.5)}, each time slower, from {fast:.2g} to {slowest:.2g} rad/s"
        f" (the last one {reach.angle_range_text(0.3)})": [
            leg for share, speed in ladder for leg in reach.turn_legs([share, -share], speed)
        ],
        f"sweep {reach.angle_range_text()} at {fast:.2g} rad/s and, while the patch slides, slow down to"
        f" {slowest:.2g} rad/s for {0.15 * reach.amplitude:.2g} rad twice in each sweep": changing,
        f"turn to {reach.high:.2f} rad at {fast:.2g} rad/s and back to {reach.low:.2f} rad at"
        f" {fast / 6:.2g} rad/s": [
            *reach.turn_legs([1], fast, -1.0),
            *reach.turn_legs([-1], fast / 6, 1.0),
        ],
    }


def _turns_with_rests(reach: RecordedRange) -> Cycles:
    """Turn, hold, turn."""
    fast, stairs = reach.speed, [0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0]
    return {
        f"sweep {reach.angle_range_text()} at {fast:.2g} rad/s with rests of 3 s at either end": (
            _sweep_legs_with_rests(reach, 3.0)
        ),
        f"turn in steps of {0.5 * reach.amplitude:.2g} rad {reach.angle_range_text()} at {fast:.2g}"
        " rad/s, resting 1.5 s after each": [
            leg
            for start, to in pairwise(stairs)
            for leg in (*reach.turn_legs([to], fast, start), ManoeuvreLeg(to, 1.5))
        ],
    }


def _minor_loops(reach: RecordedRange) -> Cycles:
    """Small loops: about several centres, growing, shrinking, and during a slide."""
    fast, size = reach.speed, reach.amplitude
    pace = f"at up to {fast / 2:.2g} rad/s"
    centres = (-0.6, 0.0, 0.6)
    places = ", ".join(f"{reach.centre + centre * size:.2f}" for centre in centres)
    growing = [sign * share for share in (0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0) for sign in (1, -1)]
    slide = [-1 + 0.25 * i + back for i in range(1, 9) for back in (0.0, -0.15)]
    about = {
        f"oscillate by ±{share * size:.2g} rad, {times} times about each of {places} rad, {pace}": (
            reach.turn_legs([c + sign * share for c in centres for sign in times * [1, -1]], fast / 2)
        )
        for share, times in ((0.07, 8), (0.2, 4))
    }
    return about | {
        f"oscillate with an amplitude that grows from {0.05 * size:.2g} to {size:.2g} rad {pace}": (
            reach.turn_legs([*growing, 0.0], fast / 2)
        ),
        f"oscillate with an amplitude that shrinks from {size:.2g} to {0.05 * size:.2g} rad {pace}": (
            reach.turn_legs([*growing[::-1], 0.0], fast / 2)
        ),
        f"slide from {reach.low:.2f} to {reach.high:.2f} rad, turning back by {0.15 * size:.2g} rad"
        f" after every {0.25 * size:.2g} rad, at up to {fast:.2g} rad/s": (
            reach.turn_legs([*slide[:-1], -1.0], fast)
        ),
    }


def _turns_with_load_steps(reach: RecordedRange) -> Cycles:
    """Steps of the load, at rest and while the wheel turns."""
    fast, (light, _, heavy) = reach.speed, reach.loads
    loads = f"load in steps of {LOAD_STEP:g} s between {light:.0f} and {heavy:.0f} N"
    return {
        f"sweep {reach.angle_range_text()} at {fast:.2g} rad/s with rests of 6 s at either end,"
        f" {loads}": (_sweep_legs_with_rests(reach, 6.0)),
        f"sweep {reach.angle_range_text()} at {fast / 2:.2g} rad/s, {loads}": reach.turn_legs(
            [1, -1], fast / 2
        ),
    }


def _sweep_legs_with_rests(reach: RecordedRange, rest: float) -> list[ManoeuvreLeg]:
    """A sweep to both ends with a rest [s] at either."""
    to, fro = reach.turn_legs([1], reach.speed, -1.0), reach.turn_legs([-1], reach.speed, 1.0)
    return [*to, ManoeuvreLeg(1, rest), *fro, ManoeuvreLeg(-1, rest)]
