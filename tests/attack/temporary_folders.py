"""Processes with temporary folders in one place, some killed, and somebody who changes what is there."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from random import Random

from symbolic.compilation.self_cleaning_folder import PREFIX, temporary_folder
from tests.attack.attack_class import one_by_one
from tests.attack.whole_runs import ROOT

WORK = """
import sys, time
from pathlib import Path
from brushgrip.outputs.atomic import staged_directory, staged_file
from symbolic import InvalidInputError
parent, own, calm = Path(sys.argv[1]), sys.argv[2], sys.argv[3] == "calm"
print(flush=True)
end = time.monotonic() + 1.5
while time.monotonic() < end:
    for staged, final in ((staged_file, parent / "file"), (staged_directory, parent / "folder")):
        try:
            with staged(final) as stage:
                place = stage / "one" if staged is staged_directory else stage
                place.write_text(own * 5000)
                if place.read_text() != own * 5000:
                    sys.exit("what was written is not there")
        except InvalidInputError as error:
            if calm or chr(10) in str(error):
                sys.exit(str(error))
        except OSError as error:
            if calm:  # Somebody took the stage away.
                sys.exit(repr(error))
"""


def _disturb(parent: Path, outside: Path, chance: Random) -> None:
    """Somebody removes, moves, links or blocks what is there; no real result of ours is at stake."""
    names = [path for path in parent.iterdir() if path.name.startswith(PREFIX)]
    chosen = chance.choice(names) if names else parent / f"{PREFIX}none"
    kind = chance.randrange(6)
    try:
        if kind == 0:
            shutil.rmtree(chosen, ignore_errors=True)
        elif kind == 1:
            chosen.rename(chosen.with_name(f"{PREFIX}{chance.randrange(99)}"))
        elif kind == 2:
            (parent / f"{PREFIX}{chance.randrange(99)}").symlink_to(outside)
        elif kind == 3:
            (parent / f"{PREFIX}{chance.randrange(99)}").write_text("a file")
        elif kind == 4 and not (parent / "folder").is_symlink():
            shutil.rmtree(parent / "folder", ignore_errors=True)
            (parent / "folder").symlink_to(outside)
        else:
            (parent / "folder").unlink(missing_ok=True)
    except OSError:
        pass  # It is gone by now.


def attempt(number: int) -> str | None:
    """A few seconds of it; every second time nobody disturbs, and then no work may fail."""
    chance, disturbed = Random(number), bool(number % 2)
    with tempfile.TemporaryDirectory() as top:
        parent, outside = Path(top) / "parent", Path(top) / "outside"
        for folder in (parent, outside):
            folder.mkdir()
        (outside / "victim").write_text("kept")
        workers = [
            subprocess.Popen(
                [sys.executable, "-c", WORK, parent, name, "disturbed" if disturbed else "calm"],
                cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            )
            for name in "abc"
        ]  # fmt: skip
        for worker in workers:
            worker.stdout.readline()  # type: ignore[union-attr]
        end = time.monotonic() + 1.5
        while time.monotonic() < end:
            if disturbed:
                _disturb(parent, outside, chance)
            elif chance.random() < 0.002:
                workers[0].kill()
            time.sleep(0.001)
        said = [worker.communicate(timeout=60)[1] for worker in workers]
        ends = [worker.returncode for worker in workers]
        with temporary_folder(parent):
            pass
        left = [p.name for p in parent.glob(f"{PREFIX}*") if p.is_dir() and not p.is_symlink()]
        victim, result = outside / "victim", parent / "file"
        kept = victim.is_file() and victim.read_text() == "kept"
        whole = not result.is_file() or result.read_text() in {5000 * name for name in "abc"}
    if not kept or not whole:
        return f"{number}: {'a result is not whole' if kept else 'what a link led to is lost'}"
    if [code for code in ends if code not in (0, -signal.SIGKILL)]:
        return f"{number}: ended with {ends}: {' '.join(said)[-300:]}"
    return f"{number}: left {left}" if left else None


CLASSES = {"temporary_folders": one_by_one(attempt)} if os.name == "posix" else {}
