"""The newest points in memory of a fixed size."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brushgrip.live.row_estimation import EstimatedSample
from observers import ESTIMATE
from symbolic.float_array_type import Array

MAX_RECORDED_COLUMNS = 8
"""Most columns of a recording, the time first."""
FIELDS = ("stretch", "done", "psi", "torque", *ESTIMATE)
"""Fields of a point behind what is recorded: number of the stretch, instant of the estimate on the clock
of `time.monotonic` [s], angle, torque, estimate."""
PLACES = {name: place for place, name in enumerate(FIELDS, start=MAX_RECORDED_COLUMNS)}


class EstimatePoints(NamedTuple):
    """Points in a row."""

    end: int  # Number of the next one.
    values: Array  # What is recorded, NaN up to `MAX_RECORDED_COLUMNS`, then `FIELDS`; a row a point.

    def values_of_field(self, name: str) -> Array:
        """A field, shape (n,)."""
        return self.values[:, PLACES[name]]

    @property
    def t(self) -> Array:
        """Times, shape (n,) [s]."""
        return self.values[:, 0]


class EstimateRing:
    """One thread appends, others read."""

    def __init__(self, capacity: int) -> None:
        """Allocate the memory for `capacity` points."""
        self._values = np.full((capacity, MAX_RECORDED_COLUMNS + len(FIELDS)), np.nan)
        self.end = 0

    def append(self, points: Sequence[EstimatedSample], stretch: int, done: float) -> None:
        """Add points of one stretch."""
        for point in points:
            nothing = [np.nan] * (MAX_RECORDED_COLUMNS - len(point.recorded))
            fields = (stretch, done, point.psi, point.torque, *point.estimate.numbers)
            self._values[self.end % len(self._values)] = (*point.recorded, *nothing, *fields)
            self.end += 1

    def since(self, begin: int, stretch: int | None = None) -> EstimatePoints:
        """Points from this number on that are still there, of one stretch where it is given."""
        end = self.end
        # Some room, so that none is written over while it is copied.
        begin = max(0, begin, end - len(self._values) * 9 // 10)
        values = self._values[np.arange(begin, end) % len(self._values)]
        if stretch is not None:
            values = values[values[:, PLACES["stretch"]] == stretch]
        return EstimatePoints(end, values)
