"""Times of a source in order: late samples left out, gaps and clocks set anew told from wrong times."""

import time
from math import isfinite
from typing import NamedTuple

from brushgrip.live.mapped_columns import Row
from identification.reading.checked_sample_table import MIN_TIME_STEP

GAP = 2.0
"""After a longer pause the patch may have been turned unseen, and the observer begins anew [s]."""
LATE = 1.0
"""Largest delay of a late sample; an earlier time means that the clock was set anew [s]."""
MAX_TIME = 1e12
"""Largest magnitude of a time [s]."""
MAX_START_TIME = 1e6
"""Times that begin beyond it, as those since 1970, are counted from the first sample [s]."""


def clock_time() -> float:
    """The time of a sample that comes now [s], by a clock that goes on while the machine sleeps."""
    clock = getattr(time, "CLOCK_BOOTTIME", None)  # Linux alone has one
    return time.monotonic() if clock is None else time.clock_gettime(clock)


class TimedRow(NamedTuple):
    """A row with its time, and whether it begins a stretch without memory of what was before."""

    row: Row
    begins: bool


class TimestampFilter:
    """Puts times in order; counts samples that are left out as late, or for their time alone."""

    def __init__(self) -> None:
        """No sample has been seen."""
        self.late = self.wrong = 0
        self._last: float | None = None
        self._origin = 0.0
        self._jumped: Row | None = None

    def __call__(self, row: Row) -> list[TimedRow]:
        """The rows that may be used with one more; one beyond a gap waits for a second behind it."""
        t = row.get("t", float("nan"))
        if not (isfinite(t) and abs(t) < MAX_TIME):
            self.wrong += 1
            return []
        if self._last is None:
            return [self._first_row_of_stretch(row)]
        if MIN_TIME_STEP <= t - self._last <= GAP:
            self.wrong += self._jumped is not None
            self._jumped = None
            return [self._next_row_of_stretch(row)]
        if -LATE < t - self._last < MIN_TIME_STEP:
            self.late += 1
            return []
        jumped, self._jumped = self._jumped, row
        if jumped is not None and MIN_TIME_STEP <= t - jumped["t"] <= GAP:
            self._jumped = None
            return [self._first_row_of_stretch(jumped), self._next_row_of_stretch(row)]
        self.wrong += jumped is not None
        return []

    def _first_row_of_stretch(self, row: Row) -> TimedRow:
        self._origin = row["t"] if abs(row["t"]) > MAX_START_TIME else 0.0
        return TimedRow(self._next_row_of_stretch(row).row, True)

    def _next_row_of_stretch(self, row: Row) -> TimedRow:
        self._last = row["t"]
        return TimedRow({**row, "t": row["t"] - self._origin}, False)
