"""Steering by which generated code is counted: the ordinary, and what fills the patch with corners.

At every reversal inside the last one the exact patch has a corner more: a recording with few of them
tells too little of what a step takes.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from symbolic import GEOMETRY, simulate
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG

RATE = 100.0
"""Samples a second [Hz]."""
PACE = 0.4
"""Mean rate of a turn [rad/s]."""
ENCODER = 2 * np.pi / 2**14
"""Step of the angle's sensor [rad]."""
MU = 1.2


def decreasing(count: int = 20, first: float = 0.3, last: float = 0.03) -> list[float]:
    """Angles of a wheel that swings to and fro, each time less far [rad]."""
    return [size * (-1) ** i for i, size in enumerate(np.linspace(first, last, count))]


def at_random(count: int = 32) -> list[float]:
    """Angles at random to either side, of sizes that shrink twice [rad]."""
    sizes = np.random.default_rng(4).uniform(0.75, 1.0, count) * 0.32 * 0.93 ** (np.arange(count) % 16)
    return [float(size) * (-1) ** i for i, size in enumerate(sizes)]


PARKING = [
    *(0.5, 0.35, 0.42, 0.38, 0.45, -0.1, 0.0, -0.04, -0.5, -0.3, -0.34, -0.31, -0.33, -0.45, -0.2),
    *(-0.3, -0.23, -0.28, -0.24, -0.27, -0.25, 0.3, 0.1, 0.22, 0.14, 0.2, 0.16, 0.19, 0.0, 0.1, 0.02),
]
"""Angles of a parking manoeuvre, lock to lock with corrections [rad]."""
ORDINARY: dict[str, list[float]] = {
    "decreasing": decreasing(), "parking": PARKING, "random": at_random(),
}  # fmt: skip
"""Turning points of ordinary steering [rad]."""
NESTED = decreasing(36, last=0.05)
"""Turning points of steering that fills the patch with corners [rad]."""


def path(targets: Sequence[float], pace: float = PACE) -> Array:
    """Angles (n,) from rest to one turning point after the other, in half a cosine each [rad]."""
    pieces, here = [np.zeros(20)], 0.0
    for target in targets:
        count = max(4, round(abs(target - here) / pace * RATE))
        share = (1 - np.cos(np.pi * np.arange(1, count + 1) / count)) / 2
        pieces.append(here + (target - here) * share)
        here = target
    return np.concatenate(pieces)


def samples_along(targets: Sequence[float], observer: Any) -> Array:
    """Samples (n, 5) psi, psi_dot, torque, F_N, dt of a wheel that the observer's model explains."""
    return samples_of_path(path(targets), observer)


def samples_at_the_cap(observer: Any) -> Array:
    """The same of a patch full of corners, then turned out through all of them at once, twice.

    The second time the torque is three times what the model explains, so that friction is acquired on.
    """
    nested = path(NESTED, pace=2.0)
    away = np.concatenate([nested, nested[-1] + 0.08 * np.arange(1, 8)])
    back = np.concatenate([-nested, -nested[-1] - 0.08 * np.arange(1, 8)])
    rows = [samples_of_path(psi, observer) for psi in (away, back)]
    rows[1][:, 2] *= 3.0
    return np.concatenate(rows)


def samples_of_path(psi: Array, observer: Any) -> Array:
    """Samples (n, 5) along angles (n,) [rad], torque and load with noise."""
    rng, t = np.random.default_rng(3), np.arange(psi.size) / RATE
    F_N = 400 * (1 + 0.03 * np.sin(1.3 * t) + 0.003 * rng.standard_normal(psi.size))
    rate = np.gradient(psi, 1 / RATE)
    signals = np.vstack([psi, rate, F_N, np.full_like(psi, 1 / RATE)])
    theta = np.asarray(observer.model.theta({**observer.values, "mu": MU})).ravel()
    geometry = np.array([getattr(RIG, name) for name in GEOMETRY])
    torque = simulate(observer.model, signals, theta, geometry).M_z
    if observer.channel == "M":
        torque = RIG.J_A * np.gradient(rate, 1 / RATE) + RIG.b_t * rate - torque
    torque = torque + 0.04 * rng.standard_normal(psi.size)
    angle = ENCODER * np.round(psi / ENCODER)
    step = np.full_like(psi, 1 / RATE)
    return np.column_stack([angle, np.full_like(psi, np.nan), torque, F_N, step])
