"""Friction of a recording in a line: what is usable, how sure it is, and what is wrong with samples."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from brushgrip.running.summary_table import summary_row
from brushgrip.wording.friction_in_words import (
    LACKING,
    band_composition_text,
    estimates_summary,
    slippery_ground_note,
    unusable_samples_and_remedy,
    with_95_band,
)
from brushgrip.wording.recording_remarks import recording_remark, remark_counts
from identification import Recording
from observers import Estimates, Status
from observers.planning.uncertainty_budget import REST, SLOPE
from observers.quality.when_usable import last_usable
from symbolic import Rig
from tests.brushgrip.factories import rising


def row_of(seen: Estimates) -> dict[str, Any]:
    """The row of a recording in a table of many."""
    recording = SimpleNamespace(name="a", ground=None, standstills=None, rig=Rig(a=0.045, e=0.009))
    return summary_row(cast(Recording, recording), seen)


def summary(estimates: Estimates, *given: str, rates: str = "", of_car: bool = False) -> str:
    unusable = unusable_samples_and_remedy(estimates, *given, rates=rates, of_car=of_car)
    return estimates_summary(estimates, unusable, rates)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "mu_eff = 1.25 ± 0.08 (95 % band) at the end, usable from 0.02 s, in 50 % of 4 samples"),
        # The model's own mu is named where it differs.
        (
            {"off": -0.1},
            "mu_eff = 1.15 ± 0.08 (95 % band) at the end, usable from 0.02 s, in 50 % of 4 samples"
            " (mu = 1.25 in the model's own law, which compares with no other)",
        ),
        (
            {"last": 2},
            "mu_eff = 1.17 ± 0.08 (95 % band) at 0.02 s, last usable, usable from 0.02 s,"
            " in 25 % of 4 samples",
        ),
        (
            {"last": 0, "std": 0.3},
            "friction is not known, usable in 0 % of 4 samples; 2 samples not usable: the deviation of"
            " mu is 29 % of mu, too much to act on: turn further, and where that does not help, correct"
            " k or narrow its tolerance (brushgrip identify), or find what the model lacks (brushgrip"
            " diagnose)",
        ),
        (
            {"last": 0, "std": np.nan},
            "friction is not known, usable in 0 % of 4 samples; the observer states no deviation and"
            " checks nothing, so that friction is for comparison only: use ekf or mhe",
        ),
    ],
)
def test_friction_at_the_end(options: dict[str, Any], words: str) -> None:
    assert summary(rising(*[Status.USED] * 4, **options)) == words


@pytest.mark.parametrize(("after", "is_told"), [(30, True), (31, False)])
def test_friction_that_what_follows_contradicts_is_not_told(after: int, is_told: bool) -> None:
    seen = rising(*[Status.USED] * 10, *[Status.INCONSISTENT] * after)
    usable = replace(seen, usable=seen.status == 0)

    assert (last_usable(usable) == 9) == is_told == ("mu_eff = " in summary(usable))
    told = "friction is not known: what was usable up to 0.09 s does not explain the torque that follows"
    assert summary(usable).startswith(told) != is_told
    # Another ground since then makes it a fault of that ground.
    again = replace(usable, status=np.where(seen.t == 0, int(Status.RESET), seen.status))
    assert (last_usable(again) == 9) == is_told
    # A wheel at rest shows neither: samples while it stood count for nothing, whatever they say.
    usable, contradicted = [Status.USED] * 1000, [Status.INCONSISTENT] * 1000
    rested = rising(*usable, *seen.status.tolist(), *contradicted)
    turn = np.pad(seen.turn, 1000)
    assert (last_usable(replace(rested, usable=rested.status == 0, turn=turn)) == 1009) == is_told


def test_how_long_the_torque_is_not_explained_after_a_value_is_told() -> None:
    seen = rising(*[Status.USED] * 20, *[Status.INCONSISTENT] * 30)
    seen = replace(seen, usable=seen.status == 0)
    line = summary(seen)
    row = row_of(seen)
    short = rising(*[Status.USED] * 120, Status.INCONSISTENT)

    assert row["since_usable"] == pytest.approx(0.3)
    assert " at 0.19 s, last usable, then not explained for 0.3 s, usable from 0 s, in 40" in line
    assert "not explained for" not in summary(replace(short, usable=short.status == 0))


def test_a_torque_at_a_tenth_of_the_rate_is_counted_by_itself() -> None:
    seen = rising(*[Status.USED, *[Status.MISSING] * 9] * 40)
    slower = replace(seen, usable=seen.usable & (seen.status == 0))
    row = row_of(slower)

    assert (row["samples"], row["measured"], row["usable"], row["informed"]) == (400, 40, 0.5, 0.5)
    # Behind the last torque nothing can be usable.
    assert row["since_usable"] == 0
    assert "usable from 2 s, in 50 % of 40 samples with a torque" in summary(slower)
    off = replace(slower, status=np.where(slower.t < 1, int(Status.IMPLAUSIBLE | Status.MISSING), 0))
    row = row_of(off)
    assert (row["implausible"], row["wide"]) == (0.25, 1 / 3)


def test_a_new_ground_that_a_misfit_may_have_feigned() -> None:
    status = [Status.USED] * 2 + [Status.RESET] + [Status.INCONSISTENT] * 3
    doubted, sure = rising(*status, last=2), rising(*status[:3], *[Status.USED] * 3, last=1)
    doubted = replace(doubted, usable=doubted.t < 0.02)

    line = summary(doubted)
    assert "not known since 0.02 s: either the ground changed, or the model does not fit" in line
    assert "1 change of the ground or misfits of the model; " in line
    assert "1 change of the ground; " in summary(sure)


def changed_ground(*after: Status, known: bool = True) -> Estimates:
    """Usable from 1 s, not explained from 2 s, another ground from 2.15 s; then usable from 3 s."""
    parts = [Status.ACQUIRING] * 100 + [Status.USED] * 100 + [Status.INCONSISTENT] * 15
    parts += [Status.RESET | Status.INCONSISTENT] + [Status.ACQUIRING] * 84 + [Status.USED] * 100
    seen = rising(*parts, *after)
    usable = (seen.status == 0) & (known | (seen.t < 2.1))
    mu = np.where(seen.t < 2.15, 0.7, 0.15)
    return replace(seen, usable=usable, mu=mu, mu_eff=mu, mu_eff_std=np.full(mu.size, 0.02))


def test_the_time_belongs_to_the_value_and_what_was_before_a_change_is_told() -> None:
    line, before = summary(changed_ground()), "it was 0.70 ± 0.04 (usable from 1 s)"
    assert line == (
        "mu_eff = 0.15 ± 0.04 (95 % band) at the end, usable from 3 s, in 50 % of 400 samples;"
        f" before the ground changed at 2.15 s {before}"
    )
    lost = summary(changed_ground(known=False))
    assert lost.startswith(
        f"friction is not known since a new ground was noticed at 2.15 s; before, {before}, usable in 25"
    )
    assert "; 16 samples not usable: the ground has changed, mu is being learnt anew" in lost
    row = row_of(changed_ground())
    assert [row[name] for name in ("first_usable", "steady_from", "changes")] == [1.0, 3.0, 1]
    remark = recording_remark(changed_ground(), "", "")
    assert remark == f"the ground changed at 2.15 s: before, {before}"
    assert recording_remark(changed_ground(), "", "", of_way=True) == "the ground changed at 2.15 s"
    rows = [{"remark": "the ground changed at 2.15 s: before"}, {"remark": "the ground changed at 7 s"}]
    assert remark_counts(rows) == "2 of 2: the ground changed"


def test_what_does_not_end_in_a_change_is_a_misfit() -> None:
    misfit = [*[Status.INCONSISTENT] * 60, *[Status.USED] * 100]
    line = summary(changed_ground(*misfit))
    assert (
        "at the end, usable steadily from 4.6 s, in 54 % of 560 samples, 1 change of the ground" in line
    )
    assert " or misfits of the model; before the ground changed or the model ceased to fit at" in line
    assert "; 60 samples not usable: model and stated error do not" in line
    short = summary(changed_ground(*misfit[20:]))
    assert "usable from 3 s" in short, "a controller keeps a value for so long"
    # What lasts too long before a change is none of it.
    late = rising(*[Status.USED] * 10, *[Status.INCONSISTENT] * 400, Status.RESET, *[Status.USED] * 100)
    late = replace(late, usable=late.status == 0)
    assert "401 samples" not in summary(late)
    assert "; 400 samples not usable: model and stated error" in summary(late)


def test_ice_asks_for_dry_friction_and_noise_of_the_sensor() -> None:
    rig = Rig(a=0.045, e=0.009)
    both = slippery_ground_note(0.1, rig)
    assert both.startswith("below 0.15, dry friction and noise of the sensor not declared: ")
    assert both.endswith("[sensor] dry_friction = ... and noise = ... N m")
    noise = slippery_ground_note(0.1, replace(rig, dry_friction=0.0))
    assert noise.startswith("below 0.15, noise of the sensor not declared: the noise assumed may hide ")
    assert "dry_friction" not in noise
    known = replace(rig, dry_friction=0.0, noise=0.1)
    assert slippery_ground_note(0.1, known) == slippery_ground_note(0.3, rig) == ""


def test_when_an_input_looked_wrong_is_told_beside_the_value() -> None:
    """Flagged from 0.02 to 0.05 s of 0.2 s; usable from 0.1 s on, or from 0 to 0.01 s."""
    status = [Status.USED] * 2 + [Status.SUSPECT] * 4 + [Status.USED] * 14
    seen = rising(*status)
    when = "an input looks wrong from 0.02 to 0.05 s, {} the value told, by its unit, its sign"
    assert f"4 samples not usable: {when.format('before')}" in summary(seen)
    early = replace(seen, usable=seen.t < 0.015)
    assert when.format("after") in unusable_samples_and_remedy(early)[1]
    mended = rising(*[Status.SUSPECT] * 4, *[Status.INCONSISTENT] * 2, *[Status.USED] * 14)
    assert unusable_samples_and_remedy(mended, "declare it") == (
        4, "an input looks wrong from 0 to 0.03 s, before the value told: declare it",
    )  # fmt: skip
    around = replace(mended, usable=mended.t < 0.025)
    assert "before and after the value" in unusable_samples_and_remedy(around)[1]
    remark = unusable_samples_and_remedy(seen)[1]
    rows = [{"remark": remark}, {"remark": remark.replace("0.05", "7.5")}]
    assert remark_counts(rows).startswith("2 of 2: an input looks wrong, before the value told, by")


def test_noise_goes_first_and_a_slower_torque_is_no_fault() -> None:
    alien = rising(*[Status.INCONSISTENT] * 2, *[Status.USED] * 2)
    slower = rising(*[Status.USED, Status.MISSING] * 2, last=2)

    assert "does not explain the torque: declare it" in summary(alien, "declare it")
    assert "raise error of the tuning to 0.1 (--tune error=0.1): with more" in summary(alien)
    of_car = summary(alien, of_car=True)
    assert "too small: the ground may just have changed, which is then learnt anew by itself" in of_car
    assert (
        " and where it lasts, find what the model lacks (brushgrip diagnose --vehicle), check" in of_car
    )
    slow = rising(*[Status.ACQUIRING] * 4, last=0)
    assert summary(slow).endswith(", then k")
    assert summary(slow, of_car=True).endswith(", then stiffness")
    assert of_car.endswith("or declare a greater force_error or force_noise")
    assert "0.1" not in of_car.partition("not usable")[2]
    assert "; 2 samples not usable: no measurement" in summary(slower)
    assert summary(slower, rates="100 and 200 Hz").endswith(
        "usable from 0.02 s, in 50 % of 2 samples with a torque; 100 and 200 Hz"
    )


def test_a_narrow_band_has_a_digit_more() -> None:
    assert with_95_band(0.0512, 0.004) == "0.051 ± 0.008"
    assert with_95_band(1.234, 0.05) == "1.23 ± 0.10"
    assert with_95_band(math.nan, 0.05) == "–"
    car = band_composition_text({SLOPE: 0.006, "axle load": 0.004})
    assert car.endswith("(brushgrip identify --lock-to-lock), or check the force's scale")
    assert band_composition_text({REST: 0.006, "axle load": 0.004}).endswith(
        "(brushgrip diagnose --vehicle)"
    )
    line = band_composition_text({REST: 0.006, SLOPE: 0.004})
    assert line.startswith("the band ± 0.007 is made of (the squares add up): ")
    assert f"{REST} 0.006, {SLOPE} 0.004;" in line


@pytest.mark.parametrize(
    ("status", "words"),
    [
        ([Status.MISSING], "1 sample not usable: no measurement"),
        (
            [Status.MISSING | Status.HELD, Status.HELD],
            "2 samples not usable: angle, load or steering torque",
        ),
        (
            [Status.REJECTED] * 2 + [Status.MISSING] * 3,
            "2 samples rejected; 3 samples not usable: no measurement",
        ),
        (
            [Status.SUSPECT] * 2 + [Status.INCONSISTENT] + [Status.HELD] * 4,
            "; 2 samples not usable: an input looks",
        ),
        (
            [Status.SUSPECT] + [Status.INCONSISTENT] * 2 + [Status.HELD] * 4,
            "; 2 samples not usable: model and",
        ),
        (
            [Status.MISSING] + [Status.RESET] * 2 + [Status.REJECTED],
            "1 sample rejected, 2 changes of the ground; 1 sample not usable: no measurement",
        ),
    ],
)
def test_faults_are_counted_and_the_most_frequent_gets_its_remedy(
    status: list[Status], words: str
) -> None:
    line = summary(rising(*status, *[Status.USED] * 4))

    assert words in line
    assert "\n" not in line


@pytest.mark.parametrize("flag", [Status.SUSPECT, Status.BOUND])
def test_what_a_sound_wheel_meets_in_its_first_turns_is_not_told(flag: Status) -> None:
    sound = [Status.ACQUIRING] * 50 + [flag] * 2 + [Status.USED] * 348

    assert "sample not" not in summary(rising(*sound)).replace("samples", "sample")
    assert "5 samples not usable: " in summary(rising(*[flag] * 5, *sound[5:50], *sound[52:]))


def test_a_suspicion_goes_before_an_acquisition_that_lasts_as_long() -> None:
    doubted = rising(*[Status.ACQUIRING | Status.SUSPECT] * 3, Status.ACQUIRING, last=-1)

    assert unusable_samples_and_remedy(doubted) == (3, Status.SUSPECT.remedy)
    assert unusable_samples_and_remedy(doubted, cause="in degrees") == (3, "in degrees")
    both = rising(*[Status.SUSPECT] * 3, Status.INCONSISTENT, last=-1)
    assert unusable_samples_and_remedy(both, LACKING) == (3, Status.SUSPECT.remedy)
    assert unusable_samples_and_remedy(both, "declare it") == (3, "an input looks wrong: declare it")
    assert unusable_samples_and_remedy(rising(*[Status.ACQUIRING] * 4, last=-1)) == (
        4,
        Status.ACQUIRING.remedy,
    )
