"""Sentences about a diagnosis are only as sure as its figures."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from brushgrip.wording.diagnosis_in_words import explained_grade, headline, split_parameter_label
from identification import Diagnosis, ParameterEstimate
from identification.diagnosis import doubtful_effects, graded_effects
from identification.diagnosis.graded_effects import distance_from_neutral, grade_of
from identification.diagnosis.result_parts import Grade
from identification.fits.loss import LEAST_SQUARES
from symbolic import EFFECTS
from tests.brushgrip.factories import make_diagnosis
from tests.identification.factories import recording, with_torque


def graded(diagnosis: Diagnosis, *grades: Grade, errors: float = 5.0) -> Diagnosis:
    pairs = zip(diagnosis.effects, grades, strict=True)
    effects = tuple(replace(e, grade=grade, standard_errors=errors) for e, grade in pairs)
    return replace(diagnosis, effects=effects)


@pytest.mark.parametrize(
    ("figures", "rivals", "odd", "grade"),
    [
        ((3.0, -6.0), False, False, "strong"),
        ((3.0, -6.0), True, False, "ambiguous"),
        ((2.9, -60.0), False, False, "weak"),
        ((1.4, -60.0), True, False, "weak"),
        ((30.0, -5.9), False, False, "weak"),
        ((30.0, -60.0), False, True, "stands_in"),
        ((float("nan"), -60.0), False, False, "weak"),
        # A parameter close to no effect is a hint.
        ((9.0, -60.0, 1.4), False, False, "weak"),
        ((9.0, -60.0, 3.0), False, False, "strong"),
    ],
)
def test_grades(figures: tuple[float, ...], rivals: bool, odd: bool, grade: str) -> None:
    assert grade_of(*figures, has_rivals=rivals, stands_in=odd) == grade


@pytest.mark.parametrize(
    ("name", "estimates", "distance"),
    [
        ("torque_offset", {"M_0 [a]": (0.1, 0.05), "M_0 [b]": (-0.3, 0.1)}, 3.0),
        ("carcass_torsion", {"k_t": (400.0, 200.0)}, 2.0),
        ("torque_offset", {"M_0 [a]": (0.1, None)}, None),
    ],
)
def test_distance_from_no_effect(
    name: str, estimates: dict[str, tuple[float, float | None]], distance: float | None
) -> None:
    values = {n: ParameterEstimate(value=v, std=s, unit="1") for n, (v, s) in estimates.items()}
    assert distance_from_neutral(EFFECTS[name], values) == pytest.approx(distance)


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
    assert "but a load that changes with the angle would explain as much" in explained_grade(effect)
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
    assert words in explained_grade(effect)
    if grade == "stands_in":
        assert "at the allowed limit" in explained_grade(replace(effect, at_bound=True))


def test_a_weak_effect_says_what_it_lacks() -> None:
    effect = graded(make_diagnosis(), "weak", "weak", errors=2.07).effects[0]
    clear, near = (explained_grade(replace(effect, deviations=off)) for off in (359.0, 1.2))

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


def test_an_effect_of_the_model_is_no_rival_of_another_one() -> None:
    own, spring, shape = (SimpleNamespace(name=name) for name in ("own", "steering_return", "shape"))
    step = SimpleNamespace(indistinguishable=(spring, shape))
    rivals = graded_effects._rivals_outside(step, (own, spring))  # type: ignore[arg-type]
    assert rivals == ("shape",)

    diagnosis = graded(make_diagnosis(unexplained=False), "ambiguous", "strong")
    shared = replace(diagnosis.effects[0], indistinguishable_from=(), experiment=None)
    diagnosis = replace(diagnosis, effects=(shared, diagnosis.effects[1]))
    assert headline(diagnosis).startswith(
        "The assumed model lacks compliance and contact shape (carcass torsion) and sensor and"
    )
    assert explained_grade(shared).endswith(
        "another effect that the model has too would explain as much alone."
    )


def test_parameters_have_plain_names() -> None:
    assert split_parameter_label("carcass_torsion.k_t") == ("carcass torsion: k_t", "")
    assert split_parameter_label("torque_offset.M_0 [fem1]") == ("torque offset: M_0", "fem1")
    assert split_parameter_label("mu [fem1]") == ("internal coefficient μ, not to be quoted", "fem1")
    assert split_parameter_label("k") == ("tread stiffness k", "")
    assert split_parameter_label("a [fem1]") == ("half-length a", "fem1")
    assert split_parameter_label("e [fem1]") == ("caster e", "fem1")


@pytest.mark.parametrize(
    ("gains", "of_car", "first", "expected"),
    [
        ((850, 70, 30), True, "large", {"mid", "last"}),
        ((850, 70, 30), False, "large", {"mid", "last"}),
        ((650, 230, 70), True, "large", set()),
        ((650, 230, 70), False, "large", {"last"}),
        ((60, 230, 70), False, "large", {"last"}),
        ((60, 230, 70), False, "mid", {"large", "last"}),
        ((850, 230, 55), False, "last", {"last"}),
    ],
    ids=[
        "of a car",
        "a remainder of the first",
        "a large one of a car",
        "more",
        "the first explains as much as is left",
        "another one does",
        "the first explains less",
    ],
)
def test_what_stands_in_for_something_unknown(
    gains: tuple[float, ...], of_car: bool, first: str, expected: set[str]
) -> None:
    """What a stand-in of a car explains is unknown too; without one a further effect may be a remainder.

    Squares of 56 are left: a further effect has to explain 225.
    """
    explained = dict(zip(("large", "mid", "last"), gains, strict=True))
    if of_car:
        assert doubtful_effects._stand_ins_of_car(explained, set(), 56.25) == expected
    else:
        left = dict.fromkeys(explained, 56.25)
        assert doubtful_effects._stand_ins(explained, left, first) == expected


def test_the_first_effect_is_of_the_family_that_the_search_began_with() -> None:
    """The flexible law with which it began gave way to another one of its family, at the end."""
    speed, law, load, second = (
        SimpleNamespace(name=name, family=family)
        for name, family in (("f", "speed"), ("s", "speed"), ("n", "load"), ("t", "speed"))
    )
    sets = ((), (speed,), (speed, load), (load, law), (load, law, second))
    steps = [SimpleNamespace(after=SimpleNamespace(effects=effects)) for effects in sets[1:]]
    gains = {"n": 9.0, "s": 2.0, "t": 1.0}
    assert doubtful_effects._first_effect(steps, sets[-1], gains) == "s"  # type: ignore[arg-type]
    assert doubtful_effects._first_effect([], (), {}) is None


@pytest.mark.parametrize(("noise", "every"), [(False, 1), (True, 1), (False, 2)])
@pytest.mark.parametrize(("where", "more"), [("there", 8.0), ("elsewhere", -8.0), ("nowhere", 0.0)])
def test_what_is_left_counts_where_the_effect_acts(
    where: str, more: float, noise: bool, every: int
) -> None:
    """A residual of 4 in one half, 0 in the other; squares of 4 beyond noise. White noise counts not.

    The torque may come with every second sample only.
    """
    one, other = np.repeat([1.0, 0.0], 500), np.repeat([0.0, 1.0], 500)
    acts = {"there": one, "elsewhere": other, "nowhere": 0 * one}[where]
    ranged = with_torque(recording("a"), np.linspace(0, 1, recording("a").t.size))
    left_over = 4 * one * (np.tile([1, 1, -1, -1], 250) if noise else 1)  # No neighbours' correlation.
    left_over[np.arange(1000) % every > 0] = np.nan
    whole = SimpleNamespace(residuals={"a": left_over}, fitted=SimpleNamespace(loss=LEAST_SQUARES))
    rest = SimpleNamespace(residuals={"a": left_over + 3 * acts})
    left = SimpleNamespace(structured=2.0)
    local = doubtful_effects._left_where_it_acts(whole, rest, [ranged], left)  # type: ignore[arg-type, list-item]
    assert local == pytest.approx(4 if noise else 4 + more, abs=0.1)


def test_a_law_that_came_back_is_named_once() -> None:
    """A flexible law took its place and gave way again."""
    sets = ((), ("stribeck",), ("stribeck", "offset"), ("offset", "speed law"), ("offset", "stribeck"))
    trials = [SimpleNamespace(effects=effects) for effects in sets]
    steps = [SimpleNamespace(before=before, after=after) for before, after in pairwise(trials)]
    steps.append(SimpleNamespace(before=trials[-1], after=None))

    added = graded_effects._additions(steps, ("offset", "stribeck"))  # type: ignore[arg-type]

    assert added == [steps[1], steps[3]]
