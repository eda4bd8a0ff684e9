"""Grades of effects: figures that make them, and effects that stand in for something unknown."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from identification import ParameterEstimate
from identification.diagnosis import graded_effects, stand_ins_for_unknown_cause
from identification.diagnosis.graded_effects import distance_from_neutral_in_std, effect_grade
from identification.fits.loss import LEAST_SQUARES
from symbolic import EFFECTS
from tests.identification.factories import recording, with_torque


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
    assert effect_grade(*figures, has_rivals=rivals, stands_in=odd) == grade


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
    assert distance_from_neutral_in_std(EFFECTS[name], values) == pytest.approx(distance)


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
        assert stand_ins_for_unknown_cause._low_gain_effects_of_car(explained, set(), 56.25) == expected
    else:
        left = dict.fromkeys(explained, 56.25)
        assert stand_ins_for_unknown_cause._low_gain_effects_of_wheel(explained, left, first) == expected


def test_the_first_effect_is_of_the_family_that_the_search_began_with() -> None:
    """The flexible law with which it began gave way to another one of its family, at the end."""
    speed, law, load, second = (
        SimpleNamespace(name=name, family=family)
        for name, family in (("f", "speed"), ("s", "speed"), ("n", "load"), ("t", "speed"))
    )
    sets = ((), (speed,), (speed, load), (load, law), (load, law, second))
    steps = [SimpleNamespace(after=SimpleNamespace(effects=effects)) for effects in sets[1:]]
    gains = {"n": 9.0, "s": 2.0, "t": 1.0}
    assert stand_ins_for_unknown_cause._effect_of_first_family(steps, sets[-1], gains) == "s"  # type: ignore[arg-type]
    assert stand_ins_for_unknown_cause._effect_of_first_family([], (), {}) is None


@pytest.mark.parametrize(("noise", "every"), [(False, 1), (True, 1), (False, 2)])
@pytest.mark.parametrize(("where", "more"), [("there", 8.0), ("elsewhere", -8.0), ("nowhere", 0.0)])
def test_what_is_left_counts_where_it_acts(where: str, more: float, noise: bool, every: int) -> None:
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
    local = stand_ins_for_unknown_cause._unexplained_where_effect_acts(whole, rest, [ranged], left)  # type: ignore[arg-type, list-item]
    assert local == pytest.approx(4 if noise else 4 + more, abs=0.1)


def test_a_law_that_came_back_is_named_once() -> None:
    """A flexible law took its place and gave way again."""
    sets = ((), ("stribeck",), ("stribeck", "offset"), ("offset", "speed law"), ("offset", "stribeck"))
    trials = [SimpleNamespace(effects=effects) for effects in sets]
    steps = [SimpleNamespace(before=before, after=after) for before, after in pairwise(trials)]
    steps.append(SimpleNamespace(before=trials[-1], after=None))

    added = graded_effects._steps_that_added_effects(steps, ("offset", "stribeck"))  # type: ignore[arg-type]

    assert added == [steps[1], steps[3]]


def test_an_effect_of_the_model_is_no_rival_of_another_one() -> None:
    own, spring, shape = (SimpleNamespace(name=name) for name in ("own", "steering_return", "shape"))
    step = SimpleNamespace(indistinguishable=(spring, shape))
    rivals = graded_effects._rivals_outside_model(step, (own, spring))  # type: ignore[arg-type]
    assert rivals == ("shape",)
