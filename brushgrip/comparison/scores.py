"""How near every method comes on every recording, and how long it takes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from brushgrip.comparison.cases import Subject
from brushgrip.comparison.methods import Method

Array = NDArray[np.float64]
Report = Callable[[str, int, int], None]
ROUNDS, LONG_ENOUGH = 3, 0.2
"""A calculation is timed at least so often, and until so much time has gone after the first [s]; the
least counts."""
AUTHOR = "author's estimate"


@dataclass(frozen=True, kw_only=True, eq=False)
class Score:
    """One method on one recording.

    Attributes:
        method: its name.
        rmse: root mean square of mu less the declared one [1].
        spread: standard deviation of mu over time after the first slide [1].
        theta: calculation time over measurement time, source (5.10), on this machine [1]; None where
            nothing was calculated.
        mu: the estimate over the samples that `rmse` counts [1].
    """

    method: str
    rmse: float
    spread: float
    theta: float | None
    mu: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """All methods on one recording.

    Attributes:
        subject: the recording and what it is held against.
        scores: one a method; the author's own estimate first, where there is one.
    """

    subject: Subject
    scores: tuple[Score, ...]


@dataclass(frozen=True, kw_only=True)
class Row:
    """One method over all recordings: a row of Table 6.1.

    Attributes:
        method: its name.
        rmse: mean over the recordings [1].
        spread: mean over the recordings [1]; None where not known.
        theta: calculation time over measurement time, mean [1]; None where not known.
        works_beyond_five_zones: None for in part.
        gives_deviation: whether it says how sure it is.
    """

    method: str
    rmse: float
    spread: float | None
    theta: float | None
    works_beyond_five_zones: bool | None
    gives_deviation: bool


PUBLISHED = (
    Row(
        method="analytic method",
        rmse=0.638,
        spread=None,
        theta=0.525,
        works_beyond_five_zones=False,
        gives_deviation=False,
    ),
    Row(
        method="neural network",
        rmse=0.4794,
        spread=None,
        theta=0.0085,
        works_beyond_five_zones=True,
        gives_deviation=False,
    ),
    Row(
        method="SciML method",
        rmse=0.3837,
        spread=None,
        theta=0.538,
        works_beyond_five_zones=None,
        gives_deviation=False,
    ),
)
"""Table 6.1 as printed: six recordings on steel, an Intel i5-8250U."""


def compare(
    subjects: Sequence[Subject], methods: Sequence[Method], progress: Report = lambda *_: None
) -> list[Compared]:
    """Every method on every recording."""
    made = []
    total = len(subjects) * len(methods)
    for i, subject in enumerate(subjects):
        scores = []
        if (mu := subject.author_mu) is not None:
            scores.append(_score(subject, AUTHOR, mu, None))
        for j, method in enumerate(methods):
            progress(f"{subject.recording.name}, {method.name}", i * len(methods) + j, total)
            mu, theta = timed(method, subject)
            scores.append(_score(subject, method.name, mu, theta))
        made.append(Compared(subject=subject, scores=tuple(scores)))
    return made


def timed(method: Method, subject: Subject) -> tuple[Array, float]:
    """The first estimate, and calculation time over measurement time, source (5.10) [1].

    The time is the least of some rounds, so that what a method makes in the first does not count; it is
    time of the processor, all threads together, so that other programs do not.
    """
    t = subject.recording.t
    estimates: list[Array] = []
    times: list[float] = []
    while len(times) < ROUNDS or sum(times[1:]) < LONG_ENOUGH:
        begin = process_time()
        estimates.append(method.estimate(subject.recording))
        times.append(process_time() - begin)
    return estimates[0], min(times) / float(t[-1] - t[0])


def rows(compared: Sequence[Compared], methods: Sequence[Method]) -> list[Row]:
    """One row a method over all recordings; the author's own only over those that he has."""
    properties = {AUTHOR: (False, False)} | {
        method.name: (method.works_beyond_five_zones, method.gives_deviation) for method in methods
    }
    made = []
    for name, (beyond, deviation) in properties.items():
        scores = [score for one in compared for score in one.scores if score.method == name]
        if not scores:
            continue
        thetas = [score.theta for score in scores if score.theta is not None]
        made.append(
            Row(
                method=name,
                rmse=float(np.mean([score.rmse for score in scores])),
                spread=float(np.mean([score.spread for score in scores])),
                theta=float(np.mean(thetas)) if thetas else None,
                works_beyond_five_zones=beyond,
                gives_deviation=deviation,
            )
        )
    return made


def _score(subject: Subject, method: str, mu: Array, theta: float | None) -> Score:
    return Score(
        method=method,
        rmse=subject.rmse(mu),
        spread=subject.spread(mu),
        theta=theta,
        mu=mu[subject.settled],
    )
