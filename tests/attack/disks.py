"""Disks that are full or may only be read, on which a run works, keeps trials or its cache."""

import os
import random
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from tests.attack.attack_class import Effort, Tried, one_by_one
from tests.attack.faults import DISK_LINES, attempt, ended_well
from tests.attack.whole_runs import Sandbox

PLACES = ("work", "tmp", "home")
"""Folders of a sandbox: recordings and results, temporary files, the caches."""
SIZE = "8m"
FREE = (0, 4096, 20_000, 60_000, 200_000, 500_000)
"""Bytes that a full disk still takes."""
NOT_ROOT = "(not tried: only root may mount)"


@contextmanager
def disk(place: Path) -> Iterator[None]:
    """A small disk of its own in a folder."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", place], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", place], check=True)


def fill(place: Path, free: int) -> Path:
    """Fills a disk but for so many bytes; returns the file that fills it."""
    ballast = place / ".ballast"
    with ballast.open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            size = file.tell()
        os.ftruncate(file.fileno(), max(0, size - free))
    return ballast


def fault_of_disk(read_only: bool, sandbox: Sandbox, chance: random.Random) -> str | None:
    """One of the places is full or may only be read; what is left is copied off before it goes."""
    place = sandbox.folder / chance.choice(PLACES)
    with disk(place):
        Sandbox(sandbox.folder, sandbox.quick)  # writes the recordings anew
        ballast = None if read_only else fill(place, chance.choice(FREE))
        if read_only:
            subprocess.run(["mount", "-o", "remount,ro", place], check=True)
        ended = sandbox.run()
        wrong = ended_well(ended, most=DISK_LINES) or sandbox.nobody_left()
        if read_only:
            subprocess.run(["mount", "-o", "remount,rw", place], check=True)
        if ballast:
            ballast.unlink()
        left = Path(tempfile.mkdtemp(dir=sandbox.folder))
        shutil.copytree(place, left, dirs_exist_ok=True)
    shutil.copytree(left, place, dirs_exist_ok=True)
    shutil.rmtree(left)
    return f"{place.name}: {wrong}" if wrong else None


def may_mount() -> bool:
    """Whether a disk can be made here."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            with disk(Path(folder)):
                return True
        except (OSError, subprocess.CalledProcessError):
            return False


def attack_disk(read_only: bool, effort: Effort) -> Iterator[Tried]:
    """An attack on one kind of disk; without the right to mount none."""
    if not may_mount():
        return iter([Tried(0, note=NOT_ROOT)])
    return one_by_one(partial(attempt, partial(fault_of_disk, read_only)))(effort)


CLASSES = {"run_full_disk": partial(attack_disk, False), "run_read_only": partial(attack_disk, True)}
