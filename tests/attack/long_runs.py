"""Samples without end through `Loop` and every observer, in threads and in a forked process.

Angles, loads and times between samples change at random, measurements are missing or absurd. Every
estimate has to be finite, every covariance positive definite, and the memory in use flat.
"""

import math
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np

from observers import Ekf, Loop, Mhe, Observer, RootObserver, Sample, covariance_of
from symbolic import Model, Rig, effects_named
from tests.attack.attack_class import Effort, Tried

BLOCK = 500
"""Samples of one stream at a time."""
SETTLED = 3
"""Rounds after which memory may no longer grow."""
MOST_GROWTH = 32
"""By which it may all the same [MB], of the allocator."""
RIG, K = Rig(a=0.045, e=0.009), 2.4e6
VALUES = {"k": K}
EFFECTS = {"torque_offset.M_0": 0.3, "contact_damping.c": 0.2}
ODD = (math.nan, math.nan, math.inf, 1e300)


@cache
def observers() -> dict[str, Observer]:
    """Every observer, without effects and with some."""
    plain, found = Model(), Model(effects=effects_named(["torque_offset", "contact_damping"]))
    return {
        "ekf": Ekf(model=plain, values=VALUES, rig=RIG),
        "ekf with effects": Ekf(model=found, values=VALUES | EFFECTS, rig=RIG),
        "mhe": Mhe(model=plain, values=VALUES, rig=RIG, window=5),
        "mhe with effects": Mhe(model=found, values=VALUES | EFFECTS, rig=RIG, window=5),
        "root": RootObserver(rig=RIG, k=K),
    }


class Stream:
    """Samples drawn at random, into a loop of their own."""

    def __init__(self, name: str, seed: int) -> None:
        """Begin with a wheel that stands straight."""
        self.name, self.loop = name, Loop(observers()[name])
        self._random, self._psi = np.random.default_rng(seed), 0.0

    def go_on(self) -> str | None:
        """One block; a line on what went wrong."""
        for sample in self._block():
            estimate = self.loop(sample)
            if not (math.isfinite(estimate.mu) and estimate.mu > 0):
                return f"{self.name}: mu is {estimate.mu} after {sample}"
            if self.name != "root" and not 0 < estimate.mu_std < math.inf:
                return f"{self.name}: the deviation is {estimate.mu_std} after {sample}"
        if self.name == "root" or self.loop.state is None:
            return None
        factor = self.loop.state["factor"]
        size = math.isqrt(factor.size)
        least = np.linalg.eigvalsh(covariance_of(factor.reshape(size, size, order="F"))).min()
        return None if least > 0 else f"{self.name}: least eigenvalue of the covariance {least}"

    def _block(self) -> Sequence[Sample]:
        draw = self._random
        turn = draw.normal(0, 0.02, BLOCK) * draw.choice([0, 0.1, 1, 5], BLOCK)
        psi = self._psi + np.cumsum(turn)
        psi = 0.4 - np.abs((psi - 0.4) % 1.6 - 0.8)
        self._psi = float(psi[-1])
        dt = 10.0 ** draw.uniform(-4, -1, BLOCK)
        F_N = 400 * np.exp(draw.normal(0, 0.2, BLOCK))
        M_z = -0.02 * F_N * np.tanh(20 * np.gradient(psi) + psi) + draw.normal(0, 0.05, BLOCK)
        rows = np.column_stack([psi, np.gradient(psi) / dt, F_N, M_z])
        rows[draw.random(rows.shape) < 0.01] = draw.choice(ODD)
        return [
            Sample(psi=psi, psi_dot=rate, F_N=load, dt=step, M_z=torque)
            for (psi, rate, load, torque), step in zip(rows.tolist(), dt.tolist(), strict=True)
        ]


_OF_THE_CHILD: list[Stream] = []


def _child_goes_on() -> tuple[list[str | None], float]:
    """What the streams of the forked process say, and its memory [MB]."""
    return [stream.go_on() for stream in _OF_THE_CHILD], memory()


def memory() -> float:
    """What this process holds [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def attack_observers(effort: Effort) -> Iterator[Tried]:
    """All streams go on together, block by block: two of each observer in threads, one in a child."""
    names = list(observers())
    streams = [Stream(name, effort.seed + i) for i in range(2) for name in names]
    _OF_THE_CHILD[:] = [Stream(name, effort.seed + 2) for name in names]
    early, note = (math.inf, math.inf), ""
    forking = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(1, forking) as child, ThreadPoolExecutor(2) as threads:
        for round_ in count(1):
            apart = child.submit(_child_goes_on)
            lines = list(threads.map(Stream.go_on, streams))
            lines_of_child, size = apart.result()
            yield from (Tried(0, line) for line in (*lines, *lines_of_child) if line)
            early = (memory(), size) if round_ == SETTLED else early
            growth = memory() - early[0], size - early[1]
            if round_ > SETTLED:
                note = f"(memory grew by {growth[0]:.1f} MB, in the child by {growth[1]:.1f} MB)"
            grown = "memory grew" if max(growth) > MOST_GROWTH else None
            yield Tried(BLOCK * (len(streams) + len(_OF_THE_CHILD)), grown, note)


CLASSES = {"long_runs": attack_observers}
