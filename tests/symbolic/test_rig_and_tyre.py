import math
from typing import Any

import pytest

from symbolic import BrushgripError, InvalidInputError, Rig, Tolerances, Tyre, with_usual_tolerances
from tests.refusal import refused

RIG: dict[str, Any] = {"a": 0.04, "e": 0.009}


@pytest.mark.parametrize(
    "values",
    [
        {"e": 0.0}, {"e": -0.039}, {"b_t": 0.0}, {"J_A": 1e-6}, {"J_A": 1e4}, {"b_t": 1e4}, {"a": 1.0},
        {"slide_rate": 1e-9},
    ],
)  # fmt: skip
def test_the_whole_range_is_allowed(values: dict[str, Any]) -> None:
    assert Rig(**RIG | values) is not None


@pytest.mark.parametrize(
    "values",
    [
        {"a": 0.0}, {"a": -0.04}, {"a": math.nan}, {"a": math.inf}, {"a": 9.9e-4, "e": 0.0},
        {"a": 1.01}, {"e": 0.04}, {"e": -0.04}, {"e": math.nan}, {"J_A": 0.0}, {"J_A": 9.9e-7},
        {"J_A": 1.01e4}, {"J_A": math.nan}, {"b_t": -1e-9}, {"b_t": math.nan}, {"b_t": 1.01e4},
        {"b_t": math.inf}, {"slide_rate": 0.0}, {"slide_rate": math.nan},
    ],
)  # fmt: skip
def test_rig_refuses(values: dict[str, Any]) -> None:
    message, name = refused(Rig, **RIG | values), next(iter(values))

    assert message.startswith(f"{name} must")
    assert f"got {values[name]:g}" in message


@pytest.mark.parametrize(
    "values", [{"k": 0.0}, {"k": -1.0}, {"k": math.nan}, {"mu": 0.0}, {"mu": math.nan}]
)
def test_tyre_refuses(values: dict[str, Any]) -> None:
    (name,) = values
    with pytest.raises(InvalidInputError, match=f"^{name} must be a finite number greater than 0"):
        Tyre(**{"k": 6e4} | values)


def test_invalid_input_is_a_value_error_of_the_one_tree() -> None:
    assert issubclass(InvalidInputError, BrushgripError)
    assert issubclass(InvalidInputError, ValueError)


def test_usual_tolerances_stand_where_none_is_declared() -> None:
    usual = with_usual_tolerances(Rig(a=0.045, e=0.009)).tolerances
    assert usual == Tolerances(a=0.002, e=0.002, load=0.02)
    declared = Tolerances(a=0.0, e=0.003, load=0.0, zero=0.1, k=1e5)
    assert with_usual_tolerances(Rig(a=0.045, e=0.009, tolerances=declared)).tolerances == declared


def test_a_small_patch_keeps_its_kingpin_within_usual_tolerances() -> None:
    rig = with_usual_tolerances(Rig(a=0.010, e=0.009))
    assert 0 < rig.tolerances.tolerance_or_zero("a") == rig.tolerances.tolerance_or_zero("e") < 0.0005
