"""Rows on the disk."""

from typing import Any

import pytest

from brushgrip.running.row_file import RowFile
from identification.selection import trial_runner
from identification.selection.trial_runner import as_completed, run_at_once


def test_rows_come_back_in_order_with_a_remark_on_those_that_end_early() -> None:
    rows = RowFile(4)
    given: list[dict[str, Any]] = [
        {"recording": name, "duration": seconds, "remark": "it lies"}
        for name, seconds in (("a", 14.0), ("b", 0.59), ("c", ""), ("d", 14.0))
    ]
    for number in (2, 0, 3, 1):
        rows.put(number, given[number])
    read = [*rows]

    assert len(rows) == 4
    assert [read[i] for i in (0, 2, 3)] == [given[i] for i in (0, 2, 3)]
    assert read[1]["remark"] == "it lies | ends early, after 0.59 s: half of all last 14 s or more"


def test_no_more_is_begun_than_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_runner, "_PENDING", 3)
    begun: list[int] = []
    futures = (run_at_once(lambda i=i: begun.append(i) or i) for i in range(10))
    taken = set()
    for future in as_completed(futures):
        assert len(begun) <= len(taken) + 3
        taken.add(future.result())

    assert taken == set(range(10))
