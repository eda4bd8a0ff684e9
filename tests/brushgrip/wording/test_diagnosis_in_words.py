"""Sentences about a diagnosis are only as sure as its figures."""

from dataclasses import replace
from typing import Any

import pytest

from brushgrip.wording.diagnosis_in_words import (
    experiment_in_words,
    grade_reason,
    headline,
    parameter_words_and_owner,
    taken_from_model,
)
from identification import Diagnosis, FoundModel
from identification.diagnosis.result_parts import Grade
from symbolic import Model, ModelBasis, ModelError, effects_named
from tests.brushgrip.factories import experiment, make_diagnosis


def graded(diagnosis: Diagnosis, *grades: Grade, errors: float = 5.0) -> Diagnosis:
    pairs = zip(diagnosis.effects, grades, strict=True)
    effects = tuple(replace(e, grade=grade, standard_errors=errors) for e, grade in pairs)
    return replace(diagnosis, effects=effects)


@pytest.mark.parametrize(
    ("error", "said"), [(0.07, True), (0.047, True), (0.045, False), (0.0, False), (None, False)]
)
def test_what_refitting_hides_is_said(error: float | None, said: bool) -> None:
    """Of the validation recording 2.31 % of range are left after refitting."""
    for found in (True, False):
        diagnosis = make_diagnosis(("a", "b"), ("c",), found=found)
        after = replace(diagnosis.after, nrmse={"a": 0.02, "b": 0.02, "c": 0.0231})
        after = replace(after, unrefitted={} if error is None else {"c": error})
        line = headline(replace(diagnosis, after=after))
        assert ("2.31 % of range, but" in line and "with nothing adjusted: there" in line) is said
        exact = replace(after, nrmse={"a": 0.0, "b": 0.0, "c": 1e-5}, unrefitted={"c": 1e-3})
        assert "nothing adjusted" not in headline(replace(diagnosis, after=exact)), "below what counts"


def test_only_clear_effects_are_said_to_be_missing() -> None:
    diagnosis, explained = make_diagnosis(), make_diagnosis(unexplained=False)
    assert headline(graded(explained, "strong", "weak")).startswith(
        "The assumed model lacks compliance and contact shape (carcass torsion); there are weak signs"
        " of torque offset: validation"
    )
    weak = headline(graded(explained, "weak", "weak"))
    assert weak.startswith("There are only weak signs of carcass torsion and torque offset: ")
    assert "lacks" not in weak
    assert headline(graded(diagnosis, "ambiguous", "strong")).startswith(
        "The assumed model lacks compliance and contact shape (carcass torsion, or patch width) and"
        " sensor and steering (torque offset); 1.20 % of range stay unexplained: "
    )
    assert headline(graded(explained, "stands_in", "stands_in")).startswith(
        "Carcass torsion and torque offset are stand-ins: "
    )


def test_an_unrecorded_load_is_named_with_the_remedy() -> None:
    torsion, offset = make_diagnosis().effects
    effect = replace(offset, grade="ambiguous", indistinguishable_from=("unrecorded_load",))
    diagnosis = replace(make_diagnosis(unexplained=False), effects=(effect,))
    assert "(torque offset, or a load that changes with the angle: record it): " in headline(diagnosis)
    assert "but a load that changes with the angle would explain as much" in grade_reason(effect)
    graded_torsion = replace(torsion, grade="ambiguous")
    assert "record it" not in headline(replace(diagnosis, effects=(graded_torsion,)))


@pytest.mark.parametrize(
    ("structured", "grade", "first"),
    [
        (0.0308, "strong", True),
        # Found: 4.30 % before, 2.37 % after.
        (0.0194, "strong", True),
        (0.0192, "strong", False),
        (0.0001, "weak", True),
    ],
)
def test_what_is_unexplained_goes_first_where_it_is_the_larger(
    structured: float, grade: Grade, first: bool
) -> None:
    diagnosis = graded(make_diagnosis(), grade, "weak")
    line = headline(
        replace(diagnosis, unexplained=replace(diagnosis.unexplained, structured=structured))
    )

    assert line.startswith("Something unknown remains, ") == first
    assert f"{100 * structured:.2f} % of range" in line
    assert line.endswith(": validation error 4.30 % (k refitted) → 2.37 % of range.")


@pytest.mark.parametrize(
    ("grade", "words"),
    [
        ("strong", "hardly chance (1.4 standard errors), and no other effect"),
        ("weak", "may be chance (a gain of 1.4 standard errors; 3 of each are asked for)"),
        ("ambiguous", "but patch width would explain as much"),
        ("stands_in", "may make up for a flaw of another effect, unproven"),
    ],
)
def test_every_grade_is_explained(grade: Grade, words: str) -> None:
    effect = graded(make_diagnosis(), grade, "weak", errors=1.4).effects[0]
    assert words in grade_reason(effect)
    if grade == "stands_in":
        assert "at the allowed limit" in grade_reason(replace(effect, at_bound=True))


def test_a_weak_effect_says_what_it_lacks() -> None:
    effect = graded(make_diagnosis(), "weak", "weak", errors=2.07).effects[0]
    clear, near = (grade_reason(replace(effect, deviations=off)) for off in (359.0, 1.2))

    assert clear.startswith("The fitted recordings demand it (a parameter 359.0 σ from no effect)")
    assert "do not confirm it (a gain of 2.1 standard errors; 3 are asked for): fit" in clear
    assert near == (
        "It may be chance (a gain of 2.1 standard errors and a parameter 1.2 σ from no effect; 3 of each"
        " are asked for)."
    )


def test_an_effect_of_no_family_goes_by_its_name() -> None:
    diagnosis = graded(make_diagnosis(), "ambiguous", "weak")
    alone = tuple(replace(effect, family=effect.name) for effect in diagnosis.effects)
    assert headline(replace(diagnosis, effects=alone)).startswith(
        "The assumed model lacks carcass torsion (or patch width); "
    )


def test_a_rival_that_the_model_has_too_is_not_named() -> None:
    diagnosis = graded(make_diagnosis(unexplained=False), "ambiguous", "strong")
    shared = replace(diagnosis.effects[0], indistinguishable_from=(), experiment=None)
    diagnosis = replace(diagnosis, effects=(shared, diagnosis.effects[1]))
    assert headline(diagnosis).startswith(
        "The assumed model lacks compliance and contact shape (carcass torsion) and sensor and"
    )
    assert grade_reason(shared).endswith(
        "another effect that the model has too would explain as much alone."
    )


def test_parameters_have_plain_names() -> None:
    assert parameter_words_and_owner("carcass_torsion.k_t") == ("carcass torsion: k_t", "")
    assert parameter_words_and_owner("torque_offset.M_0 [fem1]") == ("torque offset: M_0", "fem1")
    assert parameter_words_and_owner("mu [fem1]") == ("internal coefficient μ, not to be quoted", "fem1")
    assert parameter_words_and_owner("k") == ("tread stiffness k", "")
    assert parameter_words_and_owner("a [fem1]") == ("half-length a", "fem1")
    assert parameter_words_and_owner("e [fem1]") == ("caster e", "fem1")


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
