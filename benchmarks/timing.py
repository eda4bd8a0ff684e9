"""How long tasks take, compared within one run so that the machine's mood cancels out."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

ROUNDS = 7
Task = Callable[[], object]


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Medians over the rounds: times of both tasks [s], and their ratio round by round [1]."""

    ratio: float
    slow: float
    fast: float


def seconds(task: Task) -> float:
    """How long a task takes [s]."""
    begin = time.perf_counter()
    task()
    return time.perf_counter() - begin


def compare(slow: Task, fast: Task, rounds: int = ROUNDS) -> Pair:
    """Both tasks in turn; a first round does not count."""
    slow(), fast()
    times = np.array([(seconds(slow), seconds(fast)) for _ in range(rounds)])
    middle = np.median(times, axis=0)
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    return Pair(ratio=ratio, slow=float(middle[0]), fast=float(middle[1]))
