"""Calls that not every operating system has, and what stands in for each: the only file that makes them.

On Windows a folder has no lock and no owner, a process no group and no limit of memory. What rests on
these is left out there: abandoned temporary folders stay, and a cache is trusted as it is. The alarms of
`brushgrip.running.interrupts` stand there, as it has to be ready before all of this is imported.
"""

import ctypes
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

IS_WINDOWS = sys.platform == "win32"
LIBRARY_SUFFIX = ".dll" if IS_WINDOWS else ".so"
COMPILERS = ("clang", "gcc", "clang-cl", "cl") if IS_WINDOWS else ("cc",)
"""Names that a C compiler usually has."""

if sys.platform != "win32":
    import fcntl
    import resource
    from multiprocessing import resource_tracker


def lock_folder(folder: str | os.PathLike[str]) -> int | None:
    """Locks a folder; returns the descriptor, None where the system has no such locks.

    Raises:
        BlockingIOError: another process has locked it.
        OSError: it is not there, or no folder, or the file system has no locks.
    """
    if sys.platform == "win32":
        return None
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def user_id() -> int | None:
    """By which the files of this user are known, None where files have no owner."""
    return os.geteuid() if hasattr(os, "geteuid") else None


def kill_process_group(process: "subprocess.Popen[bytes]") -> None:
    """Kills a process that began a session, with all that it has started; at least that process."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


def cpuinfo_value(field: str) -> str:
    """Value of a field of Linux's description of the processor; empty where it has none."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:  # noqa: PTH123
            fields = [line.partition(":") for line in file]
    except OSError:
        return ""
    return next((value.strip() for name, _, value in fields if name.strip() == field), "")


@contextmanager
def children_ignore_interrupts() -> Iterator[None]:
    """Processes started within ignore Ctrl-C; only the first process acts on it."""
    if sys.platform == "win32":
        # Children inherit this, and not what `signal` sets.
        console = ctypes.windll.kernel32.SetConsoleCtrlHandler
        console(None, True)
        try:
            yield
        finally:
            console(None, False)
        return
    # Python would start it with the first process, and unblock Ctrl-C for that one.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def send_sigterm_to_main_thread() -> bool:
    """Has the main thread act on SIGTERM, whatever it waits for; False where nobody can."""
    if sys.platform == "win32":
        return False
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)
    return True


class MemoryLimit:
    """A limit of the memory of this process, lowered while at least one thread asks for it.

    On Linux alone: the address space is bounded, so that it holds for libraries in C too.
    """

    def __init__(self, most: int) -> None:
        """`most` bytes beyond what the process has when the first thread asks."""
        self.most, self._lock, self._threads, self._usual = most, threading.Lock(), 0, (0, 0)
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._reset_after_fork)

    @contextmanager
    def lowered(self) -> Iterator[None]:
        """Limits the memory of the code inside; beyond the limit it gets MemoryError."""
        if sys.platform != "linux":
            yield
            return
        with self._lock:
            self._threads += 1
            if self._threads == 1:
                self._lower()
        try:
            yield
        finally:
            with self._lock:
                self._threads -= 1
                if self._threads == 0:
                    resource.setrlimit(resource.RLIMIT_AS, self._usual)

    def _lower(self) -> None:
        if sys.platform != "win32":
            self._usual = soft, hard = resource.getrlimit(resource.RLIMIT_AS)
            with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
                pages = int(file.read().split()[0])
            wanted = pages * resource.getpagesize() + self.most
            if soft == resource.RLIM_INFINITY or wanted < soft:
                resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))

    def _reset_after_fork(self) -> None:
        """A child has none of the other threads: their limit and lock would stay for ever."""
        if sys.platform == "linux" and self._threads:
            resource.setrlimit(resource.RLIMIT_AS, self._usual)
        self._lock, self._threads = threading.Lock(), 0
