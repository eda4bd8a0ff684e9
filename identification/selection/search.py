"""The search for the missing effects without a diagnosis of what it found."""

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor

from identification.fits.loss import LEAST_SQUARES, Loss
from identification.reading.recordings import Recording
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from identification.selection.journal import Journal
from identification.selection.search_step import SearchStep
from identification.selection.stepwise_search import Progress, Search, silent
from identification.selection.trial_runner import TrialRunner, jobs_of, workers
from symbolic import CANDIDATES, Effect, effects_named


def search(
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    candidates: Iterable[str | Effect] = tuple(CANDIDATES),
    criteria: SelectionCriteria = DEFAULT_CRITERIA,
    loss: Loss = LEAST_SQUARES,
    journal: Journal | None = None,
) -> list[SearchStep]:
    """Add effects one at a time, remove those that become superfluous; the last step chooses nothing.

    Candidates are ranked on thinned recordings with coarse fits; the best are fitted again to the whole
    recordings, where they have to be confirmed. A candidate that gained next to nothing in the last
    steps is left out, then tried once more before an effect is removed, and where a law of its family is
    added, or any where it has none.

    The shared parameters are fitted to the training recordings; the held-out ones judge, or the training
    recordings left out in turn where there are none. The other arguments are those of `diagnose`.

    Raises:
        InvalidInputError: a candidate is unknown, named twice, or processes cannot import its class.
        BrushgripError: a process ended before its work was done.
    """
    effects, count = effects_named(candidates), jobs_of(jobs)
    with workers(jobs, effects, executor) as submit:
        runner = TrialRunner(
            training=training, holdout=holdout, loss=loss, submit=submit, journal=journal, threads=count
        )
        return Search(runner, effects, criteria, progress or silent).run()
