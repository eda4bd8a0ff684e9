"""What the model leaves out, and how far its friction and its error go."""

from dataclasses import replace

import numpy as np
import pytest

from brushgrip.estimation.friction_by_both_models import EKF_DECLARED
from brushgrip.report.validity_and_missing_effects import (
    error_text_and_basis,
    known_by_both_models_text,
    missing_effects,
)
from brushgrip.report.what_effects_do import effect_summary, friction_over_speed
from brushgrip.wording.formatting import percent
from identification import Curve, FoundFamily
from tests.brushgrip.factories import TRACKS, make_diagnosis, make_outcome

RANGE = " from 0.1 to 10 mm/s, in a typical recording"


def test_what_the_model_found_changes_is_told_with_both_figures() -> None:
    old = tuple(replace(track, label=EKF_DECLARED) for track in TRACKS[:2])
    outcome = make_outcome("c", tracks=(*old, *TRACKS[:2]))
    assert known_by_both_models_text(make_diagnosis(), outcome) == (
        "A value of friction comes out in 2 of 2 recordings (first after 5.0 s, in 1 lost again before"
        " the end) by the model found; in 2 of 2 recordings (first after 5.0 s, in 1 lost again before"
        " the end) by the assumed model."
    )
    never = tuple(replace(track, usable=np.zeros(11, dtype=bool)) for track in old)
    once = replace(outcome, tracks=(old[0], never[1], *TRACKS[:2]))
    assert "in 1 of 2 recordings (first after 5.0 s) by the assumed" in known_by_both_models_text(
        make_diagnosis(), once
    )
    none = replace(outcome, tracks=(*never, *TRACKS[:2]))
    assert "in none of 2 recordings by the assumed" in known_by_both_models_text(make_diagnosis(), none)
    assert known_by_both_models_text(replace(make_diagnosis(), of_car=True), outcome) == ""
    assert known_by_both_models_text(make_diagnosis(found=False), outcome) == ""


@pytest.mark.parametrize(
    ("friction", "told"),
    [
        ([1.0, 1.1, 1.2], "friction rises by 0.10 for each tenfold sliding speed" + RANGE),
        ([1.2, 1.1, 1.0], "friction falls by 0.10 for each tenfold sliding speed" + RANGE),
        ([1.0, 1.001, 1.002], "friction rises by less than 0.01 for each tenfold sliding speed" + RANGE),
        ([1.0, 1.0, 1.2], "friction rises with the speed of sliding" + RANGE),
        ([1.0, 1.3, 1.2], "friction changes with the speed of sliding"),
        ([1.0, 1.0, 1.0], "friction changes with the speed of sliding"),
    ],
)
def test_which_way_friction_goes_with_speed_is_that_of_the_fitted_curve(
    friction: list[float], told: str
) -> None:
    y = np.array(friction)
    curve = Curve(
        x_name="sliding speed", x_unit="m/s", y_name="friction", y_unit="1", y=y, std=0.01 * y,
        x=np.array([1e-4, 1e-3, 1e-2]), declared=np.ones(3),
    )  # fmt: skip
    name = "friction over speed"
    family = FoundFamily(name=name, effects=("rate_friction",), rivals=(), curve=curve)
    diagnosis = replace(make_diagnosis(), families=(family,))
    found = replace(diagnosis.effects[0], name="rate_friction", family=name, indistinguishable_from=())

    creep = replace(found, parameters={"c": next(iter(found.parameters.values()))})

    assert friction_over_speed(diagnosis) == told
    assert missing_effects(replace(diagnosis, effects=(creep,))) == [
        f"(a) F{told[1:]} (likely, not proven).",
        "(b) An error beyond noise remains, of unknown cause, which the model found leaves out too.",
    ]
    tied = "(2.3 c μ) for each" in effect_summary(replace(diagnosis, effects=(creep,)), creep)
    assert tied == ("for each" in told)
    assert "2.3 c" not in effect_summary(replace(diagnosis, effects=(creep, creep)), creep), (
        "of both laws"
    )
    # What may be another effect of the model is not clear.
    open_one = replace(found, grade="ambiguous")
    first, _ = missing_effects(replace(diagnosis, effects=(open_one,)))
    assert first.endswith(" (how much is not settled).")


def test_the_assumed_model_has_its_own_error_where_nothing_was_found() -> None:
    diagnosis = make_diagnosis(("a", "b"), ("c",), found=False)
    first, _ = error_text_and_basis(diagnosis)
    declared = percent(diagnosis.declared.summary()["holdout_torque_nrmse"])
    assert f"(not of friction): {declared} of its range by the assumed model as given, 4" in first
    assert "by the model found" not in first
    left_out = make_diagnosis(("a", "b"), ())
    left_out = replace(left_out, declared=replace(left_out.declared, left_out={}))
    assert error_text_and_basis(left_out)[0].startswith(
        "The error of the calculated torque (not of friction): 4.05 % of its range by the assumed model"
        " with only k fitted"
    )


@pytest.mark.parametrize(
    ("odd", "ratios", "told"),
    [
        (
            1,
            {},
            "A further cause, unknown. A correction stands in for it. Even so",
        ),
        (
            1,
            {"": 1.1},
            "stands in for it; without it friction would be 10 % higher than told; the cause itself may"
            " change it by more. Even so",
        ),
        (
            2,
            {"steel": 0.96, "ice": 1.001, "snow": 0.957},
            "Corrections stand in for it; without them friction would be 4 % lower than told on steel"
            " and snow and as told on ice; the",
        ),
    ],
)
def test_how_much_of_friction_rests_on_stand_ins(odd: int, ratios: dict[str, float], told: str) -> None:
    diagnosis = make_diagnosis()
    one = replace(diagnosis.effects[0], grade="stands_in")
    others = (one, replace(one, name="stribeck"))[:odd]
    clear = replace(
        diagnosis.effects[0], name="rate_friction", grade="strong", indistinguishable_from=()
    )
    left = replace(diagnosis.unexplained, present=True)
    diagnosis = replace(diagnosis, effects=(clear, *others), unexplained=left)

    assert told in " ".join(missing_effects(diagnosis, make_outcome(without_stand_ins=ratios)))


def test_what_is_left_where_everything_of_a_recording_is_fitted_is_told() -> None:
    diagnosis = make_diagnosis()
    bare = replace(diagnosis.after, unrefitted=diagnosis.after.nrmse)
    left = percent(diagnosis.after.summary()["holdout_torque_nrmse"])

    _, told = error_text_and_basis(replace(diagnosis, after=bare))
    assert f", fitted to each, {left} is left; the difference is particular to each recording" in told
    assert "is left" not in error_text_and_basis(diagnosis)[1]
