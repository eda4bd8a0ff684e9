"""Trials of one search run in processes: coarse ones on thinned recordings, fine ones on the whole."""

import os
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from identification.fits.loss import Loss
from identification.fits.values_by_ground_and_recording import Values
from identification.reading.recordings import Recording
from identification.selection.trial import (
    FINE,
    RANKING_STEP,
    Precision,
    Trial,
    TrialTask,
    model_of,
    run_trial,
    thin_for_ranking,
)
from identification.selection.trial_journal import Journal
from identification.selection.worker_processes import WorkerProcesses, one_blas_thread_per_process
from symbolic import BrushgripError, Effect, InvalidInputError

Effects = tuple[Effect, ...]
Submit = Callable[..., Future[Any]]
"""Takes a function and its arguments, returns the future of its result."""
Report = Callable[[int], None]
"""Takes the number of trials done."""
Key = TypeVar("Key")
_BETWEEN_WAITS = 0.5
"""Longest wait before a pending interrupt is served [s]."""
_PENDING = 1000
"""Most futures that are waited for at a time; of more, the others are taken when some are done."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialRunner:
    """Runs the trials of one search: fits to `training`, judged by `holdout`, which may be empty.

    `submit` hands work to processes; where none has other work, so many recordings are simulated at a
    time as there are `threads`. A journal keeps trials.
    """

    training: Sequence[Recording]
    holdout: Sequence[Recording]
    loss: Loss
    submit: Submit
    journal: Journal | None = None
    threads: int = 1

    _thinned: dict[float, Sequence[Sequence[Recording]]] = field(default_factory=dict, init=False)

    @property
    def thinned_training(self) -> Sequence[Recording]:
        """The training recordings on which candidates are ranked."""
        return self._thinned_to(RANKING_STEP)[0]

    def _thinned_to(self, step: float) -> Sequence[Sequence[Recording]]:
        """Training and held-out recordings thinned towards a time between samples [s]."""
        if step not in self._thinned:
            both = self.training, self.holdout
            self._thinned[step] = [
                [thin_for_ranking(r, step) for r in recordings] for recordings in both
            ]
        return self._thinned[step]

    def run_on_whole_recordings(
        self, effects: Effects, start: Values | None = None, precision: Precision = FINE
    ) -> Trial:
        """A trial on the whole recordings."""
        return self._run(self._task_on_whole(effects, start, precision))

    def run_on_thinned_recordings(
        self, effects: Effects, start: Values | None, precision: Precision
    ) -> Trial:
        """A trial on the thinned recordings, to be compared with candidates."""
        return self._run(self._task_on_thinned(effects, start, precision))

    def rank(
        self, present: Trial, sets: Sequence[Effects], precision: Precision, report: Report
    ) -> list[Trial]:
        """Coarse trials of these sets of effects from another's values, least judged error first."""
        # The heaviest first, so that no core waits for one of them at the end.
        ordered = sorted(sets, key=lambda effects: -model_of(effects, precision).memory_size)
        starts = [(effects, start_values(present, effects)) for effects in ordered]
        return sorted(self.run_all_on_thinned(starts, precision, report), key=lambda trial: trial.nrmse)

    def run_all_on_thinned(
        self, starts: Sequence[tuple[Effects, Values]], precision: Precision, report: Report
    ) -> list[Trial]:
        """Coarse trials of these sets of effects, each from its own values; in the order given."""
        tasks = [self._task_on_thinned(effects, start, precision) for effects, start in starts]
        return self._submit_tasks(tasks)(report)

    def begin_on_whole_recordings(
        self, starts: Mapping[Key, tuple[Effects, Values]], precision: Precision
    ) -> Callable[[], dict[Key, Trial]]:
        """Begin trials on the whole recordings in the processes; what is returned waits for them."""
        finish = self._submit_tasks(
            [self._task_on_whole(*start, precision) for start in starts.values()]
        )
        return lambda: dict(zip(starts, finish(ignore_progress), strict=True))

    def _submit_tasks(self, tasks: Sequence[TrialTask]) -> Callable[[Report], list[Trial]]:
        """Hand over what the journal lacks; what is returned waits for it and reports progress."""
        trials, futures = dict[int, Trial](), {}
        for i, task in enumerate(tasks):
            # To recall takes time, so the processes begin with the first that is missing.
            if (kept := self._recall(task)) is not None:
                trials[i] = kept
            else:
                futures[self.submit(run_trial, task)] = i, task

        def finish(report: Report) -> list[Trial]:
            report(len(trials))
            for future in as_completed(futures):
                i, task = futures[future]
                trials[i] = self._note(task, future.result())
                report(len(trials))
            return [trials[i] for i in range(len(tasks))]

        return finish

    def _task_on_thinned(
        self, effects: Effects, start: Values | None, precision: Precision
    ) -> TrialTask:
        training, holdout = self._thinned_to(precision.step)
        return TrialTask(effects, training, holdout, start, precision, self.loss)

    def _task_on_whole(self, effects: Effects, start: Values | None, precision: Precision) -> TrialTask:
        return TrialTask(effects, self.training, self.holdout, start, precision, self.loss)

    def _run(self, task: TrialTask) -> Trial:
        return self._recall(task) or self._note(task, run_trial(task, self.threads))

    def _recall(self, task: TrialTask) -> Trial | None:
        return self.journal.recall(task) if self.journal else None

    def _note(self, task: TrialTask, trial: Trial) -> Trial:
        if self.journal:
            self.journal.note(task, trial)
        return trial


def ignore_progress(*_: object) -> None:
    """Progress that nobody sees."""


def start_values(present: Trial, effects: Sequence[Effect]) -> Values:
    """The values of a trial without those of effects that are not in the set.

    Where an effect that gives lengths another meaning comes in or goes, the rig's are the declared ones:
    lengths that imitate the effect within their tolerances would hold the fit at a minimum of its own.
    """
    values, names = present.values, {effect.name for effect in effects}

    def of_the_set(parameters: Mapping[str, float]) -> dict[str, float]:
        return {n: v for n, v in parameters.items() if "." not in n or n.split(".")[0] in names}

    def of_lengths(effects: Sequence[Effect]) -> set[str]:
        return {effect.name for effect in effects if effect.of_lengths}

    lengths_changed = of_lengths(effects) != of_lengths(present.fitted.model.effects)
    return Values(
        tyre=of_the_set(values.tyre),
        own={name: of_the_set(own) for name, own in values.own.items()},
        grounds={name: of_the_set(ground) for name, ground in values.grounds.items()},
        rig={} if lengths_changed else values.rig,
    )


def as_completed(futures: Iterable[Future[Any]]) -> Iterator[Future[Any]]:
    """Futures in the order in which they are done. On Windows Ctrl-C is heard between waits alone."""
    coming = iter(futures)
    pending = set(islice(coming, _PENDING))
    while pending:
        done, pending = wait(pending, _BETWEEN_WAITS, FIRST_COMPLETED)
        yield from done
        pending.update(islice(coming, _PENDING - len(pending)))


def results_of(futures: Mapping[Key, Future[Any]]) -> dict[Key, Any]:
    """The result of each future; the first fault is raised at once."""
    for future in as_completed(futures.values()):
        future.result()
    return {key: future.result() for key, future in futures.items()}


def job_count(jobs: int | None) -> int:
    """How many things to do at a time: so many, or one per core."""
    return jobs or os.cpu_count() or 1


@contextmanager
def worker_submitter(
    jobs: int | None, effects: Effects = (), executor: Executor | None = None
) -> Iterator[Submit]:
    """Processes to which work can be submitted; with one job it runs in this process, at once.

    An interruption ends the processes at once; unfinished trials are lost. An executor that is given
    is left open, and what it has not begun is cancelled at the end unless it is of `worker_pool`.

    Raises:
        InvalidInputError: jobs are given beside an executor, or another process cannot import the
            class of an effect.
        BrushgripError: a process ended before its work was done, and so did the one in its place.
    """
    if executor is not None and not isinstance(executor, WorkerProcesses):
        if jobs is not None:
            raise InvalidInputError("an executor has processes of its own; leave jobs out")
        with _user_executor_submit(executor) as submit:
            yield submit
        return
    with nullcontext(executor) if executor else worker_pool(jobs) as pool:
        for effect in effects if pool else ():
            _check_importable(effect)
        yield submit_of(pool)


@contextmanager
def worker_pool(jobs: int | None, start: int = 0) -> Iterator[WorkerProcesses | None]:
    """So many processes, None for one per core; with one job none, the work stays in this process.

    `start` of them begin at once, the others when there is work for them.
    """
    if (count := job_count(jobs)) == 1:
        yield None
        return
    pool = WorkerProcesses(count)
    with one_blas_thread_per_process():
        try:
            pool.start(start)
            yield pool
        finally:
            pool.close()


def submit_of(executor: Executor | None) -> Submit:
    """What hands work to an executor; without one it is done at once."""
    return executor.submit if executor else run_in_this_process


@contextmanager
def _user_executor_submit(executor: Executor) -> Iterator[Submit]:
    """Work for an executor of the user's; work that it loses is a fault."""
    pending: set[Future[Any]] = set()

    def submit(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future = executor.submit(function, *arguments)
        pending.add(future)
        future.add_done_callback(pending.discard)
        return future

    try:
        yield submit
    except (BrokenExecutor, CancelledError) as error:
        reason = str(error) or type(error).__name__
        raise BrushgripError(f"the executor lost work that it was given: {reason}") from error
    finally:
        for future in list(pending):
            future.cancel()


def _check_importable(effect: Effect) -> None:
    """Raises InvalidInputError where a new process could not import the classes of an effect."""
    main = sys.modules["__main__"]
    # A new process imports the main module anew where it has a file: not in a notebook, at a prompt, by
    # `python -c`, or from standard input, whose file is "<stdin>".
    has_file = getattr(main, "__spec__", None) or Path(getattr(main, "__file__", "")).is_file()
    try:
        pickled = pickle.dumps(effect)
    except Exception as error:  # a field of the user's own may raise anything
        reason = f"{type(error).__name__}: {error}"
    else:
        if has_file or b"__main__" not in pickled:
            return
        reason = "its class is defined where no file is, in a notebook or at a prompt"
    raise InvalidInputError(
        f"effect {effect.name!r} cannot be taken to the processes of the search ({reason}); put the"
        " effect into a module of its own, or use jobs=1 (--jobs 1)"
    )


def run_in_this_process(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
    """Work done in this process before the next is handed over."""
    future: Future[Any] = Future()
    future.set_result(function(*arguments))
    return future
