"""Error and calculation time of every method on every case."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from brushgrip.comparison.methods import Method
from brushgrip.comparison.recordings_with_reference_friction import Case
from brushgrip.outputs.console import Progress
from identification import Recording
from symbolic.float_array_type import Array

MIN_ROUNDS, MIN_TIME = 3, 0.2
"""A calculation is repeated at least so often, and until the repetitions take this time [s]; the
shortest counts."""
AUTHOR = "author's estimate"


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodScore:
    """One method on one case: errors of its effective friction as of `Case` [1]."""

    method: str
    rmse: float
    spread: float
    theta: float | None  # As of `estimate_and_time_ratio`; None where nothing was calculated.
    mu: Array  # The estimate at the settled samples of the case [1].


@dataclass(frozen=True, kw_only=True, eq=False)
class CaseScores:
    """All methods on one case; the author's estimate first, where there is one."""

    case: Case
    scores: tuple[MethodScore, ...]


@dataclass(frozen=True, kw_only=True)
class MethodSummary:
    """A row of [Györök 2022], Table 6.1: means of a method's scores over all cases, None for unknown."""

    method: str
    rmse: float
    spread: float | None = None
    theta: float | None
    works_beyond_five_zones: bool | None  # As of `Method`; None for in part.
    gives_deviation: bool = False


PUBLISHED = tuple(
    MethodSummary(method=method, rmse=rmse, theta=theta, works_beyond_five_zones=beyond)
    for method, rmse, theta, beyond in (
        ("analytic method", 0.638, 0.525, False),
        ("neural network", 0.4794, 0.0085, True),
        ("SciML method", 0.3837, 0.538, None),
    )
)
"""[Györök 2022], Table 6.1, as printed: six recordings on steel, an Intel i5-8250U."""


def compare_methods(
    cases: Sequence[Case], methods: Sequence[Method], progress: Progress = lambda *_: None
) -> list[CaseScores]:
    """Every method on every case; a user's own observer is an `ObserverMethod`."""
    results = []
    total = len(cases) * len(methods)
    for i, case in enumerate(cases):
        scores = []
        if (mu := case.author_mu) is not None:
            scores.append(_score(case, AUTHOR, mu, None))
        for j, method in enumerate(methods):
            progress(f"{case.recording.name}, {method.name}", i * len(methods) + j, total)
            mu, theta = estimate_and_time_ratio(method, case.recording)
            scores.append(_score(case, method.name, mu, theta))
        results.append(CaseScores(case=case, scores=tuple(scores)))
    return results


def estimate_and_time_ratio(method: Method, recording: Recording) -> tuple[Array, float]:
    """The first estimate, and calculation time over measurement time [1], [Györök 2022], (5.10).

    The shortest of several rounds counts, without what a method caches in the first. Processor time of
    all threads is taken, so that other programs do not count.
    """
    estimates: list[Array] = []
    times: list[float] = []
    while len(times) < MIN_ROUNDS or sum(times[1:]) < MIN_TIME:
        begin = process_time()
        estimates.append(method.estimate_mu_eff(recording))
        times.append(process_time() - begin)
    return estimates[0], min(times) / float(recording.t[-1] - recording.t[0])


def summarise(results: Sequence[CaseScores], methods: Sequence[Method]) -> list[MethodSummary]:
    """One row per method over all cases; the author's estimate only over those that have one."""
    properties = {AUTHOR: (False, False)} | {
        method.name: (method.works_beyond_five_zones, method.gives_deviation) for method in methods
    }
    summaries = []
    for name, (beyond, deviation) in properties.items():
        scores = [score for result in results for score in result.scores if score.method == name]
        if not scores:
            continue
        thetas = [score.theta for score in scores if score.theta is not None]
        summaries.append(
            MethodSummary(
                method=name,
                rmse=float(np.mean([score.rmse for score in scores])),
                spread=float(np.mean([score.spread for score in scores])),
                theta=float(np.mean(thetas)) if thetas else None,
                works_beyond_five_zones=beyond,
                gives_deviation=deviation,
            )
        )
    return summaries


def _score(case: Case, method: str, mu: Array, theta: float | None) -> MethodScore:
    return MethodScore(
        method=method,
        rmse=case.rmse(mu),
        spread=case.std_after_first_slide(mu),
        theta=theta,
        mu=mu[case.settled],
    )
