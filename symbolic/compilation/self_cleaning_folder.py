"""Hidden temporary folders for files that are not finished.

The process that makes one locks it (flock), and the lock ends with the process, however that ends. So
whoever makes the next one removes all that nobody locks. Where nothing can be locked, nothing is
removed.
"""

import os
import platform
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from symbolic.compilation.operating_system import lock_folder

PREFIX = f".brushgrip-{re.sub(r'[^A-Za-z0-9]', '', platform.node())[:32]}-"
"""Of their names. A folder shared over a network may not show the locks of another machine."""


@contextmanager
def temporary_folder(parent: Path) -> Iterator[Path]:
    """An empty folder in this one, removed at the end, abandoned ones first; OSError if it cannot be."""
    folder, lock = create_locked_folder(parent)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def create_locked_folder(parent: Path) -> tuple[Path, int | None]:
    """An empty folder in this one, which stays, and the descriptor that locks it until the process ends.

    None for a descriptor where nothing can be locked.
    """
    _remove_abandoned(parent)
    while True:
        # Its name is known before it is there, so that an interruption at any instant leaves none.
        folder = parent / f"{PREFIX}{secrets.token_hex(4)}"
        try:
            is_ours, lock = _make_and_lock(folder)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        if is_ours:
            return folder, lock


def _make_and_lock(folder: Path) -> tuple[bool, int | None]:
    """Whether the folder is there and ours, and its lock."""
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        return False, None
    try:
        lock = lock_folder(folder)
    except BlockingIOError:
        return False, None  # Another process found it before it was locked, and removes it.
    except OSError:
        return folder.exists(), None
    if folder.exists():
        return True, lock
    if lock is not None:
        os.close(lock)
    return False, None


def _remove_abandoned(parent: Path) -> None:
    """Removes the folders of processes that are gone."""
    with suppress(OSError):
        for folder in parent.iterdir():
            if folder.name.startswith(PREFIX):
                with suppress(OSError):
                    lock = lock_folder(folder)
                    if lock is not None:
                        shutil.rmtree(folder, ignore_errors=True)
                        os.close(lock)
