"""Trials made for a search: coarse ones many at a time on thinned recordings, fine ones on all."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import cached_property

from identification.fits.fitting import Values
from identification.fits.loss import Loss
from identification.reading.recordings import Recording
from identification.selection.journal import Journal
from identification.selection.trials import (
    RANKING,
    ROUGH,
    ROUGH_ABOVE,
    Precision,
    Task,
    Trial,
    attempt,
    model_of,
    thinned,
)
from identification.selection.workers import Submit

Effects = tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Attempts:
    """Where the trials of one search are made.

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
    def thin_training(self) -> Sequence[Recording]:
        """The training recordings as candidates are compared on them."""
        return [thinned(recording) for recording in self.training]

    @cached_property
    def thin_holdout(self) -> Sequence[Recording]:
        """The held-out ones."""
        return [thinned(recording) for recording in self.holdout]

    def whole(self, effects: Effects, start: Values | None = None) -> Trial:
        """A trial on the whole recordings."""
        return self._one(Task(effects, self.training, self.holdout, start, loss=self.loss))

    def ranked(self, effects: Effects, start: Values | None, precision: Precision) -> Trial:
        """A trial as candidates are compared, on thinned recordings."""
        return self._one(self._thin_task(effects, start, precision))

    def all(
        self,
        present: Trial,
        sets: Sequence[Effects],
        precision: Precision,
        report: Callable[[int], None],
    ) -> list[Trial]:
        """Sets of effects ranked from the present values, best first.

        Args:
            present: the trial whose values they begin with.
            sets: effects of each trial.
            precision: how finely.
            report: called with the number of trials done.
        """
        # The heaviest first, so that no core waits for one of them at the end.
        ordered = sorted(sets, key=lambda effects: -model_of(effects, precision).memory_size)
        wanted = [(effects, values_for(present, effects)) for effects in ordered]
        return sorted(self.together(wanted, precision, report), key=lambda trial: trial.nrmse)

    def together(
        self,
        wanted: Sequence[tuple[Effects, Values]],
        precision: Precision,
        report: Callable[[int], None],
    ) -> list[Trial]:
        """Effects ranked on thinned recordings, each from its own values; in the order given."""
        report(0)
        tasks = [self._thin_task(effects, start, precision) for effects, start in wanted]
        made = {i: kept for i, task in enumerate(tasks) if (kept := self._recall(task))}
        waiting = {self.submit(attempt, tasks[i]): i for i in range(len(tasks)) if i not in made}
        report(len(made))
        for future in as_completed(waiting):
            i = waiting[future]
            made[i] = future.result()
            self._note(tasks[i], made[i])
            report(len(made))
        return [made[i] for i in range(len(tasks))]

    def _thin_task(self, effects: Effects, start: Values | None, precision: Precision) -> Task:
        return Task(effects, self.thin_training, self.thin_holdout, start, precision, self.loss)

    def _one(self, task: Task) -> Trial:
        trial = self._recall(task)
        if trial is None:
            trial = attempt(task)
            self._note(task, trial)
        return trial

    def _recall(self, task: Task) -> Trial | None:
        return self.journal.recall(task) if self.journal else None

    def _note(self, task: Task, trial: Trial) -> None:
        if self.journal:
            self.journal.note(task, trial)


def precision_for(trial: Trial) -> Precision:
    """How finely candidates on top of this trial have to be fitted to be ranked."""
    return ROUGH if trial.nrmse > ROUGH_ABOVE else RANKING


def values_for(present: Trial, effects: Sequence[str]) -> Values:
    """The present values without those of effects that are not in the set."""
    values = present.fitted.values

    def kept(given: Mapping[str, float]) -> dict[str, float]:
        return {n: v for n, v in given.items() if "." not in n or n.split(".")[0] in effects}

    return Values(shared=kept(values.shared), own={name: kept(own) for name, own in values.own.items()})
