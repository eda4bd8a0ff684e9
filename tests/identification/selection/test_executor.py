"""Work handed to executors of the user's: the same digits, whatever happens to those who do it."""

import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any

import pytest

from identification import Diagnosis, Recording, diagnose
from identification.selection.trial_runner import workers
from symbolic import BrushgripError, InvalidInputError
from tests.identification.factories import read_campaign

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


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return read_campaign("contact_damping", 3, duration=8.0)[1]


@pytest.fixture(scope="module")
def alone(recordings: list[Recording]) -> Diagnosis:
    return diagnose(recordings, candidates=FEW, jobs=1)


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
    cluster: Any, recordings: list[Recording], alone: Diagnosis, killed: bool
) -> None:
    victims = []

    def kill(_: str, done: int, total: int) -> None:
        if killed and not victims and 0 < done < total:
            victims.extend(client.run(os.getpid).values())
            os.kill(victims[0], signal.SIGKILL)

    with cluster.get_client() as client, client.get_executor() as executor:
        result = diagnose(recordings, candidates=FEW, executor=executor, progress=kill)

    assert bool(victims) == killed
    assert result.effects
    assert result.to_dict() == alone.to_dict()
