"""Rows on the disk."""

from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any

import pytest

from brushgrip.running.row_spool import RowSpool
from identification.selection import trial_runner
from identification.selection.trial_runner import as_completed


def test_rows_come_back_in_order_with_a_remark_on_those_that_end_early() -> None:
    durations = {"a": 14.0, "b": 0.59, "c": "", "d": 14.0, "e": 7.0, "f": 14.0}
    rows = RowSpool(len(durations))
    given: list[dict[str, Any]] = [
        {"recording": name, "duration": seconds, "remark": "it lies"}
        for name, seconds in durations.items()
    ]
    for number in (2, 0, 3, 5, 4, 1):
        rows.put(number, given[number])
    read = [*rows]

    assert len(rows) == len(read) == 6
    assert read[1].pop("remark") == "it lies | ends early, after 0.59 s: half of all last 14 s or more"
    given[1].pop("remark")
    assert read == given


def test_a_row_that_is_not_there_is_no_other_one() -> None:
    rows = RowSpool(2)
    rows.put(1, {"duration": 1.0, "recording": "b"})
    with pytest.raises(LookupError, match="there is no row 0 yet"):
        list(rows)
    rows.put(0, {"duration": 1.0, "recording": "a"})

    assert [row["recording"] for row in rows] == ["a", "b"]


def test_no_more_is_begun_than_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_runner, "_PENDING", 3)
    begun: list[Future[int]] = []

    def submitted() -> Iterator[Future[int]]:
        for _ in range(10):
            begun.append(Future())
            if len(begun) == 1:
                begun[0].set_result(0)
            yield begun[-1]

    taken = list[int]()
    for future in as_completed(submitted()):
        assert len(begun) <= len(taken) + 3
        taken.append(future.result())
        if len(taken) < 10:
            begun[len(taken)].set_result(len(taken))

    assert taken == [*range(10)]
