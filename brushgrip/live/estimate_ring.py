"""The newest points in memory of a fixed size."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brushgrip.live.row_estimation import Point
from observers import ESTIMATE
from symbolic.array_alias import Array

FIELDS = ("stretch", "done", "psi", "torque", *ESTIMATE)
"""Fields of a point beside what is recorded: number of the stretch, instant of the estimate on the clock
of `time.monotonic` [s], angle, torque, estimate."""
MAX_RECORDED_COLUMNS = 8
"""Most columns of a recording, the time first."""
PLACES = {name: place for place, name in enumerate(FIELDS)}


class RingPoints(NamedTuple):
    """Points in a row."""

    end: int  # Number of the next one.
    fields: Array  # Shape (n, fields).
    recorded: Array  # Shape (n, `MAX_RECORDED_COLUMNS`), NaN behind the columns of the recording.

    def of(self, name: str) -> Array:
        """A field, shape (n,)."""
        return self.fields[:, PLACES[name]]

    @property
    def t(self) -> Array:
        """Times, shape (n,) [s]."""
        return self.recorded[:, 0]


class EstimateRing:
    """One thread appends, others read."""

    def __init__(self, capacity: int) -> None:
        """Allocate the memory for `capacity` points."""
        self._fields = np.full((capacity, len(FIELDS)), np.nan)
        self._recorded = np.full((capacity, MAX_RECORDED_COLUMNS), np.nan)
        self.end = 0

    def append(self, points: Sequence[Point], stretch: int, done: float) -> None:
        """Add points of one stretch."""
        for point in points:
            at = self.end % len(self._fields)
            self._fields[at] = (stretch, done, point.psi, point.torque, *point.estimate.numbers)
            self._recorded[at, : len(point.recorded)] = point.recorded
            self._recorded[at, len(point.recorded) :] = np.nan
            self.end += 1

    def since(self, begin: int, stretch: int | None = None) -> RingPoints:
        """Points from this number on that are still there, of one stretch where it is given."""
        end = self.end
        # Some room, so that none is written over while it is copied.
        begin = max(0, begin, end - len(self._fields) * 9 // 10)
        places = np.arange(begin, end) % len(self._fields)
        fields, recorded = self._fields[places], self._recorded[places]
        if stretch is not None:
            own = fields[:, PLACES["stretch"]] == stretch
            fields, recorded = fields[own], recorded[own]
        return RingPoints(end, fields, recorded)
