"""Hidden folders for what is not finished; what a killed process left goes when the next one comes.

Each is locked by the process that made it (flock). The lock ends with the process, however that ends, so
that a folder without one is nobody's. Where nothing can be locked, nothing is removed.
"""

import os
import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PREFIX = f".brushgrip-{re.sub(r'[^A-Za-z0-9]', '', platform.node())[:32]}-"
"""Of their names; another machine's locks may not show in a folder that is shared over a network."""


@contextmanager
def scratch_folder(parent: Path) -> Iterator[Path]:
    """An empty folder in this one, which goes at the end; those of processes that are gone go first.

    Raises:
        OSError: nothing can be written there.
    """
    folder, lock = claimed_folder(parent)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def claimed_folder(parent: Path) -> tuple[Path, int | None]:
    """The same for as long as the process lives; its lock goes with it, the folder does not.

    Returns:
        The folder, and the descriptor that locks it; None where nothing can be locked.
    """
    _remove_abandoned(parent)
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))
        try:
            lock = _lock(folder)
        except BlockingIOError:
            continue  # Another process found it without a lock, and removes it.
        except OSError:
            if folder.exists():
                return folder, None
            continue
        if folder.exists():
            return folder, lock
        if lock is not None:
            os.close(lock)


def _remove_abandoned(parent: Path) -> None:
    """Removes the folders of processes that are gone."""
    with suppress(OSError):
        for folder in parent.iterdir():
            if folder.name.startswith(PREFIX):
                with suppress(OSError):
                    lock = _lock(folder)
                    if lock is not None:
                        shutil.rmtree(folder, ignore_errors=True)
                        os.close(lock)


def _lock(folder: Path) -> int | None:
    """Locks a folder; returns the descriptor, None where the system has no such locks.

    Raises:
        BlockingIOError: another process has locked it.
        OSError: it is not there, or no folder, or the file system has no locks.
    """
    if fcntl is None:
        return None
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor
