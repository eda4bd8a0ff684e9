"""The cost that is told beforehand is that of the counts of benchmarks/embedded.py."""

from dataclasses import replace
from typing import Any

import pytest

from observers import AligningTorque, Ekf
from observers.embedded import DOUBLE
from observers.embedded.cost import ERROR, VECTORS, estimated_cost
from tests.observers.embedded.generated_code import FOUND, observer_named, observer_of


@pytest.mark.parametrize(
    ("name", "counted"),
    [
        ("ekf declared aligning", 1_138),
        ("ekf declared steering", 1_347),
        ("mhe declared aligning", 27_810),
        ("ekf effects aligning", 9_813),
        ("ekf effects steering", 10_364),
        ("mhe effects aligning", 26_017),
        ("ekf found aligning", 10_051),
        ("ekf found steering", 12_611),
        ("mhe found aligning", 26_244),
    ],
)
def test_a_count_is_estimated(name: str, counted: int) -> None:
    alone = estimated_cost(observer_named(name, acquire=False))

    assert alone.instructions == pytest.approx(counted, rel=ERROR)
    assert (alone.error, alone.vectors, alone.acquiring) == (ERROR, False, 0)


@pytest.mark.parametrize(
    ("name", "counted"),
    [
        ("ekf declared aligning", 1_787),
        ("ekf declared steering", 2_111),
        ("mhe declared aligning", 31_412),
    ],
)
def test_what_acquiring_friction_takes_is_told_apart(name: str, counted: int) -> None:
    cost = estimated_cost(observer_named(name))

    assert cost.instructions == pytest.approx(counted, rel=ERROR)
    assert "up to 13,200 more while friction is acquired" in str(cost)


@pytest.mark.parametrize(
    ("name", "tunable", "counted"),
    [
        ("ekf declared aligning", "tuning", 1_358),
        ("ekf declared aligning", "all", 1_413),
        ("mhe declared aligning", "all", 41_865),
        ("ekf found aligning", "tuning", 10_292),
        ("mhe found aligning", "tuning", 39_187),
    ],
)
def test_parameters_at_run_time_cost_more(name: str, tunable: Any, counted: int) -> None:
    cost = estimated_cost(observer_named(name, acquire=False), tunable=tunable)

    assert cost.instructions == pytest.approx(counted, rel=ERROR)


def test_a_model_with_effects_is_dear_at_run_time() -> None:
    cost = estimated_cost(observer_of(Ekf, FOUND, AligningTorque()), tunable="all")

    assert (cost.vectors, cost.instructions) == (True, VECTORS)
    assert "the tuning alone" in str(cost)


def test_what_is_not_known_is_not_told() -> None:
    double = estimated_cost(observer_named("ekf declared aligning"), DOUBLE)
    window = estimated_cost(observer_named("mhe declared steering"))
    vectors = estimated_cost(observer_named("mhe effects aligning,k"))
    iterated = estimated_cost(replace(observer_named("ekf declared aligning"), iterations=2))

    assert double.error is None
    assert "of the order of" in str(double)
    assert window.instructions is None
    assert "were not counted" in str(window)
    assert (vectors.vectors, vectors.instructions) == (True, VECTORS)
    assert "a stiffness that is known" in str(vectors)
    assert "one iteration is written as loops" in str(iterated)
