import numpy as np
import pytest

from identification import Recording, search
from identification.selection.search_step import SearchStep

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


@pytest.mark.long
def test_two_processes_find_the_same(damped: list[Recording], steps: list[SearchStep]) -> None:
    again = search(damped, (), jobs=2, candidates=CANDIDATES)

    assert len(again) == len(steps)
    for one, other in zip(again, steps, strict=True):
        assert [t.effects for t in one.trials] == [t.effects for t in other.trials]
        assert [t.nrmse for t in one.trials] == [t.nrmse for t in other.trials]
        assert one.indistinguishable == other.indistinguishable
        assert one.before.fitted.values == other.before.fitted.values


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
