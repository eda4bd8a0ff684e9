"""How well recordings of one ground and load repeat: their torque of full slide.

No model of friction enters; k tells from which turn on the patch slides. What differs may have a cause
that a model knows, such as the rate of turning, so that it is no floor below which an error cannot come.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import rmse_of
from identification.fits.values_by_ground_and_recording import ground_of
from identification.reading.recordings import Recording
from identification.residuals.residual_signals import motion_since_reversal
from symbolic.patch_moment_by_zones import full_slide_arm

SAME_LOAD = 1.1
"""Ratio of mean loads, and of half-lengths, up to which recordings replicate each other [1]."""
BEYOND_ONSET = 4.0
"""Turn since the last reversal from which on a patch is taken to slide as a whole, its torque within 6 %
of its last, over the turn at which it begins to slide from rest [1]."""
MIN_SAMPLES = 20
"""Samples of full slide that a recording needs."""


@dataclass(frozen=True, kw_only=True)
class Repeatability:
    """What differs between replicates: recordings of one ground, load and half-length."""

    replicates: tuple[tuple[str, ...], ...]  # Names of recordings that belong together.
    spread: float  # Standard deviation of ln of the torque of full slide over load [1].
    # Torque error of a model whose friction is the mean of the replicates', rms over the torque's range,
    # at most: a patch that does not slide as a whole depends on friction by less [1].
    nrmse: float
    spreads: tuple[float, ...] = ()  # That of each group of `replicates` [1].


def repeatability(recordings: Sequence[Recording], k: float) -> Repeatability | None:
    """Repeatability of recordings on a tread of stiffness k [N/m^2]; None without any replicates."""
    levels = {r.name: level for r in recordings if np.isfinite(level := full_slide_friction(r, k))}
    groups = _replicates([r for r in recordings if r.name in levels])
    if not groups:
        return None
    logs = [np.log([levels[r.name] for r in group]) for group in groups]
    off = np.concatenate([one - one.mean() for one in logs])
    shares = [rmse_of(r.M_z) / torque_range(r) for group in groups for r in group]
    return Repeatability(
        replicates=tuple(tuple(r.name for r in group) for group in groups),
        spread=float(np.sqrt(off @ off / (off.size - len(logs)))),
        nrmse=float(np.mean(np.abs(off) * shares)),
        spreads=tuple(float(one.std(ddof=1)) for one in logs),
    )


def full_slide_friction(recording: Recording, k: float) -> float:
    """Median torque while the whole patch slides, over that of mu = 1 [1]; NaN where it hardly does."""
    rig, F_N = recording.rig, recording.F_N
    heading, travel, _ = motion_since_reversal(recording.t, recording.psi)
    with np.errstate(divide="ignore", invalid="ignore"):
        friction = -heading * recording.M_z / (F_N * float(full_slide_arm(rig.a, rig.e)))
    known = np.isfinite(friction) & (F_N > 0)
    if not known.any():
        return float("nan")
    onset = 3 * F_N * np.quantile(friction[known], 0.95) / (4 * rig.a**2 * k)
    slides = known & (travel > BEYOND_ONSET * onset)
    if np.count_nonzero(slides) < MIN_SAMPLES:
        return float("nan")
    level = float(np.median(friction[slides]))
    return level if level > 0 else float("nan")


def _replicates(recordings: Sequence[Recording]) -> list[list[Recording]]:
    """Groups of at least two recordings that replicate each other."""
    groups: list[list[Recording]] = []
    for one in sorted(recordings, key=lambda r: (str(ground_of(r)), float(r.F_N.mean()))):
        first = groups[-1][0] if groups else None
        if (
            first is not None
            and ground_of(first) == ground_of(one)
            and _same_load_and_length(first, one)
        ):
            groups[-1].append(one)
        else:
            groups.append([one])
    return [group for group in groups if len(group) > 1]


def _same_load_and_length(one: Recording, other: Recording) -> bool:
    ratios = (one.F_N.mean() / other.F_N.mean(), one.rig.a / other.rig.a)
    return all(1 / SAME_LOAD <= ratio <= SAME_LOAD for ratio in ratios)
