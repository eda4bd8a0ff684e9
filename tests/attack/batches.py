"""Batches over every format: killed, interrupted, two at once, without their cluster."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path

from identification import read_recording, read_rig
from tests.attack.attack_class import one_by_one
from tests.attack.faults import FAULTS as RUNS
from tests.attack.faults import Fault, attempt, ended_well, two_at_once
from tests.attack.whole_runs import ROOT, Sandbox
from tests.attack.workplace import workplace
from tests.identification.reading.logs import MAP, OWN_CLOCK, WRITERS, as_logged

SAMPLES = 120


class Batch(Sandbox):
    """Estimates over recordings in files that keep time in a channel; those with a clock where quick."""

    def __post_init__(self) -> None:
        """Write the recordings anew."""
        shutil.copytree(_written(self.quick), self.folder / "work", dirs_exist_ok=True)
        for name in ("tmp", "home"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)

    @property
    def words(self) -> tuple[str, ...]:
        """The command line but for --out and --jobs."""
        names = sorted(path.name for path in _written(self.quick).glob("run.*"))
        files = [name for name in names if not name.endswith(".dbc")]
        signals = f"{OWN_CLOCK},dbc=rig.dbc" if self.quick else MAP
        return ("estimate", *files, "--rig", "rig.toml", "--map", signals, "--observer", "root")

    def result(self, out: str = "out") -> bytes:
        """The tables, b"" where nothing was written."""
        tables = sorted((self.folder / "work").glob(f"{out}_*"))
        return b"".join(path.read_bytes() for path in tables if path.suffix != ".json")

    def left(self) -> list[str]:
        """What should not be there when the last run was successful."""
        given = {path.name for path in _written(self.quick).iterdir()}
        work = {path.name for path in (self.folder / "work").iterdir()} - given
        temporary = [path.name for path in (self.folder / "tmp").iterdir()]
        return sorted([*(name for name in work if not name.startswith("out")), *temporary])


@cache
def _written(own_clock: bool) -> Path:
    """A folder with one recording in each format, and its rig."""
    folder = workplace() / f"batch_{own_clock}"
    folder.mkdir()
    embedded = ROOT / "examples" / "recordings"
    shutil.copy(embedded / "rig.toml", folder)
    read = read_recording(embedded / "train_a.csv", read_rig(embedded / "rig.toml"))
    columns = as_logged(*(c[: 5 * SAMPLES : 5] for c in (read.t, read.psi, read.M_z, read.F_N)))
    for name, write, signals in WRITERS.values():
        if signals == (OWN_CLOCK if own_clock else MAP):
            write(folder / name, columns)
    return folder


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """A scheduler and a worker, and the address."""
    address = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder, "text": True}
    place = {"env": {**os.environ, "PYTHONPATH": str(ROOT), "BRUSHGRIP_INTERPRET": "1"}}
    code = "import sys; from distributed.cli.dask_{0} import main; sys.argv[0] = 'dask'; main()"
    options = {
        "scheduler": ["--port", "0", "--no-dashboard", "--scheduler-file", str(address)],
        "worker": ["--scheduler-file", str(address), "--nthreads", "1", "--no-dashboard",
                   "--death-timeout", "30", "--no-nanny"],
    }  # fmt: skip
    processes = [
        subprocess.Popen([sys.executable, "-c", code.format(role), *options[role]], **quiet, **place)
        for role in options
    ]
    try:
        yield str(address), processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


def loses_its_scheduler(sandbox: Sandbox, chance: random.Random) -> str | None:
    """The scheduler, or its only worker and then the scheduler, is killed at any instant."""
    cluster_folder = sandbox.folder / "home" / "cluster"
    cluster_folder.mkdir()
    with cluster(cluster_folder) as (address, processes):
        end = time.monotonic() + 60
        while not Path(address).is_file() or not Path(address).stat().st_size:
            if time.monotonic() > end:
                return "the scheduler did not come up"
            time.sleep(0.1)
        where = json.loads(Path(address).read_text())["address"]
        run = sandbox.start(further=("--scheduler", where))
        time.sleep(chance.uniform(0, 8))
        for process in processes[:: chance.choice((1, -1))]:
            process.send_signal(chance.choice((signal.SIGKILL, signal.SIGTERM)))
            time.sleep(chance.choice((0, 1)))
        ended = sandbox.finish(run, 120)
    return ended_well(ended, most=1) or sandbox.nothing_left()


FAULTS: dict[str, Fault] = {
    "batch_killed": RUNS["run_killed"],
    "batch_interrupted": RUNS["run_interrupted"],
    "batch_two_at_once": two_at_once,
    "batch_no_scheduler": loses_its_scheduler,
}


def _attempt(fault: Fault, number: int) -> str | None:
    """Files with a channel of time and files with a clock in turn."""
    return attempt(fault, number, quick=bool(number % 2), kind=Batch)


CLASSES = {name: one_by_one(partial(_attempt, fault)) for name, fault in FAULTS.items()}
