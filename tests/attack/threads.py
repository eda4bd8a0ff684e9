"""Threads that read, compile and estimate at once, and processes that are forked amid them.

A fork while another thread builds or loads a model may leave a lock of CasADi held for ever in the
child: threads compile in rounds without forks alone, and observers have taken their first step before.
"""

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from itertools import count, cycle
from pathlib import Path
from random import Random

import casadi as ca
import numpy as np

from identification import read_model, read_recording
from observers import Loop, Sample
from symbolic import compiled
from symbolic.compilation.self_cleaning_folder import temporary_folder
from tests.attack.attack_class import Effort, Tried
from tests.attack.long_runs import observers
from tests.attack.targets import CORPUS, FORMATS, RIG
from tests.attack.workplace import workplace

SECONDS = 3.0
"""Of one round [s]."""
PATIENCE = 60.0
"""A child that takes longer hangs [s]."""


@cache
def _whole_files() -> list[tuple[Path, str]]:
    own = [(CORPUS / "csv" / "plain.csv", ""), (CORPUS / "mat" / "plain.mat", "")]
    logs = ("tdms", "parquet", "hdf5", "mdf")
    return own + [(sorted((CORPUS / n).iterdir())[0], FORMATS[n][2]) for n in logs]


def _read(path: Path, signals: str) -> bytes:
    return read_recording(path, RIG, torque_required=False, signals=signals).psi.tobytes()


@cache
def expected(path: Path, signals: str) -> bytes:
    """What a single thread reads."""
    return _read(path, signals)


def reads(chance: Random, formats: int | None = None) -> str | None:
    """A model, and a file of any format; of the first few only if a number is given."""
    read_model(CORPUS / "model_json" / "declared.json")
    path, signals = chance.choice(_whole_files()[:formats])
    return None if _read(path, signals) == expected(path, signals) else f"{path.name} is read otherwise"


def compiles(chance: Random) -> str | None:
    """A Function that others may be compiling too."""
    factor = chance.randrange(30)
    x = ca.SX.sym("x")
    value = compiled(ca.Function("times", [x], [factor * x]))(2.0)
    return None if float(value) == 2 * factor else f"{factor} * 2 is {value}"


def estimates(chance: Random) -> str | None:
    """A loop of its own around an observer of all."""
    observer = observers()[chance.choice(("ekf", "root"))]
    loops, psi = (Loop(observer), Loop(observer)), 0.0
    for _ in range(50):
        psi += chance.uniform(-0.02, 0.02)
        sample = Sample(psi=psi, psi_dot=np.nan, F_N=400.0, dt=0.01, M_z=-8 * np.tanh(9 * psi))
        one, other = (repr(loop(sample)) for loop in loops)
        if one != other:
            return f"{one} is not {other}"
    return None


def stages(chance: Random) -> str | None:
    """A temporary folder in a place of all."""
    place = workplace() / "stages"
    place.mkdir(exist_ok=True)
    with temporary_folder(place) as folder:
        (folder / "x").write_text("x")
        time.sleep(chance.uniform(0, 0.002))
        return None if (folder / "x").is_file() else "a folder in use was removed"


Work = Callable[[Random], str | None]
WORK: tuple[Work, ...] = (reads, compiles, estimates, stages)
IN_CHILD: tuple[Work, ...] = (partial(reads, formats=2), compiles, estimates, stages)
"""A child may not read by a library in C in which a thread of its parent may be."""


def _in_child(seed: int) -> str | None:
    """A forked process does of everything; what it says, or that it hangs."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        said = "raised"
        try:
            said = next(filter(None, (work(Random(seed)) for work in IN_CHILD)), "")
        except BaseException as error:
            said = f"{type(error).__name__}: {error}"
        finally:
            os.write(into, said.encode()[:1000])
            os._exit(0)
    os.close(into)
    end = time.monotonic() + PATIENCE
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            os.close(out)
            return "a forked process hangs"
        time.sleep(0.01)
    with os.fdopen(out) as pipe:
        return f"in a forked process: {said}" if (said := pipe.read()) else None


def attack_threads(effort: Effort) -> Iterator[Tried]:
    """Rounds of four threads: in turn everything at random, and all but compiling, with forks."""
    for path, signals in _whole_files():
        expected(path, signals)
    for i in range(8):
        estimates(Random(i))

    def work(seed: int, end: float, kinds: Sequence[Work]) -> list[Tried]:
        chance, tried = Random(seed), []
        while time.monotonic() < end:
            try:
                tried.append(Tried(1, chance.choice(kinds)(chance)))
            except Exception as error:
                tried.append(Tried(1, f"{type(error).__name__}: {error}"))
        return tried

    for seed, forks in zip(count(effort.seed, 1000), cycle((False, True)), strict=False):
        end = time.monotonic() + SECONDS
        kinds = [one for one in WORK if not (forks and one is compiles)]
        with ThreadPoolExecutor(4) as threads:
            rounds = [threads.submit(work, seed + i, end, kinds) for i in range(4)]
            for child in count(seed) if forks else ():
                yield Tried(len(IN_CHILD), _in_child(child))
                if time.monotonic() > end:
                    break
        yield from (tried for done in rounds for tried in done.result())


CLASSES = {"threads_and_fork": attack_threads} if hasattr(os, "fork") else {}
