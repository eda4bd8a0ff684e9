"""Folders for the files under attack, in memory where there is one; gone when the next one is made."""

import atexit
import os
import tempfile
from functools import cache, partial
from pathlib import Path
from shutil import rmtree

PREFIX = "brushgrip_attack_"


@cache
def workplace() -> Path:
    """The folder of this process."""
    sweep()
    folder = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}_", dir=_memory()))
    atexit.register(partial(rmtree, folder, ignore_errors=True))
    return folder


def sweep() -> None:
    """Remove the folders of processes that are gone; a fuzzer ends without a word to Python."""
    for folder in Path(_memory() or tempfile.gettempdir()).glob(f"{PREFIX}*"):
        number = folder.name.removeprefix(PREFIX).partition("_")[0]
        if number.isdigit() and not _lives(int(number)):
            rmtree(folder, ignore_errors=True)


def _lives(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _memory() -> Path | None:
    memory = Path("/dev/shm")
    return memory if os.access(memory, os.W_OK) else None
