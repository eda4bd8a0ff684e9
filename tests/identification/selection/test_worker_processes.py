"""Processes that are killed, or whose parent is, and executors of the user's in their place."""

import atexit
import gc
import os
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from importlib import import_module
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

import pytest

from identification import Recording, diagnose
from identification.selection.trial_runner import worker_pool, worker_submitter
from identification.selection.worker_processes import WorkerProcesses
from symbolic import BrushgripError, InvalidInputError
from tests.processes import is_running, wait_for

needs_signals = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signals here")


def die(attempts: Path, times: int, half: bool) -> int:
    """Ends the process in its first attempts, in the middle of its answer or before it."""
    with attempts.open("a") as file:
        file.write("x")
    if len(attempts.read_text()) <= times:
        if half:
            for one in gc.get_objects():
                if isinstance(one, Connection) and not one.closed and one.writable:
                    os.write(one.fileno(), struct.pack("!i", 1000) + b"half")
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def raise_error(message: str) -> None:
    raise InvalidInputError(message)


def no_pickle() -> object:
    return lambda: None


@pytest.mark.long
@needs_signals
@pytest.mark.parametrize(
    "half",
    [pytest.param(False, marks=pytest.mark.long, id="before its answer"), True],
)
def test_a_process_that_is_killed_is_replaced_once(tmp_path: Path, half: bool) -> None:
    with worker_submitter(2) as submit:
        once = submit(die, tmp_path / "once", 1, half)
        twice = submit(die, tmp_path / "twice", 2, half)
        assert once.result(60) > 0
        said = r"ended before its work was done \(signal 9\)"
        with pytest.raises(BrushgripError, match=said) as caught:
            twice.result(60)
        assert "\n" not in str(caught.value)
        assert submit(os.getpid).result(60) != os.getpid()
    assert (tmp_path / "twice").read_text() == "xx"


@needs_signals
def test_a_process_that_is_killed_while_it_starts_is_replaced() -> None:
    pool = WorkerProcesses(1)
    try:
        found = pool.submit(abs, -3)
        while not pool._running:
            time.sleep(0.001)
        (worker,) = pool._running
        os.kill(worker.process.pid or 0, signal.SIGKILL)
        assert found.result(60) == 3
    finally:
        pool.close()


def test_processes_begin_before_there_is_work_for_them() -> None:
    with worker_pool(2, start=9) as pool:
        assert pool is not None
        wait_for(lambda: len(pool._running) == 2)
        begun = {worker.process.pid for worker in pool._running}
        assert pool.submit(os.getpid).result(60) in begun


def test_a_module_that_is_found_after_a_process_has_begun_is_found_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "of_a_user.py").write_text("def own():\n    return 3\n")
    with worker_pool(2, start=2) as pool:
        assert pool is not None
        wait_for(lambda: len(pool._running) == 2)
        monkeypatch.syspath_prepend(tmp_path)
        assert pool.submit(import_module("of_a_user").own).result(60) == 3


@needs_signals
def test_a_process_that_cannot_be_started_is_tried_once_more(monkeypatch: pytest.MonkeyPatch) -> None:
    start, faults = SpawnProcess.start, [BrokenPipeError(32, "Broken pipe")]

    def start_badly(process: SpawnProcess) -> None:
        if faults:
            raise faults.pop()
        start(process)

    monkeypatch.setattr(SpawnProcess, "start", start_badly)
    with worker_submitter(2) as submit:
        assert submit(abs, -3).result(60) == 3
    faults.extend([BrokenPipeError(32, "Broken pipe")] * 2)
    with (
        worker_submitter(2) as submit,
        pytest.raises(BrushgripError, match="cannot be started, Broken pipe"),
    ):
        submit(abs, -3).result(60)


def test_errors_come_back_with_where_they_were_raised() -> None:
    with worker_submitter(2) as submit:
        with pytest.raises(InvalidInputError) as caught:
            submit(raise_error, "no good").result(60)
        assert str(caught.value) == "no good"
        assert "in raise_error" in caught.value.__notes__[0]
        with pytest.raises(BrushgripError, match="pickle"):
            submit(no_pickle).result(60)


@pytest.mark.long
@needs_signals
@pytest.mark.parametrize(
    "number", ["SIGKILL", *(pytest.param(n, marks=pytest.mark.long) for n in ("SIGTERM", "SIGINT"))]
)
def test_no_process_stays_without_its_parent(tmp_path: Path, repository_root: Path, number: str) -> None:
    code = (
        # As in a terminal: a shell starts what is in the background deaf to Ctrl-C.
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from identification.selection.trial_runner import worker_submitter\n"
        "from tests.identification.selection.test_worker_processes import busy\n"
        "with worker_submitter(2) as submit:\n"
        "    for _ in (submit(busy, sys.argv[1]), submit(busy, sys.argv[1])): _.result()\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    parent = subprocess.Popen(command, cwd=repository_root, stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: len(list(tmp_path.iterdir())) == 2)
        parent.send_signal(getattr(signal, number))
        parent.wait(20)
    finally:
        parent.kill()
    pids = [int(path.name) for path in tmp_path.iterdir()]

    try:
        wait_for(lambda: not any(is_running(pid) for pid in pids))
    finally:
        for pid in filter(is_running, pids):
            os.kill(pid, signal.SIGKILL)


def note_frozen(path: Path) -> None:
    """Notes at the end of the process whether what it holds will be collected."""
    atexit.register(lambda: path.write_text(str(gc.get_freeze_count() > 0)))


def test_a_process_ends_without_collecting(tmp_path: Path) -> None:
    with worker_submitter(2) as submit:
        submit(note_frozen, tmp_path / "frozen").result(60)
    assert (tmp_path / "frozen").read_text() == "True"


def busy(folder: str) -> None:
    """Computes for ever, and says who does."""
    (Path(folder) / str(os.getpid())).touch()
    while True:
        sum(range(100))


FEW = ("torque_offset", "contact_damping", "steering_return")


class Losing(Executor):
    """Loses whatever it is given."""

    def submit(self, *_: Any, **__: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.cancel()
        return future


def test_an_executor_stands_in_for_processes() -> None:
    with ThreadPoolExecutor(1) as pool:
        with worker_submitter(None, (), pool) as submit:
            assert submit(pow, 2, 10).result() == 1024
        assert pool.submit(pow, 2, 3).result() == 8  # It is left open.
    refused = pytest.raises(InvalidInputError, match="leave jobs out")
    with ThreadPoolExecutor(1) as pool, refused, worker_submitter(2, (), pool):
        pass


def test_work_that_an_executor_loses_is_said() -> None:
    lost = "the executor lost work that it was given: CancelledError"
    with pytest.raises(BrushgripError, match=lost), worker_submitter(None, (), Losing()) as submit:
        submit(pow, 2, 10).result()


def test_what_has_not_begun_is_cancelled() -> None:
    future: Future[int] = Future()

    class Sleeping(Executor):
        def submit(self, *_: Any, **__: Any) -> Future[Any]:
            return future

    def interrupted() -> None:
        with worker_submitter(None, (), Sleeping()) as submit:
            submit(pow, 2, 10)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert future.cancelled()


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Two workers of Dask, each a process."""
    distributed = pytest.importorskip("distributed")
    two = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**two) as local:
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
