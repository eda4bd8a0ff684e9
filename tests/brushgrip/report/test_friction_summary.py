"""Friction in tables: training and held-out recordings, the last usable sample, the load."""

from dataclasses import replace

import numpy as np
import pytest

from brushgrip.report.friction_summary import (
    last_usable_friction_text,
    load_trend_in_words,
    note_on_highest_loads,
    usable_span_text,
)
from brushgrip.report.tables import friction_by_recording, settling_and_coverage_table
from observers import Status
from symbolic import Model, effects_named
from tests.brushgrip.factories import TRACKS, make_diagnosis, make_outcome, make_track


def test_training_and_held_out_recordings_are_reported_apart() -> None:
    before = make_outcome("c", "d").to_dict()["before"]

    assert before["mean"]["settling"] == 4.25
    assert before["training"]["mean"]["settling"] == 1.5
    assert before["holdout"]["mean"]["settling"] == 7.0
    assert before["holdout"]["mean"]["reference_coverage"] == pytest.approx(0.7)
    table = settling_and_coverage_table(make_outcome("c", "d"), make_diagnosis())
    assert table.headings == ["figure", "validation", "training", "in plain words"]
    assert table.rows[0][:3] == ("time to settle", "7.0 s → 1.0 s", "1.5 s → 1.0 s")


def test_without_held_out_recordings_all_are_training() -> None:
    assert "holdout" not in make_outcome().to_dict()["before"]
    table = settling_and_coverage_table(make_outcome(), make_diagnosis())
    assert table.headings == ["figure", "training", "in plain words"]


def test_friction_is_that_of_the_last_usable_sample() -> None:
    judged = make_outcome("c", tracks=TRACKS, grounds={"ice": ("a", "b", "c", "d")})
    diagnosis = make_diagnosis(("a", "b", "d"), ("c",))
    rows = {name: cells for name, *cells in friction_by_recording(judged, diagnosis).rows}
    load = f"{np.median(diagnosis.series[0].F_N):.0f}"

    assert rows["a"] == ["ice", load, "1.20 ± 0.10", "from 5.0 s to the end"]
    assert rows["b"] == [
        "ice", load, "1.10 ± 0.10",
        "from 5.0 s to 7.0 of 10.0 s; then the model does not explain the torque",
    ]  # fmt: skip
    assert rows["c"] == ["ice", load, "–", "never: it has not slid enough to tell"]
    assert rows["d"][3] == "never: the deviation of mu is too large to act on"
    slid = replace(TRACKS[2], inconsistent=np.arange(11) > 7)
    assert usable_span_text(slid) == "never: the model does not explain the torque"
    hardly = replace(slid, turn=np.where(slid.inconsistent, 0.01, 1.0))
    assert usable_span_text(hardly) == "never: it has not slid enough to tell"
    suspect = replace(slid, last_status=Status.SUSPECT | Status.ACQUIRING)
    assert usable_span_text(suspect) == "never: an input looks wrong"
    moved = replace(TRACKS[1], changes=np.array([7.5]))
    assert (moved.last_usable, last_usable_friction_text(moved)) == (None, "–")
    assert usable_span_text(moved).startswith(
        "for 3.0 s only, but not since a new ground was noticed at 7.5 s: "
    )
    document = judged.to_dict()["after"]["recordings"]
    assert (document["b"]["last_usable"], document["b"]["usable_mu_eff"]) == (7.0, 1.1)
    assert document["c"]["usable_mu_eff"] is None


def test_friction_that_goes_with_the_load_is_told_where_chance_hardly_orders_it_so() -> None:
    names = tuple("abcde")
    diagnosis = make_diagnosis(names, ())
    loads = [replace(one, F_N=one.F_N + 10 * i) for i, one in enumerate(diagnosis.series)]
    diagnosis = replace(diagnosis, series=tuple(loads))
    values = {name: 1.0 + 0.1 * i for i, name in enumerate(names)}

    def order(mu: dict[str, float], ground: str = "ice") -> str:
        tracks = tuple(make_track(n, value) for n, value in mu.items())
        return load_trend_in_words(make_outcome(tracks=tracks, grounds={ground: names}), diagnosis)

    assert order(values) == "", "of five, 1 of 60"
    both = {"ice": names, "snow": tuple("fghij")}
    tracks = [make_track(n, 2.0 - mu) for n, mu in values.items()]
    more = [replace(t, name=n) for t, n in zip(tracks, both["snow"], strict=True)]
    series = (*loads, *(replace(s, name=n) for s, n in zip(loads, both["snow"], strict=True)))
    outcome = make_outcome(tracks=(*tracks, *more), grounds=both)
    told = load_trend_in_words(outcome, replace(diagnosis, series=series))
    assert told.startswith(
        "On ice (1.00 at 400 N, 0.90 at 410 N, 0.80 at 420 N, 0.70 at 430 N, 0.60 at 440 N) and snow"
        " (1.00 at 400 N, 0.90 at 410 N, 0.80 at 420 N, 0.70 at 430 N, 0.60 at 440 N), recordings at"
        " higher load gave lower friction (by chance in 1 of 7200 cases);"
    )
    unnamed = replace(outcome, grounds={"": (*names, *both["snow"])})
    assert load_trend_in_words(unnamed, replace(diagnosis, series=series)) == ""


@pytest.mark.parametrize(
    ("names", "told"),
    [
        ("de", True),
        ("ed", True),
        ("ce", False),
        ("e", False),
        ("abcde", False),
        ("ex", False),
        ("", False),
    ],
)
def test_recordings_of_the_highest_loads_are_told_to_be_these(names: str, told: bool) -> None:
    diagnosis = make_diagnosis(tuple("abcde"), ())
    loads = tuple(replace(one, F_N=one.F_N + 10 * i) for i, one in enumerate(diagnosis.series))

    assert bool(note_on_highest_loads(replace(diagnosis, series=loads), names)) is told
    assert note_on_highest_loads(diagnosis, names) == "", "all alike"


def test_an_order_of_very_many_recordings_has_a_chance_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("brushgrip.report.friction_summary.kendall_load_test", lambda _: (0.0, False))
    assert "by chance in 1 of 1000000 cases" in load_trend_in_words(make_outcome(), make_diagnosis())


def test_the_table_says_by_what_friction_is_told() -> None:
    diagnosis, outcome = make_diagnosis(("a", "b"), ()), make_outcome(tracks=TRACKS[:2])
    car, inclined = replace(diagnosis, of_car=True), replace(outcome, inclination=0.3)
    for one, friction, by in (
        (diagnosis, outcome, "model found"),
        (car, outcome, "vehicle as declared"),
        (car, inclined, "model found"),
    ):
        assert f" of each recording by the {by}, ± 95 %" in friction_by_recording(friction, one).caption


def test_figures_of_friction_that_changes_meanwhile_are_told_to_be_no_failure() -> None:
    diagnosis, outcome = make_diagnosis(), make_outcome("c")
    assert "time or travel" not in settling_and_coverage_table(outcome, diagnosis).caption
    drifting = replace(diagnosis, model=Model(effects=effects_named(["friction_drift"])))
    assert settling_and_coverage_table(outcome, drifting).caption.endswith(
        "the figures after the arrow contain that change, and the fitted value is that of the end"
    )
