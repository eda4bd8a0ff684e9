"""The search for the missing effects: stepwise selection, judged on recordings that were held out.

Forward, one effect at a time; when nothing more earns its place, backward: an effect without which the
others do as well is dropped; and sideways: an effect is exchanged for another. What was dropped does not
come back, so the search ends.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from identification.fits.fitting import Values
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.reading.recordings import Recording
from identification.selection.journal import Journal
from identification.selection.moves import Move, Way, moves
from identification.selection.scoring import LEAST_GAIN
from identification.selection.trial_runner import Attempts, precision_for
from identification.selection.trials import Trial
from identification.selection.workers import workers
from symbolic import EFFECTS

RUNNERS_UP = 2
"""Candidates tried on the whole recordings where the first does not hold there."""
IDLE_STEPS = 2
"""Steps in which a candidate may do next to nothing before it is left out."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """One step of the search.

    Attributes:
        before: the model before it.
        ranked_before: the same as the candidates were compared with, coarsely fitted.
        tried: what was tried, one effect more or less, best first, coarsely fitted.
        chosen: the model after it; None in the last step.
        indistinguishable: effects that would have done as well as the chosen one.
        dropped: the effect that went, in a step backward or an exchange; None in a step forward.
    """

    before: Trial
    ranked_before: Trial
    tried: tuple[Trial, ...]
    chosen: Trial | None
    indistinguishable: tuple[str, ...] = ()
    dropped: str | None = None

    @property
    def nearest_rival(self) -> str:
        """Of the effects that would have done as well, the one with the least judged error."""
        ranked = (trial.effects[-1] for trial in self.tried)
        return next(name for name in ranked if name in self.indistinguishable)

    def start_of(self, effects: tuple[str, ...]) -> Values:
        """Where the trial of these effects ended."""
        return next(t.fitted.values for t in self.tried if set(t.effects) == set(effects))

    def idle(self) -> set[str]:
        """Effects that lowered the judged error by less than half of what is needed."""
        least = (1 - LEAST_GAIN / 2) * self.ranked_before.nrmse
        return {trial.effects[-1] for trial in self.tried if trial.nrmse > least}


def search(
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
    candidates: Sequence[str] = tuple(EFFECTS),
    loss: Loss = LEAST_SQUARES,
    journal: Journal | None = None,
) -> list[Step]:
    """Add effects one at a time, drop what has become idle; the last step has nothing chosen.

    Candidates are ranked on thinned recordings with coarse fits; what is chosen is fitted again on
    everything. A candidate that did next to nothing in two steps running is left out of the next ones,
    then tried once more before the search turns back. An effect that was dropped does not come back.

    Args:
        training: recordings that the shared parameters are fitted to.
        holdout: recordings that judge; empty for leave-one-out over the training ones.
        jobs: processes to use; None for one per core.
        progress: called with what is being done, trials done, and trials in this step.
        candidates: names of the effects that may be picked.
        loss: what a residual costs.
        journal: where trials are kept, so that a search that was interrupted goes on; None for nowhere.
    """
    with workers(jobs) as submit:
        made = Attempts(training=training, holdout=holdout, loss=loss, submit=submit, journal=journal)
        return walk(made, progress or silent, candidates)


def walk(made: Attempts, report: Progress, candidates: Sequence[str] = tuple(EFFECTS)) -> list[Step]:
    """`search`, with the trials made where the caller wants them."""
    report("fitting the declared structure", 0, 1)
    current = made.whole(())
    steps: list[Step] = []
    while True:
        precision = precision_for(current)
        ranked = made.ranked(current.effects, current.fitted.values, precision)

        def try_all(sets: Sequence[tuple[str, ...]], label: str) -> list[Trial]:
            return made.all(ranked, sets, precision, lambda done: report(label, done, len(sets)))  # noqa: B023

        for move in moves(ranked, _waves(candidates, steps), made.thin_training, try_all):
            found = held(move, current, made)
            if found:
                way, after = found
                steps.append(_step(current, ranked, move, after, way.others))
                current = after
                break
            if move.forward:
                last = _step(current, ranked, move, None)
        else:
            return [*steps, last]


def held(move: Move, current: Trial, made: Attempts) -> tuple[Way, Trial] | None:
    """The first way that holds on the whole recordings as well, and the trial there."""
    for way in move.ways[: 1 + RUNNERS_UP]:
        after = made.whole(way.trial.effects, way.trial.fitted.values)
        if move.holds(after, current, made.training):
            return way, after
    return None


def _step(
    current: Trial, ranked: Trial, move: Move, after: Trial | None, others: tuple[str, ...] = ()
) -> Step:
    gone = set(current.effects) - set(after.effects) if after else set()
    return Step(
        before=current,
        ranked_before=ranked,
        tried=tuple(move.tried),
        chosen=after,
        indistinguishable=others,
        dropped=next(iter(gone), None),
    )


def _waves(candidates: Sequence[str], steps: Sequence[Step]) -> tuple[list[str], list[str]]:
    """Candidates to try, and those to try only if none of them helps: idle in the last two steps."""
    present = steps[-1].chosen.effects if steps and steps[-1].chosen else ()
    gone = {step.dropped for step in steps}
    forward = [step for step in steps if step.dropped is None][-IDLE_STEPS:]
    idle = set.intersection(*(step.idle() for step in forward)) if len(forward) == IDLE_STEPS else set()
    left = [name for name in candidates if name not in present and name not in gone]
    return [n for n in left if n not in idle], [n for n in left if n in idle]


def silent(message: str, done: int, total: int) -> None:
    """Progress that nobody sees."""
    del message, done, total
