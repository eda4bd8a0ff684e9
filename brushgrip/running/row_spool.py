"""The rows of a summary on the disk, so that memory does not grow with their number."""

import json
from collections.abc import Mapping, Sequence
from functools import cached_property
from math import nan
from os import SEEK_END
from tempfile import TemporaryFile, gettempdir
from typing import Any
from weakref import finalize

import numpy as np

from brushgrip.wording.formatting import is_number
from brushgrip.wording.recording_remarks import (
    row_with_early_end_remark,
    row_with_map_for_it_alone,
    usual_duration,
)

Row = Mapping[str, str | int | float]


class RowSpool(Sequence[Row]):
    """Rows in a temporary file, written as they come, in any order, and read when all are there.

    Those of recordings much shorter than most have a remark on that; a map that is proposed for one,
    where friction of others is known, is for that one. In memory are three numbers a row.
    """

    def __init__(self, count: int) -> None:
        """None of so many rows is there yet."""
        self._file = TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115
        finalize(self, self._file.close)
        self._places, self._durations = np.full(count, -1), np.full(count, nan)
        self._known = np.zeros(count, dtype=np.bool_)

    def __len__(self) -> int:
        """How many rows there will be."""
        return self._places.size

    def put(self, number: int, row: Row) -> None:
        """Write the row of this number."""
        self._places[number] = self._file.seek(0, SEEK_END)
        if is_number(row["duration"]):
            self._durations[number] = row["duration"]
        self._known[number] = is_number(row.get("mu_eff"))
        try:
            print(json.dumps(dict(row)), file=self._file, flush=True)
        except OSError as error:
            raise OSError(error.errno, error.strerror, gettempdir()) from None

    def __getitem__(self, number: Any) -> Any:
        """The row of this number, of no slice."""
        if self._places[number] < 0:
            raise LookupError(f"there is no row {number} yet")
        self._file.seek(self._places[number])
        row = json.loads(self._file.readline())
        if self._known.any() and not self._known[number]:
            row = row_with_map_for_it_alone(row)
        return row_with_early_end_remark(row, self._usual_duration)

    @cached_property
    def _usual_duration(self) -> float:
        return usual_duration(self._durations[np.isfinite(self._durations)])
