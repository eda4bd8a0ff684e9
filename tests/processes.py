"""What tests wait for, and processes that they start, as the system sees them."""

import time
from collections.abc import Callable
from pathlib import Path


def is_running(pid: int) -> bool:
    """Whether a process does anything; one that has ended may wait for its exit status to be read."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(happens: Callable[[], object]) -> None:
    """Wait until it happens, a minute at most."""
    end = time.monotonic() + 60
    while not happens():
        assert time.monotonic() < end, "it has not come"
        time.sleep(0.005)
