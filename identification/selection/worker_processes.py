"""Worker processes, each with a pipe of its own.

Those of concurrent.futures send their results through one pipe that all share: where one is killed while
it sends, the reader waits for ever. Here a process that ends closes its pipe, and its work goes to a new
process, once. Every process ends when its parent has ended, whatever the cause.
"""

import gc
import logging
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from typing import Any

from symbolic import BrushgripError
from symbolic.compilation.operating_system import children_ignore_interrupts, send_sigterm_to_main_thread

GRACE = 3.0
"""Time that a process has to clean up before it is killed [s]."""
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""Variables that the libraries of linear algebra read once, when they are loaded."""
HEAP = {"MALLOC_MMAP_THRESHOLD_": str(2**25), "MALLOC_TRIM_THRESHOLD_": str(2**28)}
"""Variables of glibc [B]: the memory of arrays is kept for the next ones, and not cleared each time."""
ENDED = (
    "a process of the search ended before its work was done ({}): out of memory, or it cannot import"
    " the module of an own effect, or a script lacks 'if __name__ == \"__main__\":' before its calls;"
    " jobs=1 (--jobs 1) does without processes"
)


@contextmanager
def one_blas_thread_per_process() -> Iterator[None]:
    """Processes started within do their linear algebra in one thread: there is one for every core."""
    changed = {**dict.fromkeys(THREADS, "1"), **HEAP}
    before = {name: os.environ.get(name) for name in changed}
    os.environ.update(changed)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


class WorkerProcesses(Executor):
    """A pool of processes, started when there is work for them, or by `start`."""

    def __init__(self, count: int) -> None:
        """Nothing is started yet."""
        self.count = count
        self._threads = ThreadPoolExecutor(count)
        self._own = threading.local()
        self._lock = threading.Lock()
        self._running: set[_Worker] = set()
        self._closed = False

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The future of what a function of an importable module returns in one of the processes."""
        return self._threads.submit(self._call, partial(fn, **kwargs), args)

    def start(self, most: int) -> None:
        """Starts so many at most now: they import what they need while this one prepares their work."""
        for _ in range(min(most, self.count)):
            self.submit(os.getpid)

    def close(self) -> None:
        """End the processes at once; unfinished work is lost."""
        with self._lock:
            self._closed = True
        for worker in self._running:
            worker.process.terminate()
        for worker in self._running:
            worker.end_and_describe_exit()
        self._threads.shutdown(cancel_futures=True)

    def _call(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Run in a thread, which waits for its process; a process that ends is replaced once."""
        # A process may have begun before the user's own modules were found.
        request, reason = pickle.dumps((sys.path, pickle.dumps((function, arguments)))), ""
        for _ in range(2):
            try:
                worker = self._worker_of_thread()
            except OSError as error:  # It ended while it was started, or memory is short.
                reason = f"it cannot be started, {error.strerror or error}"
                continue
            try:
                done, result = worker.run_request(request)
            except (EOFError, OSError):
                reason = worker.end_and_describe_exit()
                del self._own.worker
                if worker.is_ready or worker.was_killed:
                    continue
                break  # A process that cannot begin will not begin the next time.
            if done:
                return result
            raise result
        raise BrushgripError(ENDED.format(reason))

    def _worker_of_thread(self) -> "_Worker":
        """The process of this thread."""
        if not hasattr(self._own, "worker"):
            with self._lock:
                if self._closed:
                    raise BrushgripError("the search was ended")
                self._own.worker = _Worker()
                self._running.add(self._own.worker)
        worker: _Worker = self._own.worker
        return worker


class _Worker:
    """A process and the pipe to it."""

    def __init__(self) -> None:
        context = get_context("spawn")
        self.connection, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        with children_ignore_interrupts():
            self.process.start()
        # From here on only the process holds the other end, and its end shows.
        other.close()
        self.is_ready = False

    def run_request(self, request: bytes) -> tuple[bool, Any]:
        """Whether the work was done, and its result or what it raised.

        Raises:
            EOFError, OSError: the process has ended.
        """
        if not self.is_ready:
            self.connection.recv_bytes()
            self.is_ready = True
        self.connection.send_bytes(request)
        answer: tuple[bool, Any] = pickle.loads(self.connection.recv_bytes())
        return answer

    @property
    def was_killed(self) -> bool:
        """Whether a signal ended it."""
        return (self.process.exitcode or 0) < 0

    def end_and_describe_exit(self) -> str:
        """Ends the process if it has not ended; says how it did."""
        self.process.join(GRACE)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()
        code = self.process.exitcode or 0
        return f"signal {-code}" if code < 0 else f"exit status {code}"


def _serve(connection: Connection) -> None:
    """Answer requests until the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # At SIGTERM it removes the files that it has begun to write.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    # A fault of all processes, such as a failing compiler, is reported by the first one alone.
    logging.getLogger("symbolic").setLevel(logging.ERROR)
    with suppress(EOFError, OSError, KeyboardInterrupt):
        connection.send_bytes(b"ready")
        while True:
            connection.send_bytes(_answer(connection.recv_bytes()))
    # Nothing is collected as the process ends, which would take half a second.
    gc.freeze()


def _end_with_parent() -> None:
    """Wait until the parent has ended, then end this process too."""
    parent = parent_process()
    if parent is None:
        return
    parent.join()
    if send_sigterm_to_main_thread():
        time.sleep(GRACE)
    os._exit(1)


def _answer(request: bytes) -> bytes:
    try:
        sys.path[:], call = pickle.loads(request)
        function, arguments = pickle.loads(call)
    except Exception as error:  # an import of the user's own may raise anything
        reason = f"cannot import what it should work on, {type(error).__name__}: {error}"
        return pickle.dumps((False, BrushgripError(ENDED.format(reason))))
    try:
        result = function(*arguments)
    except Exception as error:
        error.add_note(traceback.format_exc())
        with suppress(Exception):
            answer = pickle.dumps((False, error))
            pickle.loads(answer)
            return answer
        return _pickled_error(error)
    try:
        return pickle.dumps((True, result))
    except Exception as error:  # what cannot be pickled raises whatever it likes
        return _pickled_error(error)


def _pickled_error(error: Exception) -> bytes:
    return pickle.dumps((False, BrushgripError(f"{type(error).__name__}: {error}")))
