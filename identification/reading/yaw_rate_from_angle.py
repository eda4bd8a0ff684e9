"""The yaw rate: from a quantised angle, and whether a measured one is the derivative of the angle."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.reading.checked_sample_table import Table
from identification.reading.signal_map import corrected_map_text
from identification.reading.units import UNITS, require_factor
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.signal_plausibility_limits import MIN_SIGN_TRAVEL

SMOOTHING_TIME = 0.11
"""Length of the smoothing window [s]: long against the encoder's steps, short against a turn."""

_MIN_SAMPLES = 5
_FAR_WEIGHT = 1e-6
_BLOCK = 1 << 16


def smoothed_rate(t: Array, psi: Array) -> Array:
    """Slope at every sample of the parabola fitted to its neighbours, by least squares.

    The filter of Savitzky and Golay (1964), in the samples' own times, so that sampling need not be
    uniform. The first and the last samples share the first and the last full window. Not causal.

    Args:
        t: increasing times [s], shape (n,), n >= 3.
        psi: angles [rad], shape (n,), without NaN.

    Returns:
        d psi/dt [rad/s], shape (n,).
    """
    per_window = 2 * int(SMOOTHING_TIME / (2 * float(np.median(np.diff(t))))) + 1
    width = min(max(per_window, _MIN_SAMPLES), t.size)
    first = np.clip(np.arange(t.size) - width // 2, 0, t.size - width)
    rows = max(1, _BLOCK // width)
    blocks = [
        _slopes(t, psi, np.arange(start, min(start + rows, t.size)), first, width)
        for start in range(0, t.size, rows)
    ]
    return np.concatenate(blocks)


def _slopes(t: Array, psi: Array, at: NDArray[np.intp], first: NDArray[np.intp], width: int) -> Array:
    near = first[at, None] + np.arange(width)
    distance = t[near] - t[at, None]
    reach = np.abs(distance).max(axis=1, keepdims=True)
    u = distance / reach
    # Beyond a pause of the clock samples only keep the fit determined, they do not shape it.
    weights = np.where(np.abs(distance) <= 1.01 * SMOOTHING_TIME, 1.0, _FAR_WEIGHT)
    weighted = np.stack([weights * u**power for power in range(3)])
    normal = np.stack([(weighted * u**power).sum(axis=2) for power in range(3)])
    right = (weighted * (psi[near] - psi[at, None])).sum(axis=2)
    fits = np.linalg.solve(normal.transpose(2, 0, 1), right.T[..., None])
    return np.asarray(fits[:, 1, 0] / reach[:, 0])


MAX_RATE_SCALE = 1.25
"""Largest ratio, either way round, of a measured rate to the derivative of the angle [1]."""
MIN_CORRELATION = 0.8
"""Correlation with that derivative below which noise or delay rule, and the ratio says nothing [1]."""


def require_rate_matches_angle(table: Table, psi: Array, psi_dot: Array) -> None:
    """Refuse a measured rate [rad/s] of another unit or sign than the derivative of the angle [rad].

    The rate is integrated and differentiated as the angle is, so that smoothing changes both alike.
    Where both have noise, the ratio lies between the two regressions of one on the other.
    """
    t = table.columns["t"][-psi.size :]
    middle = (psi_dot[1:] + psi_dot[:-1]) / 2
    turned = np.append(0.0, np.cumsum(middle * np.diff(t)))
    both = np.stack([smoothed_rate(t, psi), smoothed_rate(t, turned)])
    derivative, measured = both - both.mean(axis=1, keepdims=True)
    sizes = float(np.linalg.norm(derivative)), float(np.linalg.norm(measured))
    if np.abs(np.diff(psi)).sum() < MIN_SIGN_TRAVEL or min(sizes) == 0:
        return
    correlation, ratio = float(derivative @ measured) / (sizes[0] * sizes[1]), sizes[1] / sizes[0]
    if abs(correlation) < MIN_CORRELATION or (
        correlation / MAX_RATE_SCALE < ratio < MAX_RATE_SCALE / correlation
    ):
        return
    scale = float(np.copysign(ratio, correlation))
    raise InvalidInputError(
        f"{table.path}: psi_dot is {scale:.3g} times the derivative of psi, expected"
        f" {1 / MAX_RATE_SCALE:g} to {MAX_RATE_SCALE:g}; {_rate_correction_text(table, scale)}"
    )


def _rate_correction_text(table: Table, scale: float) -> str:
    """The map under which the rate is the angle's derivative: by unit and sign, or else by a factor."""
    psi, rate = table.source("psi"), table.source("psi_dot")
    mended = replace(rate, factor=float(np.copysign(1.0, scale)) * rate.factor)
    changed = {"psi_dot": mended} if scale < 0 else {}
    for column, source, size in (("psi_dot", mended, 1 / abs(scale)), ("psi", psi, abs(scale))):
        now = require_factor(column, source.unit or "", source.channel)
        for unit, factor in UNITS[column].items():
            if 1 / MAX_RATE_SCALE < factor / now / size < MAX_RATE_SCALE:
                if factor != now:
                    changed[column] = replace(source, unit=unit.replace(" ", ""))
                return f"if unit or sign is another: {corrected_map_text(table.sources, changed)}"
    mended = replace(rate, factor=float(f"{rate.factor / scale:.3g}"))
    mend = corrected_map_text(table.sources, {"psi_dot": mended})
    return f"leave the rate out, it is not needed, or, if the angle is right: {mend}"
