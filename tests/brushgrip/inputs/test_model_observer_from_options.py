"""The observer that a command line names."""

from pathlib import Path

import pytest

from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.inputs.model_observer_from_options import model_observer_from_options
from symbolic import FoundModel, Model, ModelBasis, effects_named
from tests.brushgrip.helpers import write_model

ONE = Model(effects=effects_named(["carcass_torsion"]))


@pytest.mark.parametrize(
    ("found", "torque", "asked", "is_state"),
    [
        (True, "M_z", None, True), (True, "M_z", False, False), (True, "M", None, False),
        (False, "M_z", None, False), (False, "M_z", True, True), (False, "M", False, False),
    ],
)  # fmt: skip
def test_k_is_a_state_by_a_model_found_where_nothing_is_asked_for(
    steering_rig: Path, found: bool, torque: str, asked: bool | None, is_state: bool
) -> None:
    model = write_model({"carcass_torsion.k_t": 390.0}) if found else None
    inputs = gather_inputs(rig=steering_rig, model=model)
    observer = model_observer_from_options("ekf", torque, inputs, None, stiffness_state=asked)

    assert ("stiffness" in observer.states) == is_state


def test_a_car_has_its_own_states(repository_root: Path) -> None:
    car = repository_root / "examples" / "vehicles" / "small_car.toml"

    assert "gear" in model_observer_from_options("ekf", "M_z", gather_inputs(vehicle=car), None).states


def test_a_model_that_explains_nothing_surpasses_no_declared_one() -> None:
    nothing = ModelBasis(training=2, holdout=0, grades={"carcass_torsion": "weak"}, unexplained=True)
    surpasses = [
        FoundModel(model=model, tyre={"k": 2e6}, own={}, basis=basis).surpasses_declared
        for model, basis in ((Model(), None), (ONE, None), (ONE, nothing))
    ]

    assert surpasses == [False, True, False]
