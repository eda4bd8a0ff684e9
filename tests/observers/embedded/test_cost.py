"""The cost that is said beforehand is that of the benchmark's counts."""

from typing import Any

import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE
from observers.embedded.cost import ERROR, VECTORS, estimated_cost
from symbolic import Model, effects_named
from tests.observers.conftest import K
from tests.observers.embedded.generated_code import DECLARED, EFFECTS, observer_of

_NAMES = ["frictional_creep", "carcass_torsion", "asymmetric_friction"]
FOUND: dict[str, Any] = {
    "model": Model(effects=effects_named(_NAMES)),
    "values": {
        "k": K,
        "frictional_creep.c": 0.1,
        "carcass_torsion.k_t": 300.0,
        "asymmetric_friction.ratio": 1.1,
    },
}


@pytest.mark.parametrize(
    ("kind", "model", "measured", "counted"),
    [
        (Ekf, DECLARED, AligningTorque(), 1_205),
        (Ekf, DECLARED, SteeringTorque(), 1_458),
        (Mhe, DECLARED, AligningTorque(), 31_826),
        (Ekf, EFFECTS, AligningTorque(), 9_871),
        (Ekf, EFFECTS, SteeringTorque(), 10_370),
        (Mhe, EFFECTS, AligningTorque(), 26_450),
        (Ekf, FOUND, AligningTorque(), 11_906),
        (Ekf, FOUND, SteeringTorque(), 13_800),
        (Mhe, FOUND, AligningTorque(), 28_882),
    ],
)
def test_a_count_is_estimated(kind: Any, model: Any, measured: Any, counted: int) -> None:
    alone = estimated_cost(observer_of(kind, model, measured, acquire=False))

    assert alone.instructions == pytest.approx(counted, rel=ERROR)
    assert (alone.error, alone.vectors, alone.acquiring) == (ERROR, False, 0)


@pytest.mark.parametrize(
    ("kind", "measured", "counted"),
    [
        (Ekf, AligningTorque(), 1_838),
        (Ekf, SteeringTorque(), 2_319),
        (Mhe, AligningTorque(), 32_462),
    ],
)
def test_acquiring_friction_is_said_apart(kind: Any, measured: Any, counted: int) -> None:
    cost = estimated_cost(observer_of(kind, DECLARED, measured))

    assert cost.instructions == pytest.approx(counted, rel=ERROR)
    assert "up to 14,500 more while friction is acquired" in str(cost)


@pytest.mark.parametrize(
    ("kind", "model", "tunable", "counted"),
    [
        (Ekf, DECLARED, "tuning", 1_453),
        (Ekf, DECLARED, "all", 1_507),
        (Mhe, DECLARED, "all", 44_659),
        (Ekf, FOUND, "tuning", 12_142),
        (Mhe, FOUND, "tuning", 41_749),
    ],
)
def test_parameters_at_run_time_cost_more(kind: Any, model: Any, tunable: Any, counted: int) -> None:
    observer = observer_of(kind, model, AligningTorque(), acquire=False)
    cost = estimated_cost(observer, tunable=tunable)

    assert cost.instructions == pytest.approx(counted, rel=ERROR)


def test_a_model_with_effects_is_dear_at_run_time() -> None:
    cost = estimated_cost(observer_of(Ekf, FOUND, AligningTorque()), tunable="all")

    assert (cost.vectors, cost.instructions) == (True, VECTORS)
    assert "the tuning alone" in str(cost)


def test_what_is_not_known_is_not_said() -> None:
    double = estimated_cost(observer_of(Ekf, DECLARED, AligningTorque()), DOUBLE)
    window = estimated_cost(observer_of(Mhe, DECLARED, SteeringTorque()))
    vectors = estimated_cost(observer_of(Mhe, EFFECTS, AligningTorque(stiffness=True)))

    assert double.error is None
    assert "of the order of" in str(double)
    assert window.instructions is None
    assert "were not counted" in str(window)
    assert (vectors.vectors, vectors.instructions) == (True, VECTORS)
    assert "a stiffness that is known" in str(vectors)
