"""Remarks on recordings, and what a table of many says of all."""

import math

from brushgrip.wording.recording_remarks import (
    OVER_LOAD,
    friction_lines_by_ground,
    recording_remark,
    remark_counts,
    row_with_early_end_remark,
    short_remarks,
    usual_duration,
)
from observers import Status
from tests.brushgrip.factories import rising


def test_remarks_in_a_table() -> None:
    few = rising(*[Status.USED] * 100, last=55)
    beside = recording_remark(few, "it lies: weigh it; later", "ice: measure")
    rows = [{"mu_eff": 0.1, "remark": beside}, {"mu_eff": math.nan, "remark": "not known: no"}] * 2

    assert beside == "usable in under 10 % | it lies: weigh it; later | ice: measure"
    assert short_remarks(beside) == ["usable in under 10 %", "it lies", "ice"]
    assert (
        remark_counts(rows)
        == "2 of 4: usable in under 10 %; 2 of 4: it lies; 2 of 4: ice; 2 of 4: not known: no"
    )
    assert recording_remark(rising(*[Status.USED] * 4), "", "") == ""
    unknown = recording_remark(rising(*[Status.USED] * 4, last=0), "it lies: weigh it; later", "")
    assert short_remarks(unknown) == ["not known: it lies: weigh it"]
    noted = recording_remark(rising(*[Status.USED] * 4, last=0), "it lies", "ice: measure")
    assert noted == "not known: it lies | ice: measure"


def test_friction_of_a_ground_says_that_each_is_at_its_own_load() -> None:
    rows = [
        {"ground": "ice", "mu_eff": mu, "mu_eff_std": 0.01, "remark": f"{OVER_LOAD}: mu_eff"}
        for mu in (0.1, 0.2, 0.15)
    ]
    assert friction_lines_by_ground(rows)[0].startswith("ice, each at its own load: mu_eff ")
    silent = [row | {"remark": ""} for row in rows]
    assert friction_lines_by_ground(silent)[0].startswith("ice: mu_eff ")


def test_few_recordings_with_a_remark_are_named_and_those_that_end_early() -> None:
    rows = [
        {"recording": f"b{i:02}", "duration": 14.0, "remark": "not known: no" * (i < 10)}
        for i in range(20)
    ]
    rows += [
        {"recording": "short", "duration": 0.59, "remark": "it lies"},
        {"recording": "shorter", "duration": 0.2, "remark": ""},
        {"recording": "broken", "duration": "", "remark": ""},
    ]
    told = [row_with_early_end_remark(row, usual_duration([14.0] * 20 + [0.59, 0.2])) for row in rows]
    remarks = {row["recording"]: row["remark"] for row in told}

    assert remarks["short"] == "it lies | ends early, after 0.59 s: half of all last 14 s or more"
    assert remarks["shorter"] == "ends early, after 0.2 s: half of all last 14 s or more"
    assert (remarks["b00"], remarks["b10"], remarks["broken"]) == ("not known: no", "", "")
    counts = remark_counts(told, named=True)
    ten = ", ".join(f"b{i:02}" for i in range(10))
    assert counts.startswith(f"10 of 23: not known: no ({ten}); 2 of 23: ends early (short, shorter); ")
    rows[10]["remark"] = "not known: no"
    assert remark_counts(rows, named=True).startswith("11 of 23: not known: no; 1 of")
    assert usual_duration([0.59, 0.2]) == 0, "of two lengths"
