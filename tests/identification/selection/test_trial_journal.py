"""An interrupted search goes on where it was, and comes to the same."""

import hashlib
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from identification import Journal, Recording, search
from identification.fits.loss import Huber
from identification.selection.trial import RANKING, Trial, TrialTask, run_trial
from identification.selection.trial_journal import DIGEST
from symbolic import Effect, Parameter, Signals, effects_named
from symbolic.effects.base import Expression, Values
from tests.identification.factories import with_torque

pytestmark = pytest.mark.usefixtures("interpreted")

CANDIDATES = ("contact_damping", "steering_return", "torque_offset")


@pytest.fixture
def journal(tmp_path: Path) -> Journal:
    return Journal(folder=tmp_path / "kept")


def same(one: Trial, other: Trial) -> bool:
    fits = [(one.fitted, other.fitted)]
    if one.held_out and other.held_out:
        fits.append((one.held_out, other.held_out))
    return (one.effects, one.nrmse) == (other.effects, other.nrmse) and all(
        a.values == b.values
        and (a.model, a.labels, a.status, a.converged) == (b.model, b.labels, b.status, b.converged)
        and np.array_equal(a.jacobian, b.jacobian)
        and all(np.array_equal(a.residuals[n], b.residuals[n], equal_nan=True) for n in b.residuals)
        for a, b in fits
    )


@pytest.mark.parametrize("held_out", [False, True])
def test_a_trial_comes_back_as_it_was(damped: list[Recording], journal: Journal, held_out: bool) -> None:
    training, holdout = (damped[:1], damped[1:]) if held_out else (damped, [])
    task = TrialTask(effects_named(["torque_offset"]), training, holdout, None, RANKING)
    made = run_trial(task)
    assert journal.recall(task) is None
    journal.note(task, made)
    kept = journal.recall(task)

    assert kept is not None
    assert same(kept, made)


def test_another_task_is_another_trial(damped: list[Recording], journal: Journal) -> None:
    task = TrialTask(effects_named(["torque_offset"]), damped)
    made = run_trial(task)
    journal.note(task, made)

    nudged = [with_torque(damped[0], damped[0].M_z + 1e-9), damped[1]]
    softer = [replace(damped[0], tyre=replace(damped[0].tyre, k=0.9 * damped[0].tyre.k)), damped[1]]
    for other in (
        replace(task, effects=effects_named(["contact_damping"])),
        replace(task, training=nudged),
        replace(task, training=softer),
        replace(task, training=damped[:1], holdout=damped[1:]),
        replace(task, start=made.fitted.values),
        replace(task, precision=RANKING),
        replace(task, loss=Huber(threshold=0.01)),
    ):
        assert journal.recall(other) is None
    assert journal.recall(task) is not None


@dataclass(frozen=True, kw_only=True)
class Spring(Effect):
    """A user's effect: a torque by a power of the angle."""

    name: str = "spring"
    summary: str = "a spring"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="1", neutral=0.0, start=0.1, lower=0.0, upper=9.0, scale=1.0),
    )
    power: int = 3

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Torque of the spring [N m]."""
        return -values["c"] * signals.psi**self.power


class Edited(Spring):
    """The same name and fields after its formula was changed."""

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Torque of the spring [N m]."""
        return -values["c"] * ca.sin(signals.psi) ** self.power


Edited.__qualname__ = Spring.__qualname__


def test_effects_of_one_name_are_different_trials(damped: list[Recording], journal: Journal) -> None:
    task = TrialTask((Spring(),), damped, precision=RANKING)
    journal.note(task, run_trial(task))

    (parameter,) = Spring().parameters
    narrower, wider = replace(parameter, upper=5.0), replace(parameter, upper=2 * parameter.upper)
    others = [Spring(parameters=(one,)) for one in (narrower, wider)]
    for other in (Edited(), Spring(power=1), *others):
        assert other.name == "spring"
        assert repr(other).startswith("Spring(")
        assert journal.recall(replace(task, effects=(other,))) is None
    assert journal.recall(replace(task, effects=(Spring(),))) is not None


def test_what_cannot_be_read_is_made_anew(damped: list[Recording], journal: Journal) -> None:
    """Cut off, no archive at all, or sealed and nothing of a trial in it."""
    task = TrialTask((), damped)
    journal.note(task, run_trial(task))
    (path,) = journal.folder.iterdir()
    empty = io.BytesIO()
    np.savez(empty, texts="[]")
    for content in (b"", path.read_bytes()[:500], b"no archive", sealed(path, empty.getvalue())):
        path.write_bytes(content)
        assert journal.recall(task) is None


def sealed(path: Path, content: bytes) -> bytes:
    return hashlib.sha256(path.stem.encode() + content).digest() + content


def test_altered_values_are_made_anew(damped: list[Recording], journal: Journal) -> None:
    task = TrialTask(effects_named(["torque_offset"]), damped, precision=RANKING)
    journal.note(task, run_trial(task))
    (path,) = journal.folder.iterdir()
    whole = path.read_bytes()
    with np.load(io.BytesIO(whole[DIGEST:])) as kept:
        arrays = dict(kept)
    altered = io.BytesIO()
    np.savez(altered, **{**arrays, "0/jacobian": 1.1 * arrays["0/jacobian"]})
    other = path.with_stem("0" * 32)
    path.rename(other)
    for content in (whole[:DIGEST] + altered.getvalue(), altered.getvalue()):
        path.write_bytes(content)
        assert journal.recall(task) is None
    other.write_bytes(sealed(other, whole[DIGEST:]))
    other.replace(path)
    assert journal.recall(task) is None, "it is of another task"
    path.write_bytes(sealed(path, whole[DIGEST:]))
    assert journal.recall(task) is not None
    path.write_bytes(sealed(path, altered.getvalue()))
    assert journal.recall(task) is not None, "only the digest tells"


def test_it_is_said_once_where_nothing_can_be_kept(
    damped: list[Recording], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    journal = Journal(folder=tmp_path / "file")
    task = TrialTask((), damped, precision=RANKING)
    made = run_trial(task)
    journal.note(task, made)
    journal.note(task, made)

    (line,) = caplog.messages
    assert "file: what is found cannot be kept: " in line


@dataclass(frozen=True, kw_only=True)
class Line(Spring):
    """An effect whose second parameter is given by the recordings."""

    parameters: tuple[Parameter, ...] = (
        *Spring().parameters,
        replace(Spring().parameters[0], name="F_0", neutral=None, upper=1e4, fixed=True),
    )

    def fixed_values(self, a: Sequence[float], F_N: Sequence[float]) -> dict[str, float]:
        """The mean load."""
        del a
        return {"F_0": float(np.mean(F_N))}


class OtherLine(Line):
    """The same Functions, and another value of the parameter that is given."""

    def fixed_values(self, a: Sequence[float], F_N: Sequence[float]) -> dict[str, float]:
        """The least load."""
        del a
        return {"F_0": 0.5 * float(np.min(F_N))}


OtherLine.__qualname__ = Line.__qualname__


def test_another_value_of_recordings_is_another_trial(damped: list[Recording], journal: Journal) -> None:
    task = TrialTask((Line(),), damped, precision=RANKING)
    journal.note(task, run_trial(task))

    assert journal.recall(task) is not None
    assert journal.recall(replace(task, effects=(OtherLine(),))) is None


@pytest.mark.long
def test_goes_on_after_an_interruption(
    damped: list[Recording], journal: Journal, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = search(damped, (), jobs=1, candidates=CANDIDATES)
    made: list[TrialTask] = []

    def counting(task: TrialTask, threads: int = 1) -> Trial:
        made.append(task)
        return run_trial(task, threads)

    def interrupt(message: str, done: int, total: int) -> None:
        del message, total
        if done == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr("identification.selection.trial_runner.run_trial", counting)
    with pytest.raises(KeyboardInterrupt):
        search(damped, (), jobs=1, candidates=CANDIDATES, journal=journal, progress=interrupt)
    before = len(made)
    resumed = search(damped, (), jobs=1, candidates=CANDIDATES, journal=journal)
    in_all = len(made)
    search(damped, (), jobs=1, candidates=CANDIDATES, journal=journal)

    assert before > 2
    assert len(made) == in_all
    assert len({id(task) for task in made}) == in_all
    assert len(resumed) == len(whole)
    for one, other in zip(resumed, whole, strict=True):
        assert [t.effects for t in one.trials] == [t.effects for t in other.trials]
        assert all(same(a, b) for a, b in zip(one.trials, other.trials, strict=True))
        assert same(one.before, other.before)
