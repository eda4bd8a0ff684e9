"""Signs that a torque sensor ends below full slide, where no range of it is declared.

Full slide, and a sensor that ends, both make a torque that stays. Two things tell them apart:

| sign | because |
|---|---|
| the torque's noise is less near its greatest values | an amplifier that gives way flattens it, too |
| the greatest torque does not follow the load | full slide is in proportion to it |

Noise is taken from differences of a high order. A low-passed torque and a fast turn leave more in them
than noise, which is not the same at all torques: nothing is told unless they are those of white noise.
Noise counts where it is more than the steps in which the torque was recorded, and not that of the angle,
which turns the sticking patch to and fro but not the sliding one. That of the load counts as none of its
changes.
"""

from dataclasses import dataclass
from math import comb, exp, sqrt

import numpy as np
from numpy.typing import NDArray

from identification.reading.checked_sample_table import MIN_SAMPLES
from symbolic.float_array_type import Array

ORDER = 4
"""Of the differences; a higher one does as well."""
WHITE = -0.5
"""Correlation of neighbouring differences below which they are white noise's [1], which have -0.8."""
GREAT = 0.85
"""Share of the greatest torque above which a torque is great [1]."""
SMALL = 0.5
"""Share of the greatest torque below which a torque is small [1]."""
LESS_NOISE = 0.75
"""Noise of great torques over that of small ones below which the sensor gives way [1]."""
CLEAR = 3.0
"""Standard deviations that are added to a figure before it is judged [1]."""
MAD_SPREAD = 1.17 * 2**0.5
"""Standard deviation of a noise by its median, relative, times the root of the samples [1]: of
differences every second is independent."""
STEPS = 2.0
"""Noise over the least change of the torque from which it is noise [1]."""
BY_ANGLE = 0.2
"""Share of the noise's power up to which it is not that of the angle [1]."""
WITHIN = 4.0
"""Noise by which a torque at the end of its sensor is off at most [1]."""
ABOVE = 5.0
"""Noise by which that end is below the greatest torque at most [1]."""
BLOCK = 10
"""Samples in a row that make a block."""
MIN_BLOCKS = 12
"""Fewest blocks."""
FLAT = 2.5
"""Variance of the blocks over that of white noise up to which the torque stays [1]."""
FOLLOWS = 0.4
"""Share of the proportion to the load below which the torque does not follow it [1]."""
LEAST_CHANGE = 0.03
"""Change of the load from which on the torque can follow it [1]."""
QUANTILE = 0.98
"""Of the torque's size, above which are spikes [1]."""


@dataclass(frozen=True, kw_only=True)
class SensorSaturation:
    """Where a sensor seems to end [N m], and by what sign, in words."""

    torque: float
    sign: str


def detect_saturation(torque: Array, psi: Array, F_N: Array) -> SensorSaturation | None:
    """Where the sensor of the torque seems to end; None where nothing says that it does.

    Args:
        torque: as measured, NaN where it is missing [N m], shape (n,).
        psi: yaw angle [rad], shape (n,).
        F_N: load [N], shape (n,); samples where one of the three is missing do not count.
    """
    known = np.isfinite(torque) & np.isfinite(psi) & np.isfinite(F_N)
    if np.count_nonzero(known) < MIN_SAMPLES:
        return None
    torque, psi, load = torque[known], psi[known], F_N[known]
    size = np.abs(torque)
    most = float(np.quantile(size, QUANTILE))
    rough = _noise_scaled_differences(torque)
    great, small = (np.isfinite(rough) & place for place in (size > GREAT * most, size < SMALL * most))
    if not (great.any() and small.any()):
        return None
    noise, at_top = _noise_std(rough[small]), _noise_std(rough[great])
    changes = np.abs(np.diff(torque))
    least = float(changes[changes > 0].min(initial=np.inf))
    by_angle = _noise_correlation(_noise_scaled_differences(psi)[small], rough[small]) ** 2
    pairs = small[1:] & small[:-1]
    is_noise = noise > STEPS * least and _noise_correlation(rough[:-1][pairs], rough[1:][pairs]) < WHITE
    if not is_noise or by_angle > BY_ANGLE:
        return None
    doubt = MAD_SPREAD * sqrt(1 / np.count_nonzero(great) + 1 / np.count_nonzero(small))
    if at_top * exp(CLEAR * doubt) < LESS_NOISE * noise:
        sign = f"its noise is {at_top / noise:.2f} of that of small torques"
        return SensorSaturation(torque=most, sign=sign)
    return _saturation_if_load_independent(size, load, at_top, most)


def _saturation_if_load_independent(
    size: Array, load: Array, noise: float, most: float
) -> SensorSaturation | None:
    """The end that a torque reaches, from where it stays within its noise whatever the load."""
    near = size >= most - ABOVE * noise
    end = float(np.median(size[near])) if near.any() else most
    if not end > 2 * WITHIN * noise:
        return None
    blocks = _blocks(np.abs(size - end) < WITHIN * noise)
    if len(blocks) < MIN_BLOCKS:
        return None
    level, weight = (np.array([of[block].mean() for block in blocks]) for of in (size, load))
    off, follows = weight - weight.mean(), float(level.mean() / weight.mean())
    of_load = _noise_std(_noise_scaled_differences(load)) / sqrt(BLOCK)
    # Less the noise of the load, which would make the slope of least squares the smaller.
    power = float(off @ off) - (len(off) + CLEAR * sqrt(2 * len(off))) * of_load**2
    change = sqrt(12 * max(power, 0.0) / len(off)) / weight.mean()
    if change < LEAST_CHANGE:
        return None
    slope = float(off @ level) / power
    error = sqrt((noise**2 / BLOCK + (follows * of_load) ** 2) * float(off @ off)) / power
    flat = float(level.var(ddof=1)) <= FLAT * noise**2 / BLOCK
    if not (flat and slope + CLEAR * error < FOLLOWS * follows):
        return None
    return SensorSaturation(
        torque=end, sign=f"it stays there while the load changes by {100 * change:.0f} %"
    )


def _blocks(place: NDArray[np.bool_]) -> list[slice]:
    """Blocks of `BLOCK` samples in a row that are all at this place."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], place.astype(int), [0]])))
    return [
        slice(at, at + BLOCK)
        for begin, end in zip(edges[::2], edges[1::2], strict=True)
        for at in range(begin, end - BLOCK + 1, BLOCK)
    ]


def _noise_scaled_differences(values: Array) -> Array:
    """Differences of white noise's own size, NaN where there is none, shape (n,)."""
    rough, at = np.full(values.size, np.nan), ORDER // 2
    rough[at : values.size - at] = np.diff(values, ORDER) / sqrt(comb(2 * ORDER, ORDER))
    return rough


def _noise_correlation(one: Array, other: Array) -> float:
    """Correlation of two noises [1], whose square is the share of power that one explains; 0 of none."""
    return float(one @ other) / max(sqrt(float(one @ one) * float(other @ other)), 1e-300)


def _noise_std(rough: Array) -> float:
    """Standard deviation of noise by the median; NaN counts for nothing."""
    return float(np.nanmedian(np.abs(rough))) / 0.6745
