"""The sensors: encoder, sampling instants, and faults of a channel or of the clock.

A fault is a pure function of a seed and one channel. `dataclasses.replace` puts it on a recording;
instants of `jitter_instants` are given to the rig as `times`. Faults of two channels need two seeds, or
they strike the same samples.
"""

import numpy as np
from numpy.typing import NDArray

from reference_rig.hooks import Array

ENCODER_STEP = 4.2e-5
"""Angle step of a fine encoder [rad]."""
FOURTEEN_BIT_STEP = 2 * np.pi / 2**14
"""Angle step of an encoder of 14 bits a turn [rad]."""
LOAD_NOISE = 4e-4
"""Standard deviation of the load channel in shares of the mean load [1]."""
ROUNDING = 1e-9
"""So much may an instant lie outside the time [s]."""


def sample_instants(end: float, rate: float) -> Array:
    """Instants of an even sampling from zero to the end [s]."""
    return np.arange(int(end * rate * (1 + 1e-12)) + 1) / rate


def require_instants(times: Array, t: Array) -> None:
    """Instants have to increase and, but for rounding, to lie within the time."""
    if np.any(np.diff(times) <= 0) or times[0] < t[0] - ROUNDING or times[-1] > t[-1] + ROUNDING:
        raise ValueError(f"instants must increase within {t[0]} s to {t[-1]} s")


def quantise(psi: Array, step: float) -> Array:
    """Angles as an encoder of this step shows them [rad]; a step of 0 for none."""
    return np.round(psi / step) * step if step > 0 else psi


def record_channels(
    seed: int,
    psi: Array,
    torque: Array,
    F_N: Array,
    *,
    load: float | None = None,
    noise: float,
    encoder_step: float,
) -> tuple[Array, Array, Array]:
    """Angle [rad], torque [N m] and load [N], shape (n,), as the sensors show them.

    The noise is the standard deviation of the torque in shares of its range, 0 also silences the load,
    whose noise is a share of `load`, None for the mean. An encoder's step [rad] of 0 is none.
    """
    rng = np.random.default_rng([seed, 2])
    load_sigma = LOAD_NOISE * (float(np.mean(F_N)) if load is None else load) if noise > 0 else 0.0
    noisy = torque + noise * np.ptp(torque) * rng.standard_normal(len(torque))
    return (
        quantise(psi, encoder_step), noisy, F_N + load_sigma * rng.standard_normal(len(F_N)),
    )  # fmt: skip


def add_outliers(seed: int, signal: Array, *, share: float = 0.01, size: float | None = None) -> Array:
    """Throw a share of the finite samples off either way; None is as far as the signal ranges."""
    rng = np.random.default_rng([seed, 11])
    struck = _strike(rng, np.flatnonzero(np.isfinite(signal)), share)
    size = float(np.nanmax(signal) - np.nanmin(signal)) if size is None else size
    faulty = signal.copy()
    faulty[struck] += size * rng.choice([-1.0, 1.0], len(struck))
    return faulty


def drop_samples(seed: int, signal: Array, *, share: float = 0.2) -> Array:
    """Lose a share of the finite samples to NaN; never the first, from which observers start."""
    candidates = 1 + np.flatnonzero(np.isfinite(signal[1:]))
    struck = _strike(np.random.default_rng([seed, 12]), candidates, share)
    faulty = signal.copy()
    faulty[struck] = np.nan
    return faulty


def delay_samples(signal: Array, samples: int) -> Array:
    """Delay every sample by a number of samples; NaN until the first arrives."""
    if not 0 <= samples <= len(signal):
        raise ValueError(f"late by 0 to {len(signal)} samples, not by {samples}")
    return np.concatenate([np.full(samples, np.nan), signal[: len(signal) - samples]])


def jitter_instants(seed: int, t: Array, *, spread: float, least: float = 1e-4) -> Array:
    """Sampling instants of an uneven clock [s], shape (n,); they are known to the estimator.

    Every instant moves by up to half the spread [s] either way, thrown back at both ends of the time.
    Where the spread is longer than the sampling interval, instants overtake each other and are
    put in order: the intervals between them then are nearly those of a Poisson process, but not shorter
    than the least [s].
    """
    if not least * (len(t) - 1) < t[-1] - t[0]:
        raise ValueError(f"{len(t)} samples do not fit at intervals of {least} s")
    rng = np.random.default_rng([seed, 13])
    instants = np.abs(t - t[0] + spread * rng.uniform(-0.5, 0.5, len(t)))
    length = t[-1] - t[0]
    instants = np.sort(length - np.abs(length - instants))
    # Push on whatever follows too closely, then push back what has been pushed over the end.
    ladder = least * np.arange(len(t))
    instants = np.maximum.accumulate(instants - ladder)
    instants = np.minimum(instants, length - ladder[-1]) + ladder
    return t[0] + np.clip(instants, 0.0, length)


def _strike(rng: np.random.Generator, candidates: NDArray[np.intp], share: float) -> NDArray[np.intp]:
    if not 0 <= share <= 1:
        raise ValueError(f"a share is between 0 and 1, not {share}")
    return rng.choice(candidates, round(share * len(candidates)), replace=False)
