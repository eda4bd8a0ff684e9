"""Effects one at a time, the same in two processes; and what belongs to a ground, where it can show."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Diagnosis, Recording, diagnose, search
from identification.selection.criteria import recordings_allow
from identification.selection.search_step import SearchStep
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from symbolic import EFFECTS, GROUND_SCOPES, effects_named
from tests.identification.factories import recording

CANDIDATES = ("contact_damping", "steering_return", "torque_offset")


@pytest.fixture(scope="module")
def steps(damped: list[Recording]) -> list[SearchStep]:
    return search(damped, (), jobs=1, candidates=CANDIDATES)


def test_adds_one_effect_at_a_time(steps: list[SearchStep]) -> None:
    first, last = steps

    assert first.before.names == ()
    assert first.after is not None
    assert first.after.names == ("contact_damping",)
    assert {trial.names[-1] for trial in first.trials} == set(CANDIDATES)
    assert last.before.names == ("contact_damping",)
    assert last.after is None
    assert {trial.names for trial in last.trials} == {
        ("contact_damping", "steering_return"),
        ("contact_damping", "torque_offset"),
    }
    for step in steps:
        errors = [trial.nrmse for trial in step.trials]
        assert errors == sorted(errors)
    assert last.before.nrmse == pytest.approx(0.004, rel=0.1)


def test_reports_its_progress(damped: list[Recording]) -> None:
    said: list[tuple[str, int, int]] = []
    search(damped, (), jobs=1, candidates=CANDIDATES[:1], progress=lambda *news: said.append(news))

    assert said[0] == ("fitting the declared structure", 0, 1)
    assert ("trying effects on top of the declared structure", 1, 1) in said


def test_held_out_recordings_only_judge(damped: list[Recording]) -> None:
    training, held_out = damped
    first, *_ = search([training], [held_out], jobs=1, candidates=CANDIDATES[:2])

    assert first.after is not None
    assert first.after.names == ("contact_damping",)
    assert set(first.after.judgement.residuals) == {held_out.name}
    assert set(first.after.fitted.residuals) == {training.name}
    frozen = first.after.held_out
    assert frozen is not None
    assert frozen.values.tyre == first.after.fitted.values.tyre
    residual = frozen.residuals[held_out.name]
    assert first.after.nrmse == pytest.approx(np.sqrt(np.mean(residual**2)) / np.ptp(held_out.M_z))


CREEP = {"steel": 0.07, "emery": 0.03}


def changes(grounds: tuple[str | None, ...], present: list[str], effect: str) -> bool:
    training = [recording(f"r{i}", ground) for i, ground in enumerate(grounds)]
    return recordings_allow((EFFECTS | GROUND_SCOPES)[effect], effects_named(present), training)


def test_grounds_are_tried_where_two_are_named_and_something_is_theirs() -> None:
    assert changes(("steel", "emery"), [], "stiffness_by_ground")
    assert changes(("steel", "emery"), ["stribeck"], "friction_by_ground")
    assert not changes(("steel", "emery"), ["carcass_torsion"], "friction_by_ground")
    assert not changes(("steel", "steel"), [], "stiffness_by_ground")
    assert not changes(("steel", None), [], "stiffness_by_ground")
    assert changes((None, None), ["stiffness_by_ground"], "carcass_torsion")


def campaign(creep: dict[str, float]) -> list[Recording]:
    made, mu = [], {"steel": 1.2, "emery": 1.5}
    for i, ground in enumerate(("steel", "emery") * 2):
        planted = {"frictional_creep": {"c": creep[ground]}}
        one = make_recording(20 + i, planted, mu=mu[ground], duration=10.0, name=f"r{i}")
        made.append(replace(as_read(one, RigTyre()), ground=ground))
    return made


def found(creep: dict[str, float]) -> Diagnosis:
    candidates = ["frictional_creep", "friction_by_ground", "stiffness_by_ground"]
    return diagnose(campaign(creep), candidates=candidates, jobs=1)


@pytest.mark.long
@pytest.mark.usefixtures("interpreted")
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
@pytest.mark.usefixtures("interpreted")
def test_a_law_of_friction_that_is_the_same_everywhere_belongs_to_no_ground() -> None:
    (creep,) = found({"steel": 0.05, "emery": 0.05}).effects

    assert (creep.name, creep.scope) == ("frictional_creep", "tyre")
