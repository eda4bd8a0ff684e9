import json
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from brushgrip.estimation.friction_by_direction import friction_of_directions
from brushgrip.running.batch import summary_row
from brushgrip.wording.diagnosis_in_words import experiment_in_words, headline, taken_from_model
from brushgrip.wording.formatting import (
    candidate_reason,
    csv_text,
    json_text,
    listed,
    percent,
    residual_structure,
    sentence,
    torque_value,
    value_with_std,
    with_degrees,
    worse_recordings,
)
from brushgrip.wording.friction_in_words import (
    LACKING,
    band_parts,
    estimates_summary,
    last_usable,
    undeclared_sensor_note,
    unusable_samples_and_remedy,
    with_95_band,
)
from brushgrip.wording.recording_remarks import (
    OVER_LOAD,
    friction_of_grounds,
    recording_remark,
    remark_counts,
    remark_heads,
    with_early_ends,
)
from identification import Candidate, FoundModel, ParameterEstimate, Recording
from observers import DirectionalFriction, Estimates, Status
from observers.planning.uncertainty_budget import REST, SLOPE
from symbolic import Model, ModelBasis, ModelError, Rig, effects_named
from tests.brushgrip.factories import experiment, make_diagnosis, make_estimates


@pytest.mark.parametrize(
    ("value", "std", "unit", "text"),
    [
        (391.234, 4.2, "N m/rad", "391.2 ± 4.2 N m/rad"),
        (391.234, 42.0, "N m/rad", "391 ± 42 N m/rad"),
        (391.234, 420.0, "N m/rad", "391 ± 420 N m/rad"),
        (0.0403, 0.00017, "1", "0.04030 ± 0.00017"),
        (-0.25, 0.1, "N m", "−0.25 ± 0.10 N m"),
        (2.4312e6, 1.2e4, "N/m^2", "(2.431 ± 0.012)·10⁶ N/m²"),
        (2.5e-5, 1e-6, "s", "(2.50 ± 0.10)·10⁻⁵ s"),
        (0.0, 0.02, "rad", "0.000 ± 0.020 rad"),
        (3.0, 1.5e6, "m/s", "not determined"),
        (1.2345, None, "1", "1.234"),
        (2.4e6, None, "N/m^2", "2.4·10⁶ N/m²"),
        (1.5, math.inf, "s", "1.5 s"),
        (0.0, None, "s", "0 s"),
        (math.inf, None, "N m/rad", "∞ N m/rad"),
        (math.nan, None, "1", "–"),
    ],
)
def test_quantity(value: float, std: float | None, unit: str, text: str) -> None:
    assert value_with_std(ParameterEstimate(value=value, std=std, unit=unit)) == text


def test_figures_sentences_and_lists() -> None:
    assert [percent(share) for share in (0.04371, None, math.nan)] == ["4.37 %", "–", "–"]
    assert [torque_value(value) for value in (0.35345, 1.0, None)] == ["0.353", "1.00", "–"]
    assert sentence("sensor_delay: delay is at the end") == "Sensor delay: delay is at the end."
    assert sentence("fem4_ident: k is at the end.") == "Fem4_ident: k is at the end."
    assert [listed([*words], "or") for words in ("", "a", "ab", "abc")] == [
        "",
        "a",
        "a or b",
        "a, b or c",
    ]


FOUND = (
    "The assumed model lacks compliance and contact shape (carcass torsion) and sensor and steering"
    " (torque offset); 1.20 % of range stay unexplained: validation error 4.30 % (k refitted) → 2.37 %"
)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, FOUND),
        ({"holdout": ()}, "left-out error 4.05 %"),
        ({"training": ("train_a",), "holdout": ()}, "training error 4.00 %"),
        ({"found": False, "unexplained": False}, "lacks nothing"),
        (
            {"found": False},
            "No effect alone explains enough of what the assumed model lacks: validation error 4.30 %",
        ),
    ],
)
def test_headline(options: dict[str, Any], words: str) -> None:
    assert words in headline(make_diagnosis(**options))


def test_residual_structure_and_recordings_that_got_worse() -> None:
    assert "The residual has structure" in residual_structure(make_diagnosis(unexplained=True))
    assert "no structure left" in residual_structure(make_diagnosis(unexplained=False))
    diagnosis = make_diagnosis(worse=("held_d",))
    assert worse_recordings(diagnosis) == ["held_d"]


@pytest.mark.parametrize(
    ("name", "bic", "reason"),
    [
        ("carcass_torsion", -400.0, "added, no. 1"),
        ("torque_offset", 0.3, "added, no. 2; useless alone, ΔBIC −55.1 beside the others"),
        ("patch_width", -300.0, "indistinguishable from carcass torsion"),
        ("iwan", -300.0, "no clear gain beside what was added"),
        ("pressure_shape", -300.0, "the same mechanism as carcass torsion; no clear gain beside it"),
        ("stribeck", 4.0, "alone not worth its parameters"),
    ],
)
def test_every_candidate_has_the_reason_of_its_outcome(name: str, bic: float, reason: str) -> None:
    candidate = Candidate(name=name, summary="", holdout_nrmse=0.03, delta_bic=bic)
    assert candidate_reason(make_diagnosis(), candidate) == reason


def estimates(
    *status: Status, std: float = 0.02, off: float = 0.0, last: int | None = None
) -> Estimates:
    """Friction that rises from 1 to 1.25; usable in the second half, to the sample `last`."""
    size, places, mu = len(status), np.arange(len(status)), np.linspace(1.0, 1.25, len(status))
    usable = (places >= size / 2) & (places <= (size if last is None else last))
    return make_estimates(
        status, mu=mu, mu_eff=mu + off, mu_std=np.full(size, std), mu_eff_std=np.full(size, 2 * std),
        M_z_predicted=np.zeros(size), informed=places >= size / 2, usable=usable,
    )  # fmt: skip


def row_of(seen: Estimates) -> dict[str, Any]:
    """The row of a recording in a table of many."""
    return summary_row(cast(Recording, SimpleNamespace(name="a", ground=None)), seen)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "mu_eff = 1.25 ± 0.08 (95 % band) at the end, usable in 50 % of 4 samples, from 0.02 s"),
        # The model's own mu is named where it differs.
        (
            {"off": -0.1},
            "mu_eff = 1.15 ± 0.08 (95 % band) at the end, usable in 50 % of 4 samples, from 0.02 s"
            " (mu = 1.25 in the model's own law, which compares with no other)",
        ),
        (
            {"last": 2},
            "mu_eff = 1.17 ± 0.08 (95 % band) at 0.02 s, last usable, usable in 25 % of 4 samples,"
            " from 0.02 s",
        ),
        (
            {"last": 0, "std": 0.3},
            "friction is not known, usable in 0 % of 4 samples; 2 samples not usable: the deviation of"
            " mu is 29 % of mu, too much to act on: turn further, and where that does not help, correct"
            " k (stiffness of a vehicle) or narrow its tolerance (brushgrip identify), or find what the"
            " model lacks (brushgrip diagnose)",
        ),
        (
            {"last": 0, "std": np.nan},
            "friction is not known, usable in 0 % of 4 samples; the observer states no deviation and"
            " checks nothing, so that friction is for comparison only: use ekf or mhe",
        ),
    ],
)
def test_friction_at_the_end(options: dict[str, Any], words: str) -> None:
    assert estimates_summary(estimates(*[Status.USED] * 4, **options)) == words


@pytest.mark.parametrize(("after", "is_told"), [(30, True), (31, False)])
def test_friction_that_what_follows_contradicts_is_not_told(after: int, is_told: bool) -> None:
    seen = estimates(*[Status.USED] * 10, *[Status.INCONSISTENT] * after)
    usable = replace(seen, usable=seen.status == 0)

    assert (last_usable(usable) == 9) == is_told == ("mu_eff = " in estimates_summary(usable))
    told = "friction is not known: what was usable up to 0.09 s does not explain the torque that follows"
    assert estimates_summary(usable).startswith(told) != is_told
    # Another ground since then makes it a fault of that ground.
    again = replace(usable, status=np.where(seen.t == 0, int(Status.RESET), seen.status))
    assert (last_usable(again) == 9) == is_told
    # A wheel at rest shows neither: samples while it stood count for nothing, whatever they say.
    usable, contradicted = [Status.USED] * 1000, [Status.INCONSISTENT] * 1000
    rested = estimates(*usable, *seen.status.tolist(), *contradicted)
    turn = np.pad(seen.turn, 1000)
    assert (last_usable(replace(rested, usable=rested.status == 0, turn=turn)) == 1009) == is_told


def test_friction_of_each_direction_is_of_the_last_ground() -> None:
    seen = estimates(*[Status.USED] * 20)
    seen = replace(seen, M_z_predicted=np.where(np.arange(20) < 15, 1.0, -1.0))
    steps, aligning = np.where(np.arange(20) < 15, -0.01, 0.01), DirectionalFriction()
    psi, M_z = np.cumsum(steps), seen.M_z_predicted
    row, line = friction_of_directions(seen, psi, M_z, aligning)

    assert line == (
        "mu_eff by direction, last usable: 1.25 ± 0.08 turning to positive psi, at 0.19 s;"
        " 1.18 ± 0.08 turning to negative psi, at 0.14 s"
    )
    assert row["mu_eff_negative"] == pytest.approx(1.184, abs=1e-3)
    assert (row["direction"], row["weaker"]) == ("positive", pytest.approx(1 - 1.184 / 1.25, abs=2e-3))
    assert "(95 % band) turning to positive psi at the end" in estimates_summary(seen, way="positive")
    # Exchanged where the angle turns back, mu is not of the direction whose torque is not let off yet.
    later = replace(seen, M_z_predicted=np.where(np.arange(20) < 17, 1.0, -1.0))
    _, line = friction_of_directions(later, psi, M_z, replace(aligning, at_reversal=True))
    assert line.endswith("turning to negative psi, at 0.14 s")
    # What was usable on the ground before says nothing of this one.
    reset = np.where(np.arange(20) == 15, int(Status.RESET), 0)
    row, line = friction_of_directions(replace(seen, status=reset), psi, M_z, aligning)
    assert line.endswith("; not usable since the ground changed at 0.15 s, turning to negative psi")
    assert "mu_eff_negative" not in row
    assert row["direction"] == "positive"
    assert math.isnan(float(row["weaker"]))
    # A torque about zero tells nothing of the direction that it has, and a wheel that rests has none.
    small = replace(seen, M_z_predicted=0.4 * seen.M_z_predicted)
    for angle, way in ((psi, "positive"), (np.zeros(20), "")):
        row, line = friction_of_directions(small, angle, M_z, aligning)
        assert (list(row), row["direction"], line) == (["direction", "weaker"], way, "")


@pytest.mark.parametrize(
    ("turn", "M_z", "flag", "way"),
    [
        (1e-3, -0.1, Status.USED, "positive"),
        (1e-3, 0.1, Status.USED, "negative"),
        # Noise of the angle is no turn.
        (1e-4, -0.1, Status.USED, "negative"),
        (1e-3, np.nan, Status.USED, "positive"),
        # The sensor's zero has moved.
        (1.0, -0.1, Status.IMPLAUSIBLE, "negative"),
    ],
)
def test_the_direction_is_exchanged_where_the_torque_opposes_the_motion(
    turn: float, M_z: float, flag: Status, way: str
) -> None:
    seen, i = estimates(*[Status.USED] * 20), np.arange(20)
    seen = replace(
        seen, M_z_predicted=1.0 * (i < 15), status=np.where((i > 15) & (i < 18), int(flag), 0)
    )
    psi, M_z = np.where(i > 15, turn, 0.0) - 0.01 * np.minimum(i, 14), np.where(i < 15, 1.0, M_z)
    row, _ = friction_of_directions(seen, psi, M_z, DirectionalFriction())

    assert row["direction"] == way


def test_how_long_the_torque_is_not_explained_after_a_value_is_told() -> None:
    seen = estimates(*[Status.USED] * 20, *[Status.INCONSISTENT] * 30)
    seen = replace(seen, usable=seen.status == 0)
    line = estimates_summary(seen)
    row = row_of(seen)
    short = estimates(*[Status.USED] * 120, Status.INCONSISTENT)

    assert row["since_usable"] == pytest.approx(0.3)
    assert " at 0.19 s, last usable, then not explained for 0.3 s, usable in " in line
    assert "not explained for" not in estimates_summary(replace(short, usable=short.status == 0))


def test_a_torque_at_a_tenth_of_the_rate_is_counted_by_itself() -> None:
    seen = estimates(*[Status.USED, *[Status.MISSING] * 9] * 40)
    slower = replace(seen, usable=seen.usable & (seen.status == 0))
    row = row_of(slower)

    assert (row["samples"], row["measured"], row["usable"], row["informed"]) == (400, 40, 0.5, 0.5)
    # Behind the last torque nothing can be usable.
    assert row["since_usable"] == 0
    assert "usable in 50 % of 40 samples with a torque" in estimates_summary(slower)
    off = replace(slower, status=np.where(slower.t < 1, int(Status.IMPLAUSIBLE | Status.MISSING), 0))
    row = row_of(off)
    assert (row["implausible"], row["wide"]) == (0.25, 1 / 3)


def test_remarks_in_a_table() -> None:
    few = estimates(*[Status.USED] * 100, last=55)
    beside = recording_remark(few, "it lies: weigh it; later", "ice: measure")
    rows = [{"mu_eff": 0.1, "remark": beside}, {"mu_eff": math.nan, "remark": "not known: no"}] * 2

    assert beside == "usable in under 10 % | it lies: weigh it; later | ice: measure"
    assert remark_heads(beside) == ["usable in under 10 %", "it lies", "ice"]
    assert (
        remark_counts(rows)
        == "2 of 4: usable in under 10 %; 2 of 4: it lies; 2 of 4: ice; 2 of 4: not known: no"
    )
    assert recording_remark(estimates(*[Status.USED] * 4), "", "") == ""
    unknown = recording_remark(estimates(*[Status.USED] * 4, last=0), "it lies: weigh it; later", "")
    assert remark_heads(unknown) == ["not known: it lies: weigh it"]
    noted = recording_remark(estimates(*[Status.USED] * 4, last=0), "it lies", "ice: measure")
    assert noted == "not known: it lies | ice: measure"


def test_a_new_ground_that_a_misfit_may_have_feigned() -> None:
    status = [Status.USED] * 2 + [Status.RESET] + [Status.INCONSISTENT] * 3
    doubted, sure = estimates(*status, last=2), estimates(*status[:3], *[Status.USED] * 3, last=1)
    doubted = replace(doubted, usable=doubted.t < 0.02)

    line = estimates_summary(doubted)
    assert "not known since 0.02 s: either the ground changed, or the model does not fit" in line
    assert "1 change of the ground or misfits of the model; " in line
    assert "1 change of the ground; " in estimates_summary(sure)


def test_ice_asks_for_dry_friction_and_noise_of_the_sensor() -> None:
    rig = Rig(a=0.045, e=0.009)
    both = undeclared_sensor_note(0.1, rig)
    assert both.startswith("below 0.15, dry friction and noise of the sensor not declared: ")
    assert both.endswith("[sensor] dry_friction = ... and noise = ... N m")
    noise = undeclared_sensor_note(0.1, replace(rig, dry_friction=0.0))
    assert noise.startswith("below 0.15, noise of the sensor not declared: the noise assumed may hide ")
    assert "dry_friction" not in noise
    known = replace(rig, dry_friction=0.0, noise=0.1)
    assert undeclared_sensor_note(0.1, known) == undeclared_sensor_note(0.3, rig) == ""


def test_when_an_input_looked_wrong_is_told_beside_the_value() -> None:
    """Flagged from 0.02 to 0.05 s of 0.2 s; usable from 0.1 s on, or from 0 to 0.01 s."""
    status = [Status.USED] * 2 + [Status.SUSPECT] * 4 + [Status.USED] * 14
    seen = estimates(*status)
    when = "an input looks wrong from 0.02 to 0.05 s, {} the value told, by its unit, its sign"
    assert f"4 samples not usable: {when.format('before')}" in estimates_summary(seen)
    early = replace(seen, usable=seen.t < 0.015)
    assert when.format("after") in unusable_samples_and_remedy(early)[1]
    mended = estimates(*[Status.SUSPECT] * 4, *[Status.INCONSISTENT] * 2, *[Status.USED] * 14)
    assert unusable_samples_and_remedy(mended, "declare it") == (
        4, "an input looks wrong from 0 to 0.03 s, before the value told: declare it",
    )  # fmt: skip
    around = replace(mended, usable=mended.t < 0.025)
    assert "before and after the value" in unusable_samples_and_remedy(around)[1]
    remark = unusable_samples_and_remedy(seen)[1]
    rows = [{"remark": remark}, {"remark": remark.replace("0.05", "7.5")}]
    assert remark_counts(rows).startswith("2 of 2: an input looks wrong, before the value told, by")


def test_friction_of_a_ground_says_that_each_is_at_its_own_load() -> None:
    rows = [
        {"ground": "ice", "mu_eff": mu, "mu_eff_std": 0.01, "remark": f"{OVER_LOAD}: mu_eff"}
        for mu in (0.1, 0.2, 0.15)
    ]
    assert friction_of_grounds(rows)[0].startswith("ice, each at its own load: mu_eff ")
    silent = [row | {"remark": ""} for row in rows]
    assert friction_of_grounds(silent)[0].startswith("ice: mu_eff ")


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
    told = {row["recording"]: row["remark"] for row in with_early_ends(rows)}

    assert told["short"] == "it lies | ends early, after 0.59 s: half of all last 14 s or more"
    assert told["shorter"] == "ends early, after 0.2 s: half of all last 14 s or more"
    assert (told["b00"], told["b10"], told["broken"]) == ("not known: no", "", "")
    counts = remark_counts(with_early_ends(rows), named=True)
    ten = ", ".join(f"b{i:02}" for i in range(10))
    assert counts.startswith(f"10 of 23: not known: no ({ten}); 2 of 23: ends early (short, shorter); ")
    rows[10]["remark"] = "not known: no"
    assert remark_counts(rows, named=True).startswith("11 of 23: not known: no; 1 of")
    assert with_early_ends(rows[-3:])[0]["remark"] == "it lies", "of two lengths"


def test_noise_goes_first_and_a_slower_torque_is_no_fault() -> None:
    alien = estimates(*[Status.INCONSISTENT] * 2, *[Status.USED] * 2)
    slower = estimates(*[Status.USED, Status.MISSING] * 2, last=2)

    assert "does not explain the torque: declare it" in estimates_summary(alien, "declare it")
    assert "raise error of the tuning to 0.1 (--tune error=0.1): with more" in estimates_summary(alien)
    of_car = estimates_summary(alien, of_car=True)
    assert "too small: find what the model lacks (brushgrip diagnose --vehicle), check units" in of_car
    assert of_car.endswith("or declare a greater force_error or force_noise")
    assert "0.1" not in of_car.partition("not usable")[2]
    assert "; 2 samples not usable: no measurement" in estimates_summary(slower)
    assert estimates_summary(slower, rates="100 and 200 Hz").endswith(
        "usable in 50 % of 2 samples with a torque, from 0.02 s; 100 and 200 Hz"
    )


def test_a_narrow_band_has_a_digit_more() -> None:
    assert with_95_band(0.0512, 0.004) == "0.051 ± 0.008"
    assert with_95_band(1.234, 0.05) == "1.23 ± 0.10"
    assert with_95_band(math.nan, 0.05) == "–"
    car = band_parts({SLOPE: 0.006, "axle load": 0.004})
    assert car.endswith("(brushgrip identify --lock-to-lock), or check the force's scale")
    assert band_parts({REST: 0.006, "axle load": 0.004}).endswith("(brushgrip diagnose --vehicle)")
    line = band_parts({REST: 0.006, SLOPE: 0.004})
    assert line.startswith("the band ± 0.007 is made of (the squares add up): ")
    assert f"{REST} 0.006, {SLOPE} 0.004;" in line


def found_model(training: int, holdout: int, **grades: str) -> FoundModel:
    return FoundModel(
        model=Model(effects=effects_named(["carcass_torsion", "torque_offset"])),
        tyre={"k": 2.4e6, "carcass_torsion.k_t": 390.0},
        own={},
        error=ModelError(spread=0.03, correlation_time=1.0),
        basis=ModelBasis(training=training, holdout=holdout, grades=grades),
    )


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (
            found_model(1, 0, carcass_torsion="weak", torque_offset="strong"),
            "carcass torsion (weak), k = 2.4·10⁶ N/m² and the error that observers allow the model,"
            " 3.00 % of the torque of full slide; not torque offset, which belongs to a recording. It"
            " stands on 1 recording, nothing judged it; 1 of 2 effects are weak or stand-ins",
        ),
        (
            replace(
                found_model(1, 0), error=ModelError(spread=0.03, correlation_time=1.0, relative=0.04)
            ),
            "the error that observers allow the model, 2.00 % of the torque's range",
        ),
        (found_model(2, 0), "It stands on 2 recordings, each left out in turn judged it"),
        (found_model(4, 3), "It stands on 4 recordings, 3 validation recordings judged it"),
        (replace(found_model(1, 0), basis=None), "does not say how many recordings that stands on"),
    ],
)
def test_what_is_taken_from_a_model(model: FoundModel, words: str) -> None:
    assert words in taken_from_model(model)


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
        ([Status.RESET], "1 change of the ground; 1 sample not usable: the ground has changed"),
        (
            [Status.RESET] * 2 + [Status.REJECTED],
            "1 sample rejected, 2 changes of the ground; 2 samples",
        ),
    ],
)
def test_faults_are_counted_and_the_most_frequent_gets_its_remedy(
    status: list[Status], words: str
) -> None:
    line = estimates_summary(estimates(*status, *[Status.USED] * 4))

    assert words in line
    assert "\n" not in line


@pytest.mark.parametrize("flag", [Status.SUSPECT, Status.BOUND])
def test_what_a_sound_wheel_meets_in_its_first_turns_is_not_told(flag: Status) -> None:
    sound = [Status.ACQUIRING] * 50 + [flag] * 2 + [Status.USED] * 348

    assert "sample not" not in estimates_summary(estimates(*sound)).replace("samples", "sample")
    assert "5 samples not usable: " in estimates_summary(
        estimates(*[flag] * 5, *sound[5:50], *sound[52:])
    )


def test_a_suspicion_goes_before_an_acquisition_that_lasts_as_long() -> None:
    doubted = estimates(*[Status.ACQUIRING | Status.SUSPECT] * 3, Status.ACQUIRING, last=-1)

    assert unusable_samples_and_remedy(doubted) == (3, Status.SUSPECT.remedy)
    assert unusable_samples_and_remedy(doubted, cause="in degrees") == (3, "in degrees")
    both = estimates(*[Status.SUSPECT] * 3, Status.INCONSISTENT, last=-1)
    assert unusable_samples_and_remedy(both, LACKING) == (3, Status.SUSPECT.remedy)
    assert unusable_samples_and_remedy(both, "declare it") == (3, "an input looks wrong: declare it")
    assert unusable_samples_and_remedy(estimates(*[Status.ACQUIRING] * 4, last=-1)) == (
        4,
        Status.ACQUIRING.remedy,
    )


def test_floats_round_trip_truth_is_a_digit_and_what_is_missing_is_empty() -> None:
    values = np.random.default_rng(1).normal(size=100)
    header, *rows = csv_text({"t": np.arange(100), "M_z": values}).splitlines()

    assert header == "t,M_z"
    assert [float(row.split(",")[1]) for row in rows] == values.tolist()
    missing = {"informed": np.array([True, False]), "mu": np.array([np.nan, 1.0])}
    assert csv_text(missing) == "informed,mu\n1,\n0,1.0\n"


def test_json_is_strict() -> None:
    content = {"a": [math.nan, 1.5, {"b": math.inf}], "c": "μ", "d": (True, None, 3)}

    assert json.loads(json_text(content)) == {
        "a": [None, 1.5, {"b": None}],
        "c": "μ",
        "d": [True, None, 3],
    }


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("by ±0.049 rad, 8 times", "by ±0.049 rad (±2.8°), 8 times"),
        ("of −0.24, 0.60 rad, at 0.12 rad/s", "of −0.24, 0.60 rad (−14°, 34°), at 0.12 rad/s (6.9°/s)"),
        ("between −0.52 and 0.89 rad, 52 s", "between −0.52 and 0.89 rad (−30° and 51°), 52 s"),
        ("k_t = 3 N m/rad", "k_t = 3 N m/rad"),
    ],
)  # fmt: skip
def test_angles_are_told_in_degrees_too(text: str, words: str) -> None:
    assert with_degrees(text) == words


def test_a_proposed_recording_says_where_to_turn_first_and_whether_it_is_enough() -> None:
    # It begins at rest at 0 and goes as sin t, so to 1 rad first.
    told = experiment_in_words(experiment())
    assert told.endswith(
        "5.0 standard errors, of which 2 are needed. It begins at 0° and turns to 57° first."
    )
    backwards = experiment()
    psi = -0.5 * backwards.manoeuvre.psi
    backwards = replace(backwards, manoeuvre=replace(backwards.manoeuvre, psi=psi))
    assert experiment_in_words(backwards).endswith("begins at 0° and turns to −29° first.")
    assert "first" not in experiment_in_words(replace(backwards, times=None))
