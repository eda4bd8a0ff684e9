"""The standard manoeuvres among which the discriminating experiment is chosen."""

from itertools import chain, pairwise

import numpy as np

from identification.experiments.steering import (
    LENGTH,
    Leg,
    Manoeuvre,
    Reach,
    between,
    manoeuvre_of,
    turns,
)


def manoeuvres(reach: Reach) -> tuple[Manoeuvre, ...]:
    """The library, each manoeuvre about `LENGTH` long, within reach.

    Every one begins at rest in the middle of the angles, with a patch that is free of deformation.
    """
    return (
        *_sweeps(reach),
        *_speeds(reach),
        *_rests(reach),
        *_loops(reach),
        *_loadings(reach),
    )


def _sweeps(reach: Reach) -> list[Manoeuvre]:
    """Sweeps to both ends, to one, fast or slow throughout."""
    fast = reach.speed
    return [
        manoeuvre_of(reach, f"sweep {between(reach)} at {fast:.2g} rad/s", turns(reach, [1, -1], fast)),
        manoeuvre_of(
            reach,
            f"turn to and fro between {reach.centre:.2f} and {reach.high:.2f} rad at {fast / 2:.2g}"
            " rad/s",
            turns(reach, [1, 0], fast / 2),
        ),
        manoeuvre_of(
            reach,
            f"sweep {between(reach, 0.5)} at {fast / 8:.2g} rad/s",
            turns(reach, [0.5, -0.5], fast / 8),
        ),
    ]


def _speeds(reach: Reach) -> list[Manoeuvre]:
    """The same turn at several speeds."""
    fast, slowest = reach.speed, reach.slow
    ladder = np.geomspace(fast, slowest, 5)
    rungs = [turns(reach, [s, -s], v) for s, v in zip([0.5, 0.5, 0.5, 0.5, 0.3], ladder, strict=True)]
    # On the second half of each sweep, where the patch slides, the two speeds take turns.
    places, paces = (-1.0, 0.0, 0.15, 0.6, 0.75, 1.0), (fast, slowest, fast, slowest, fast)
    changing = [
        leg
        for sign in (1.0, -1.0)
        for (start, to), pace in zip(pairwise(places), paces, strict=True)
        for leg in turns(reach, [sign * to], pace, sign * start)
    ]
    slow = min(max(slowest, 4 * reach.amplitude / (LENGTH / 2)), fast / 4)
    many = max(1, int(LENGTH / 2 * fast / (4 * reach.amplitude)))
    return [
        manoeuvre_of(
            reach,
            f"sweep {between(reach)}, {many} to and fro at {fast:.2g} rad/s and one at {slow:.2g} rad/s",
            [*many * turns(reach, [1, -1], fast), *turns(reach, [1, -1], slow)],
        ),
        manoeuvre_of(
            reach,
            f"sweep {between(reach, 0.5)}, each time slower, from {fast:.2g} to {slowest:.2g} rad/s"
            f" (the last one {between(reach, 0.3)})",
            list(chain.from_iterable(rungs)),
        ),
        manoeuvre_of(
            reach,
            f"sweep {between(reach)} at {fast:.2g} rad/s and, while the patch slides, slow down to"
            f" {slowest:.2g} rad/s for {0.15 * reach.amplitude:.2g} rad twice in each sweep",
            changing,
        ),
        manoeuvre_of(
            reach,
            f"turn to {reach.high:.2f} rad at {fast:.2g} rad/s and back to {reach.low:.2f} rad at"
            f" {fast / 6:.2g} rad/s",
            [*turns(reach, [1], fast, -1.0), *turns(reach, [-1], fast / 6, 1.0)],
        ),
    ]


def _rests(reach: Reach) -> list[Manoeuvre]:
    """Turn, hold, turn."""
    fast = reach.speed
    stairs = [0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0]
    return [
        manoeuvre_of(
            reach,
            f"sweep {between(reach)} at {fast:.2g} rad/s with rests of 3 s at either end",
            [*turns(reach, [1], fast, -1.0), Leg(1, 3), *turns(reach, [-1], fast, 1.0), Leg(-1, 3)],
        ),
        manoeuvre_of(
            reach,
            f"turn in steps of {0.5 * reach.amplitude:.2g} rad {between(reach)} at {fast:.2g}"
            " rad/s, resting 1.5 s after each",
            list(
                chain.from_iterable(
                    [*turns(reach, [to], fast, start), Leg(to, 1.5)]
                    for start, to in pairwise([0.0, *stairs])
                )
            ),
        ),
    ]


def _loops(reach: Reach) -> list[Manoeuvre]:
    """Small loops: about several centres, growing, shrinking, and during a slide."""
    fast, size = reach.speed, reach.amplitude
    centres = (-0.6, 0.0, 0.6)
    places = ", ".join(f"{reach.centre + centre * size:.2f}" for centre in centres)
    growing = [sign * share for share in (0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0) for sign in (1, -1)]
    slide = [-1 + 0.25 * i + back for i in range(1, 9) for back in (0.0, -0.15)]
    about = [
        manoeuvre_of(
            reach,
            f"oscillate by ±{share * size:.2g} rad, {times} times about each of {places} rad, at up to"
            f" {fast / 2:.2g} rad/s",
            turns(reach, [c + sign * share for c in centres for sign in times * [1, -1]], fast / 2),
        )
        for share, times in ((0.07, 8), (0.2, 4))
    ]
    return [
        *about,
        manoeuvre_of(
            reach,
            f"oscillate with an amplitude that grows from {0.05 * size:.2g} to {size:.2g} rad at up to"
            f" {fast / 2:.2g} rad/s",
            turns(reach, [*growing, 0.0], fast / 2),
        ),
        manoeuvre_of(
            reach,
            f"oscillate with an amplitude that shrinks from {size:.2g} to {0.05 * size:.2g} rad at up to"
            f" {fast / 2:.2g} rad/s",
            turns(reach, [*growing[::-1], 0.0], fast / 2),
        ),
        manoeuvre_of(
            reach,
            f"slide from {reach.low:.2f} to {reach.high:.2f} rad, turning back by {0.15 * size:.2g} rad"
            f" after every {0.25 * size:.2g} rad, at up to {fast:.2g} rad/s",
            turns(reach, [*slide[:-1], -1.0], fast),
        ),
    ]


def _loadings(reach: Reach) -> list[Manoeuvre]:
    """Steps of the load, at rest and while the wheel turns."""
    fast, (light, _, heavy) = reach.speed, reach.loads
    loads = f"load in steps of 2 s between {light:.0f} and {heavy:.0f} N"
    cycle = [*turns(reach, [1], fast, -1.0), Leg(1, 6), *turns(reach, [-1], fast, 1.0), Leg(-1, 6)]
    return [
        manoeuvre_of(
            reach,
            f"sweep {between(reach)} at {fast:.2g} rad/s with rests of 6 s at either end, {loads}",
            cycle,
            load_step=2.0,
        ),
        manoeuvre_of(
            reach,
            f"sweep {between(reach)} at {fast / 2:.2g} rad/s, {loads}",
            turns(reach, [1, -1], fast / 2),
            load_step=2.0,
        ),
    ]
