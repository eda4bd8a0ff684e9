"""A part of a recording, or fewer of its samples where it has more than a search can hold in memory."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.reading.checked_sample_table import MIN_SAMPLES
from identification.reading.recordings import Recording
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

TWISTED = 0.1
"""Share of a recording's largest torque from which its first sample is not at rest."""
_LOG = logging.getLogger(__name__)


def trimmed(recording: Recording, begin: float | None, end: float | None) -> Recording:
    """The samples between two times [s], None for an end; a part that begins twisted is warned of."""
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
    part = recording_at_samples(recording, kept)
    known = part.aligning_or_steering_torque[np.isfinite(part.aligning_or_steering_torque)]
    if not kept[0] and known.size and abs(known[0]) > TWISTED * np.abs(known).max():
        _LOG.warning(
            "brushgrip: %s: begins at %.6g s with a torque of %.3g N m: the patch is twisted there, and"
            " friction may be wrong until the wheel has slid to both sides; begin where it rests",
            part.name, part.t[0], known[0],
        )  # fmt: skip
    return part


def recording_at_samples(recording: Recording, kept: NDArray[np.bool_] | NDArray[np.int64]) -> Recording:
    """The recording at some of its samples, by a mask or by their indices in order."""
    arrays: dict[str, Any] = {
        field: value[kept] for field, value in vars(recording).items() if isinstance(value, np.ndarray)
    }
    if (car := recording.standstills) is not None:
        arrays["standstills"] = replace(car, stretch=car.stretch[kept])
    return replace(recording, **arrays)


MAX_SEARCH_SAMPLES = 500_000
"""Samples of all recordings of a search together; a fit of 20 parameters then takes 80 MB for each copy
of its Jacobian."""
MIN_REVERSAL = 1e-3
"""Turning back by this much is a reversal, not the encoder's noise [rad]."""


def thin_recordings(
    recordings: Sequence[Recording], most: int = MAX_SEARCH_SAMPLES
) -> tuple[list[Recording], str | None]:
    """The recordings, thinned alike to `most` samples together where they have more, and a note on that.

    Of each so many samples in a row one is kept, the first with a torque, and every sample at which
    the angle reverses, so that what the patch remembers stays as it was. Where reversals would take more
    than half of the samples, those of the smallest angle are left out. Nothing is averaged: the noise
    keeps its size.
    """
    total = sum(recording.t.size for recording in recordings)
    if total <= most:
        return list(recordings), None
    least, turns = MIN_REVERSAL, [_reversals(r.psi, MIN_REVERSAL) for r in recordings]
    while sum(t.size for t in turns) > most // 2:
        least *= 2
        turns = [_reversals(r.psi, least) for r in recordings]
    # Beside the samples in a row: reversals, and of each recording both ends and a row cut short.
    stride = -(-total // max(most - sum(t.size + 3 for t in turns), 1))
    shorter = [_thinned(r, stride, t) for r, t in zip(recordings, turns, strict=True)]
    seconds = float(np.median(np.diff(recordings[0].t)))
    size = "" if least == MIN_REVERSAL else f" of {least:.3g} rad or more"
    line = (
        f"the recordings have {total:,} samples, more than the {most:,} that a diagnosis takes: of every"
        f" {stride} in a row one is used, and every reversal{size}, so {1000 * stride * seconds:.3g} ms"
        f" apart instead of {1000 * seconds:.3g} ms"
    )
    return shorter, line


def _thinned(recording: Recording, stride: int, turns: NDArray[np.int64]) -> Recording:
    present = np.isfinite(recording.M_z)
    first = np.arange(0, recording.t.size, stride)
    # Where the first of a row has no torque, the next one with a torque, if it is in the same row.
    later = np.append(np.flatnonzero(present), recording.t.size)
    with_torque = later[np.searchsorted(later, first)]
    kept = np.where(with_torque < first + stride, with_torque, first)
    kept = np.union1d(np.minimum(kept, recording.t.size - 1), turns)
    return recording_at_samples(recording, np.union1d(kept, [0, recording.t.size - 1]))


def _reversals(psi: Array, least: float) -> NDArray[np.int64]:
    """Samples at which the angle is at its extreme between one reversal and the next."""
    # Only local extremes can be; they are few enough for a loop.
    slope = np.sign(np.diff(psi))
    turning = np.flatnonzero(slope)
    changes = turning[1:][slope[turning[1:]] != slope[turning[:-1]]]
    found: list[int] = []
    low = high = 0
    heading = 0
    for i in (*changes.tolist(), psi.size - 1):
        low, high = (i if psi[i] < psi[low] else low), (i if psi[i] > psi[high] else high)
        if heading >= 0 and psi[high] - psi[i] > least:
            found.append(high)
            heading, low = -1, i
        elif heading <= 0 and psi[i] - psi[low] > least:
            found.append(low)
            heading, high = 1, i
    return np.array(found, dtype=np.int64)
