"""Faults of sensors and of their clock: pure functions of a seed and one channel.

Put them on a recording with `dataclasses.replace`, and sample at `jittered` instants by handing
them to the rig. Faults of two channels need two seeds, or they strike the same samples.
"""

import numpy as np

from reference_rig.ground import quantise
from reference_rig.hooks import Array


def outliers(seed: int, signal: Array, *, share: float = 0.01, size: float | None = None) -> Array:
    """Throw a share of the finite samples off, upwards or downwards alike.

    Args:
        seed: of which samples and which way.
        signal: any channel, shape (n,).
        share: of the finite samples [1].
        size: how far, in the signal's unit; None for the signal's range.
    """
    rng = np.random.default_rng([seed, 11])
    struck = _strike(rng, np.flatnonzero(np.isfinite(signal)), share)
    size = float(np.nanmax(signal) - np.nanmin(signal)) if size is None else size
    faulty = signal.copy()
    faulty[struck] += size * rng.choice([-1.0, 1.0], len(struck))
    return faulty


def dropped(seed: int, signal: Array, *, share: float = 0.2) -> Array:
    """Lose a share of the finite samples to NaN; never the first, from which observers start."""
    struck = _strike(
        np.random.default_rng([seed, 12]), 1 + np.flatnonzero(np.isfinite(signal[1:])), share
    )
    faulty = signal.copy()
    faulty[struck] = np.nan
    return faulty


def encoded(psi: Array, *, bits: int = 14) -> Array:
    """Angles [rad] as an encoder with so many bits a turn shows them."""
    return quantise(psi, 2 * np.pi / 2**bits)


def late(signal: Array, samples: int) -> Array:
    """Hand every sample over so many samples late; NaN until the first arrives."""
    if not 0 <= samples <= len(signal):
        raise ValueError(f"late by 0 to {len(signal)} samples, not by {samples}")
    return np.concatenate([np.full(samples, np.nan), signal[: len(signal) - samples]])


def jittered(seed: int, t: Array, *, spread: float, least: float = 1e-4) -> Array:
    """Sampling instants of an uneven clock; they are known to the estimator.

    Every instant moves by up to half the spread either way, thrown back at both ends of the time.
    Where the spread is longer than the sampling interval, instants overtake each other and are
    put in order: the intervals between them then are nearly those of a Poisson process.

    Args:
        seed: of the jitter.
        t: even instants [s], increasing, shape (n,).
        spread: width of the uniform jitter [s].
        least: shortest interval [s].

    Returns:
        Increasing instants within the first and last of t [s], shape (n,).
    """
    if not least * (len(t) - 1) < t[-1] - t[0]:
        raise ValueError(f"{len(t)} samples do not fit at intervals of {least} s")
    rng = np.random.default_rng([seed, 13])
    moved = np.abs(t - t[0] + spread * rng.uniform(-0.5, 0.5, len(t)))
    length = t[-1] - t[0]
    moved = np.sort(length - np.abs(length - moved))
    # Push on whatever follows too closely, then push back what has been pushed over the end.
    ladder = least * np.arange(len(t))
    moved = np.maximum.accumulate(moved - ladder)
    moved = np.minimum(moved, length - ladder[-1]) + ladder
    return t[0] + np.clip(moved, 0.0, length)


def _strike(rng: np.random.Generator, candidates: Array, share: float) -> Array:
    if not 0 <= share <= 1:
        raise ValueError(f"a share is between 0 and 1, not {share}")
    return rng.choice(candidates, round(share * len(candidates)), replace=False)
