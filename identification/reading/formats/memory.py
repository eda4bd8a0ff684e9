"""A bound on the memory that libraries may take for what a file only declares."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform == "linux":
    import resource

MOST_MEMORY = 4_000_000_000
"""Beyond what the process has when it opens a file [bytes]."""


class _Limit:
    """The limit of the process, lowered while at least one thread reads."""

    def __init__(self) -> None:
        self._lock, self._readers, self._usual = threading.Lock(), 0, (0, 0)

    @contextmanager
    def lowered(self) -> Iterator[None]:
        with self._lock:
            self._readers += 1
            if self._readers == 1:
                self._lower()
        try:
            yield
        finally:
            with self._lock:
                self._readers -= 1
                if self._readers == 0:
                    resource.setrlimit(resource.RLIMIT_AS, self._usual)

    def _lower(self) -> None:
        self._usual = soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
        wanted = pages * resource.getpagesize() + MOST_MEMORY
        if soft == resource.RLIM_INFINITY or wanted < soft:
            resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))


_LIMIT = _Limit()


@contextmanager
def bounded_memory() -> Iterator[None]:
    """Lets what is inside take `MOST_MEMORY` and no more, MemoryError otherwise; on Linux alone.

    The address space of the whole process is bounded, so that it holds for libraries in C too.
    """
    if sys.platform != "linux":
        yield
        return
    with _LIMIT.lowered():
        yield
