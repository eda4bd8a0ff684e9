"""A block towed over a plate: three forces of a dynamometer, with what spoils them."""

from dataclasses import dataclass

import numpy as np

from reference_rig.hooks import Array

RATE = 1000.0
"""Samples a second [Hz]."""
LOADS = (20.0, 35.0, 50.0, 65.0, 80.0, 95.0, 110.0, 125.0, 140.0, 155.0)
"""Normal forces of the tows [N]."""


@dataclass(frozen=True, kw_only=True)
class Towing:
    """How the block slides and what the sensor adds."""

    mu: float = 0.6757
    """Coefficient of friction; its mean over the plate [1]."""
    scatter: float = 0.03
    """Standard deviation of mu from tow to tow in shares of it [1]."""
    adhesion: float = 0.0
    """Force without load [N]."""
    zero: float = 0.5
    """Standard deviation of the sensor's zero from tow to tow, each channel [N]."""
    judder: float = 0.05
    """Swing of the friction force in shares of it, about 12 Hz [1]."""
    noise: float = 1.0
    """Standard deviation of every sample, each channel [N]."""
    duration: float = 0.8
    """Length of one tow [s]."""


def make_tows(seed: int, towing: Towing, loads: tuple[float, ...] = LOADS) -> list[Array]:
    """Tow the block once at every load, each time at another slant to the sensor's axes.

    Returns:
        F_x, F_y, F_z of every tow as rows [N], shape (3, n) each.
    """
    rng = np.random.default_rng([seed, 11])
    t = np.arange(round(towing.duration * RATE)) / RATE
    tows = []
    for load in loads:
        force = towing.mu * (1 + towing.scatter * rng.standard_normal()) * load + towing.adhesion
        swing = 1 + towing.judder * np.sin(2 * np.pi * (12.0 * t + rng.random()))
        slant = rng.uniform(-0.2, 0.2)
        clean = np.vstack(
            [force * swing * np.cos(slant), force * swing * np.sin(slant), np.full_like(t, load)]
        )
        zeros = towing.zero * rng.standard_normal((3, 1))
        tows.append(clean + zeros + towing.noise * rng.standard_normal(clean.shape))
    return tows
