"""How a handwheel is turned at standstill: strokes hand over hand, pauses, ways back, tremor."""

from collections.abc import Iterator
from math import pi

import numpy as np

from reference_rig.car_motion import CAR_STEP
from reference_rig.hooks import Array

QUIET = 0.6
"""Time before the first turn [s]."""
TREMOR = 2e-3
"""Standard deviation of what the hands add [rad]."""
NEAR_LOCK = 0.97
"""Share of the way to the stop that the driver uses [1]."""


def handwheel_path(seed: int, lock: float, *, by_hand: bool = True) -> Array:
    """Angle of a handwheel turned by a driver [rad], an entry every `CAR_STEP`, positive to the left.

    From straight ahead first by half a turn or more, with short ways back; then from one stop at the
    angle `lock` [rad] to nearly the other. Not by hand there are no strokes and no tremor.
    """
    rng = np.random.default_rng([seed, 21])
    knots, angles, here = [0.0, QUIET], [0.0, 0.0], 0.0
    pace = rng.uniform(1.5, 5.0)
    for target in _targets(rng, NEAR_LOCK * lock):
        while abs(target - here) > 1e-9:
            reach = rng.uniform(1.0, 3.5) if by_hand else 1e9
            here += np.clip(target - here, -reach, reach)
            speed = np.clip(pace * rng.lognormal(0.0, 0.25), 1.0, 7.0)
            knots.append(knots[-1] + abs(here - angles[-1]) / speed)
            angles.append(here)
            if by_hand and rng.random() < 0.5:
                knots.append(knots[-1] + rng.uniform(0.05, 0.3))
                angles.append(here)
        knots.append(knots[-1] + rng.uniform(0.1, 0.8))
        angles.append(here)
    t = np.arange(0.0, knots[-1] + 0.3, CAR_STEP)
    path = np.interp(t, knots, angles)
    for width in (0.15, 0.1):
        path = _smooth(path, round(width / CAR_STEP))
    if by_hand:
        noise = _smooth(rng.standard_normal(len(t)), round(0.08 / CAR_STEP))
        noise = _smooth(noise, round(0.05 / CAR_STEP))
        path = path + TREMOR * noise / noise.std() * np.clip((t - 0.3) / 0.3, 0.0, 1.0)
    return path


def _targets(rng: np.random.Generator, lock: float) -> Iterator[float]:
    """Angles at which the driver reverses or pauses [rad]."""
    side = rng.choice([-1.0, 1.0])
    first = side * min(rng.uniform(1.1, 1.8) * pi, 0.9 * lock)
    if rng.random() < 0.5:
        halt = first * rng.uniform(0.4, 0.8)
        yield halt
        yield halt * rng.uniform(0.3, 0.85)
    yield first
    yield first * rng.uniform(-0.4, 0.6)
    yield side * lock * rng.uniform(0.95, 1.0)
    if rng.random() < 0.5:
        yield side * lock * rng.uniform(0.2, 0.6)
    yield -side * lock * rng.uniform(0.97, 1.0)
    yield -side * lock * rng.uniform(0.1, 0.6)


def _smooth(path: Array, width: int) -> Array:
    """Mean over a window that slides over the path, whose ends are held."""
    padded = np.pad(path, (width // 2, width - 1 - width // 2), mode="edge")
    total = np.concatenate([[0.0], np.cumsum(padded)])
    return (total[width:] - total[:-width]) / width
