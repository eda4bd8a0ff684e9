"""Whole files to begin with, and folders for those under attack, in memory where there is one."""

import atexit
import os
import tempfile
from functools import cache, partial
from pathlib import Path
from shutil import copy, rmtree

CORPUS = Path(__file__).parent / "corpus"
"""Whole files, a folder for each target."""
PREFIX = "brushgrip_attack_"


def place_inputs(folder: Path, recording: str, rig: str, model: str) -> None:
    """Put a recording, a rig and a model under these names into a folder."""
    copy(CORPUS / "csv" / "plain.csv", folder / recording)
    copy(CORPUS / "rig_toml" / "rig.toml", folder / rig)
    copy(CORPUS / "model_json" / "declared.json", folder / model)


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
