"""Trials of one search run in processes: coarse ones on thinned recordings, fine ones on the whole."""

import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import get_context
from typing import Any

from identification.fits.fitting import Values
from identification.fits.loss import Loss
from identification.reading.recordings import Recording
from identification.selection.journal import Journal
from identification.selection.trials import Precision, Trial, TrialTask, model_of, run_trial, thin
from symbolic import Effect

Effects = tuple[Effect, ...]
Submit = Callable[..., Future[Any]]
"""Takes a function and its arguments, returns the future of its result."""
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
"""What the libraries of linear algebra read once, when they are loaded."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialRunner:
    """Runs the trials of one search.

    Attributes:
        training: recordings that the shared parameters are fitted to.
        holdout: recordings that judge, may be empty.
        loss: what a residual costs.
        submit: hands work to processes.
        journal: keeps trials, None to keep none.
    """

    training: Sequence[Recording]
    holdout: Sequence[Recording]
    loss: Loss
    submit: Submit
    journal: Journal | None = None

    @cached_property
    def thinned_training(self) -> Sequence[Recording]:
        """The training recordings on which candidates are ranked."""
        return [thin(recording) for recording in self.training]

    @cached_property
    def thinned_holdout(self) -> Sequence[Recording]:
        """The held-out ones."""
        return [thin(recording) for recording in self.holdout]

    def run_fine(self, effects: Effects, start: Values | None = None) -> Trial:
        """A trial on the whole recordings."""
        return self._run(TrialTask(effects, self.training, self.holdout, start, loss=self.loss))

    def run_coarse(self, effects: Effects, start: Values | None, precision: Precision) -> Trial:
        """A trial on the thinned recordings, to be compared with candidates."""
        return self._run(self._coarse_task(effects, start, precision))

    def rank(
        self,
        present: Trial,
        sets: Sequence[Effects],
        precision: Precision,
        report: Callable[[int], None],
    ) -> list[Trial]:
        """Coarse trials of these sets of effects, least judged error first.

        Args:
            present: the trial whose values they begin with.
            sets: effects of each trial.
            precision: how finely the models are fitted.
            report: called with the number of trials done.
        """
        # The heaviest first, so that no core waits for one of them at the end.
        ordered = sorted(sets, key=lambda effects: -model_of(effects, precision).memory_size)
        starts = [(effects, values_for(present, effects)) for effects in ordered]
        return sorted(self.run_all(starts, precision, report), key=lambda trial: trial.nrmse)

    def run_all(
        self,
        starts: Sequence[tuple[Effects, Values]],
        precision: Precision,
        report: Callable[[int], None],
    ) -> list[Trial]:
        """Coarse trials of these sets of effects, each from its own values; in the order given."""
        report(0)
        tasks = [self._coarse_task(effects, start, precision) for effects, start in starts]
        trials = {i: trial for i, task in enumerate(tasks) if (trial := self._recall(task))}
        futures = {self.submit(run_trial, tasks[i]): i for i in range(len(tasks)) if i not in trials}
        report(len(trials))
        for future in as_completed(futures):
            i = futures[future]
            trials[i] = future.result()
            self._note(tasks[i], trials[i])
            report(len(trials))
        return [trials[i] for i in range(len(tasks))]

    def _coarse_task(self, effects: Effects, start: Values | None, precision: Precision) -> TrialTask:
        return TrialTask(
            effects, self.thinned_training, self.thinned_holdout, start, precision, self.loss
        )

    def _run(self, task: TrialTask) -> Trial:
        trial = self._recall(task)
        if trial is None:
            trial = run_trial(task)
            self._note(task, trial)
        return trial

    def _recall(self, task: TrialTask) -> Trial | None:
        return self.journal.recall(task) if self.journal else None

    def _note(self, task: TrialTask, trial: Trial) -> None:
        if self.journal:
            self.journal.note(task, trial)


def values_for(present: Trial, effects: Sequence[Effect]) -> Values:
    """The values of a trial without those of effects that are not in the set."""
    values, names = present.fitted.values, {effect.name for effect in effects}

    def of_the_set(parameters: Mapping[str, float]) -> dict[str, float]:
        return {n: v for n, v in parameters.items() if "." not in n or n.split(".")[0] in names}

    own = {name: of_the_set(values) for name, values in values.own.items()}
    return Values(shared=of_the_set(values.shared), own=own)


@contextmanager
def workers(jobs: int | None) -> Iterator[Submit]:
    """Processes to which work can be submitted; with one job it runs in this process, at once.

    An interruption cancels what waits in the queue; running trials are finished first, in seconds.

    Args:
        jobs: processes; None for one per core.
    """
    count = jobs or os.cpu_count() or 1
    if count == 1:
        yield _run_at_once
        return
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_ignore_interruptions)
    with _one_thread_each():
        try:
            yield pool.submit
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes started within do their linear algebra in one thread: there is one for every core."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _ignore_interruptions() -> None:
    """Ctrl-C reaches every process of the terminal; only the first one may act on it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run_at_once(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
    future: Future[Any] = Future()
    future.set_result(function(*arguments))
    return future
