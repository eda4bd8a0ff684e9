"""Work in processes and with executors of the user's, and what is said where it fails."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from identification import Recording, diagnose, search
from identification.selection.trial_runner import workers
from symbolic import BrushgripError, Effect, InvalidInputError, Parameter
from tests.identification.factories import read_campaign, with_torque
from tests.refusal import refused

BOOT = """
from dataclasses import dataclass
from symbolic import Effect, Parameter

@dataclass(frozen=True, kw_only=True)
class Boot(Effect):
    name: str = "boot"
    summary: str = "a spring by the cube of the angle"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m", neutral=0.0, start=1.0, lower=0.0, upper=1e3, scale=10.0),
    )

    def torque(self, signals, values):
        return -values["c"] * signals.psi**3

EFFECTS = [Boot()]
"""
SEARCH = """
from identification import search
from symbolic import InvalidInputError
try:
    search([], (), jobs=2, candidates=EFFECTS)
except InvalidInputError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Recordings of a rig with a boot of 150 N m/rad^3."""
    plain = read_campaign(None, 3, duration=8.0)[1]
    return [with_torque(recording, recording.M_z - 150 * recording.psi**3) for recording in plain]


@pytest.fixture
def boot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The user's module, imported from a folder on the path."""
    (tmp_path / "ownboot.py").write_text(BOOT)
    monkeypatch.syspath_prepend(tmp_path)
    yield import_module("ownboot")
    del sys.modules["ownboot"]


@pytest.mark.long
@pytest.mark.usefixtures("interpreted")
def test_an_effect_of_a_users_module_goes_to_the_processes(
    boot: ModuleType, recordings: list[Recording]
) -> None:
    (one,) = diagnose(recordings, jobs=2, candidates=boot.EFFECTS).effects

    assert one.name == "boot"
    assert one.parameters["c"].value == pytest.approx(150, rel=0.1)


@pytest.mark.long
@pytest.mark.usefixtures("interpreted")
def test_a_process_that_ends_takes_one_line(
    boot: ModuleType, recordings: list[Recording], tmp_path: Path
) -> None:
    (tmp_path / "ownboot.py").unlink()
    with pytest.raises(
        BrushgripError,
        match=r"a process of the search ended .*cannot import.*ModuleNotFoundError.*jobs=1",
    ) as caught:
        search(recordings, (), jobs=2, candidates=boot.EFFECTS)
    assert not isinstance(caught.value, InvalidInputError)
    assert "\n" not in str(caught.value)


@dataclass(frozen=True, kw_only=True)
class Field(Effect):
    """An effect with a field of any kind."""

    name: str = "field"
    summary: str = "a field"
    parameters: tuple[Parameter, ...] = ()
    content: Any = None


def test_a_local_class_and_a_field_that_cannot_be_pickled_are_refused() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Local(Field):
        """A class that only this function knows."""

    for effect in (Local(), Field(content=lambda x: x)):
        message = refused(search, [], (), jobs=2, candidates=[effect])
        assert message.startswith("effect 'field' cannot be taken to the processes of the")
        assert "put the effect into a module of its own, or use jobs=1" in message


@pytest.mark.long
def test_a_class_of_a_main_module_without_a_file_is_refused(repository_root: Path) -> None:
    for how, text in (["-c", BOOT + SEARCH], None), (["-"], BOOT + SEARCH):
        ended = subprocess.run(
            [sys.executable, *how], input=text, cwd=repository_root, capture_output=True, text=True
        )
        assert ended.stdout.startswith("effect 'boot' cannot be taken to the processes"), ended.stderr
        assert "put the effect into a module of its own, or use jobs=1" in ended.stdout


FEW = ("torque_offset", "contact_damping", "steering_return")


class Losing(Executor):
    """Loses whatever it is given."""

    def submit(self, *_: Any, **__: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.cancel()
        return future


def test_an_executor_stands_in_for_processes() -> None:
    with ThreadPoolExecutor(1) as pool:
        with workers(None, (), pool) as submit:
            assert submit(pow, 2, 10).result() == 1024
        assert pool.submit(pow, 2, 3).result() == 8  # It is left open.


def test_work_that_an_executor_loses_is_said() -> None:
    with (
        pytest.raises(BrushgripError, match="the executor lost work that it was given: CancelledError"),
        workers(None, (), Losing()) as submit,
    ):
        submit(pow, 2, 10).result()


def test_what_has_not_begun_is_cancelled() -> None:
    future: Future[int] = Future()

    class Sleeping(Executor):
        def submit(self, *_: Any, **__: Any) -> Future[Any]:
            return future

    def interrupted() -> None:
        with workers(None, (), Sleeping()) as submit:
            submit(pow, 2, 10)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert future.cancelled()


def test_an_executor_has_processes_of_its_own() -> None:
    with (
        ThreadPoolExecutor(1) as pool,
        pytest.raises(InvalidInputError, match="leave jobs out"),
        workers(2, (), pool),
    ):
        pass


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Two workers of Dask, each a process."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local


@pytest.mark.long
@pytest.mark.parametrize("killed", [False, True])
def test_a_cluster_finds_the_same_to_the_last_digit(
    cluster: Any, damped: list[Recording], killed: bool
) -> None:
    alone, victims = diagnose(damped, candidates=FEW, jobs=1), []

    def kill(_: str, done: int, total: int) -> None:
        if killed and not victims and 0 < done < total:
            victims.extend(client.run(os.getpid).values())
            os.kill(victims[0], signal.SIGKILL)

    with cluster.get_client() as client, client.get_executor() as executor:
        result = diagnose(damped, candidates=FEW, executor=executor, progress=kill)

    assert bool(victims) == killed
    assert result.effects
    assert result.to_dict() == alone.to_dict()
