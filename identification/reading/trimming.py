"""A part of a recording."""

import logging
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.reading.recordings import Recording
from identification.reading.table import MIN_SAMPLES
from symbolic import InvalidInputError

TWISTED = 0.1
"""Share of a recording's largest torque from which its first sample is not at rest."""
_LOG = logging.getLogger(__name__)


def trimmed(recording: Recording, begin: float | None, end: float | None) -> Recording:
    """The samples of a recording from one time to another; a part that begins twisted is warned of.

    Args:
        recording: the whole.
        begin: first time as the recording counts it [s]; None for its first.
        end: last time [s]; None for its last.
    """
    t = recording.t
    low, high = (t[0] if begin is None else begin), (t[-1] if end is None else end)
    kept = (t >= low) & (t <= high)
    count = int(np.count_nonzero(kept))
    if count < MIN_SAMPLES:
        raise InvalidInputError(
            f"{recording.name}: {count} sample{'s' * (count != 1)} from {low:g} to {high:g} s, at least"
            f" {MIN_SAMPLES} needed; it has times from {t[0]:g} to {t[-1]:g} s"
        )
    if count == t.size:
        return recording
    part = at_samples(recording, kept)
    if not kept[0]:
        _warn_of_twist(part)
    return part


def at_samples(recording: Recording, kept: NDArray[np.bool_] | NDArray[np.int64]) -> Recording:
    """The recording at some of its samples, by a mask or by their indices in order."""
    arrays: dict[str, Any] = {
        field: value[kept] for field, value in vars(recording).items() if isinstance(value, np.ndarray)
    }
    if (car := recording.standstills) is not None:
        arrays["standstills"] = replace(car, stretch=car.stretch[kept])
    return replace(recording, **arrays)


def _warn_of_twist(part: Recording) -> None:
    torque = part.M if part.M is not None and not np.isfinite(part.M_z).any() else part.M_z
    known = torque[np.isfinite(torque)]
    if known.size and abs(known[0]) > TWISTED * np.abs(known).max():
        _LOG.warning(
            "brushgrip: %s: begins at %.6g s with a torque of %.3g N m: the patch is twisted there, and"
            " friction may be wrong until the wheel has slid to both sides; begin where it rests",
            part.name, part.t[0], known[0],
        )  # fmt: skip
