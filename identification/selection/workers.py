"""Work spread over processes; one job runs in this process."""

import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""What the libraries of linear algebra read once, when they are loaded."""
Submit = Callable[..., Future[Any]]
"""Takes a function and its arguments, returns the future of what it makes."""


@contextmanager
def workers(jobs: int | None) -> Iterator[Submit]:
    """A way to submit work.

    An interruption stops what waits in the queue; what runs is finished first, in seconds.

    Args:
        jobs: processes; None for one per core.
    """
    count = jobs or os.cpu_count() or 1
    if count == 1:
        yield _at_once
        return
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_deaf)
    with _one_thread_each():
        try:
            yield pool.submit
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes started within do their linear algebra in one thread: there is one for every core."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _deaf() -> None:
    """Ctrl-C reaches every process of the terminal; only the first one may act on it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _at_once(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
    future: Future[Any] = Future()
    future.set_result(function(*arguments))
    return future
