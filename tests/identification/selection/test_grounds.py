"""What belongs to a ground: found where it differs, offered only where it can show."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from identification import Diagnosis, Recording, diagnose
from identification.selection.criteria import DEFAULT_CRITERIA
from identification.selection.stepwise_search import Search, silent
from identification.selection.trial_runner import TrialRunner
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from symbolic import EFFECTS, GROUND_SCOPES, effects_named
from tests.identification.factories import recording

pytestmark = pytest.mark.usefixtures("interpreted")
CREEP = {"steel": 0.07, "emery": 0.03}


def changes(grounds: tuple[str | None, ...], present: list[str], effect: str) -> bool:
    training = [recording(f"r{i}", ground) for i, ground in enumerate(grounds)]
    runner = cast(TrialRunner, SimpleNamespace(training=training))
    search: Any = Search(runner, (), DEFAULT_CRITERIA, silent)
    return bool(search._changes(effects_named(present), (EFFECTS | GROUND_SCOPES)[effect]))


def test_grounds_are_tried_where_two_are_named_and_something_is_theirs() -> None:
    assert changes(("steel", "emery"), [], "stiffness_by_ground")
    assert changes(("steel", "emery"), ["stribeck"], "friction_by_ground")
    assert not changes(("steel", "emery"), ["carcass_torsion"], "friction_by_ground")
    assert not changes(("steel", "steel"), [], "stiffness_by_ground")
    assert not changes(("steel", None), [], "stiffness_by_ground")
    assert changes((None, None), ["stiffness_by_ground"], "carcass_torsion")


def campaign(creep: dict[str, float]) -> list[Recording]:
    made = [
        make_recording(
            20 + i,
            {"frictional_creep": {"c": creep[ground]}},
            mu={"steel": 1.2, "emery": 1.5}[ground],
            duration=10.0,
            name=f"r{i}",
        )
        for i, ground in enumerate(("steel", "emery") * 2)
    ]
    grounds = ("steel", "emery") * 2
    return [replace(as_read(r, RigTyre()), ground=g) for r, g in zip(made, grounds, strict=True)]


def found(creep: dict[str, float]) -> Diagnosis:
    candidates = ["frictional_creep", "friction_by_ground", "stiffness_by_ground"]
    return diagnose(campaign(creep), candidates=candidates, jobs=1)


@pytest.mark.long
def test_a_law_of_friction_that_differs_by_ground_is_named() -> None:
    creep, ground = found(CREEP).effects

    assert (creep.name, ground.name) == ("frictional_creep", "friction_by_ground")
    assert (creep.scope, ground.scope) == ("ground", "ground")
    assert creep.parameters.keys() == {"c [steel]", "c [emery]"}
    for name, c in CREEP.items():
        assert creep.parameters[f"c [{name}]"].value == pytest.approx(c, rel=0.15)
        assert f"frictional_creep.c [{name}]" in ground.parameters
    assert ground.delta_bic < 0


@pytest.mark.long
def test_a_law_of_friction_that_is_the_same_everywhere_belongs_to_no_ground() -> None:
    (creep,) = found({"steel": 0.05, "emery": 0.05}).effects

    assert (creep.name, creep.scope) == ("frictional_creep", "tyre")
