"""The search for the missing effects: stepwise selection, judged on recordings that were held out.

Forward, one effect at a time; when nothing more earns its place, backward: an effect without which the
others do as well is dropped; and sideways: an effect is exchanged for another. What was dropped does not
come back, so the search ends.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from identification.fits.fitting import Values
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.reading.recordings import Recording
from identification.selecting.attempts import Attempts, precision_for
from identification.selecting.journal import Journal
from identification.selecting.rules import earns_its_place, is_better, tells_apart
from identification.selecting.scoring import LEAST_GAIN
from identification.selecting.trials import Trial
from identification.selecting.workers import workers
from symbolic import EFFECTS

EXCHANGES = 3
"""Candidates that may take the place of another effect when nothing more can be added."""
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

        for move in _moves(ranked, _waves(candidates, steps), made.thin_training, try_all):
            # What was ranked on thinned recordings has to hold on the whole ones.
            leader = move.leader
            after = made.whole(leader.effects, leader.fitted.values) if leader else None
            if after and move.holds(after, current, made.training):
                steps.append(_step(current, ranked, move, after))
                current = after
                break
            if not steps or move.forward:
                last = _step(current, ranked, move, None)
        else:
            return [*steps, last]


Try = Callable[[Sequence[tuple[str, ...]], str], list[Trial]]
Judge = Callable[[Trial, Trial, Sequence[Recording]], bool]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Move:
    """A way on from the present model.

    Attributes:
        tried: what was tried, best first, coarsely fitted.
        leader: the one to go on with, None for none.
        others: effects that would do as well.
        holds: whether (after, current, training) still speaks for it on the whole recordings.
        forward: True where an effect is added and none dropped.
    """

    tried: list[Trial]
    leader: Trial | None
    others: tuple[str, ...] = ()
    holds: Judge
    forward: bool = False


def _step(current: Trial, ranked: Trial, move: _Move, after: Trial | None) -> Step:
    gone = set(current.effects) - set(after.effects) if after else set()
    return Step(
        before=current,
        ranked_before=ranked,
        tried=tuple(move.tried),
        chosen=after,
        indistinguishable=move.others if after else (),
        dropped=next(iter(gone), None),
    )


def _moves(
    ranked: Trial, waves: Sequence[Sequence[str]], training: Sequence[Recording], try_all: Try
) -> Iterator[_Move]:
    """Forward, else backward, else an exchange of one effect for another."""
    forward = _forward(ranked, waves, training, try_all)
    yield forward
    yield _backward(ranked, training, try_all)
    yield _exchange(ranked, forward.tried, training, try_all)


def _waves(candidates: Sequence[str], steps: Sequence[Step]) -> tuple[list[str], list[str]]:
    """Candidates to try, and those to try only if none of them helps: idle in the last two steps."""
    present = steps[-1].chosen.effects if steps and steps[-1].chosen else ()
    gone = {step.dropped for step in steps}
    forward = [step for step in steps if step.dropped is None][-IDLE_STEPS:]
    idle = set.intersection(*(step.idle() for step in forward)) if len(forward) == IDLE_STEPS else set()
    left = [name for name in candidates if name not in present and name not in gone]
    return [n for n in left if n not in idle], [n for n in left if n in idle]


def _forward(
    ranked: Trial, waves: Sequence[Sequence[str]], training: Sequence[Recording], try_all: Try
) -> _Move:
    """Every candidate on top of the present model."""
    label = f"trying effects on top of {', '.join(ranked.effects) or 'the declared structure'}"
    tried: list[Trial] = []
    leader: Trial | None = None
    others: tuple[str, ...] = ()
    for names in waves:
        if names and leader is None:
            tried += try_all([(*ranked.effects, name) for name in names], label)
            tried.sort(key=lambda trial: trial.nrmse)
            leader, others = _leader(ranked, tried, training)
    return _Move(tried=tried, leader=leader, others=others, holds=earns_its_place, forward=True)


def _backward(ranked: Trial, training: Sequence[Recording], try_all: Try) -> _Move:
    """The present model without one effect each; the last one has just earned its place."""
    sets = [tuple(e for e in ranked.effects if e != gone) for gone in ranked.effects[:-1]]
    tried = try_all(sets, f"trying to do without one of {', '.join(ranked.effects)}") if sets else []
    spared = [trial for trial in tried if not earns_its_place(ranked, trial, training)]

    def holds(after: Trial, current: Trial, training: Sequence[Recording]) -> bool:
        return not earns_its_place(current, after, training)

    return _Move(tried=tried, leader=spared[0] if spared else None, holds=holds)


def _exchange(
    ranked: Trial, tried: Sequence[Trial], training: Sequence[Recording], try_all: Try
) -> _Move:
    """The candidates that helped most, though not enough, each in the place of one that is there."""
    helpful = [t.effects[-1] for t in tried if t.nrmse < (1 - LEAST_GAIN) * ranked.nrmse][:EXCHANGES]
    sets = [
        (*(e for e in ranked.effects if e != gone), name) for name in helpful for gone in ranked.effects
    ]
    swapped = try_all(sets, f"exchanging one of {', '.join(ranked.effects)}") if sets else []
    better = [trial for trial in swapped if is_better(trial, ranked, training)]
    return _Move(tried=swapped, leader=better[0] if better else None, holds=is_better)


def _leader(
    ranked: Trial, tried: Sequence[Trial], training: Sequence[Recording]
) -> tuple[Trial | None, tuple[str, ...]]:
    """The candidate that goes on, and the effects that would have done as well.

    The best that earns its place, or the one with the fewest parameters among those that cannot be told
    from it.
    """
    worthy = [trial for trial in tried if earns_its_place(trial, ranked, training)]
    if not worthy:
        return None, ()
    equals = [trial for trial in worthy if not tells_apart(worthy[0], trial)]
    leader = min(equals, key=lambda trial: (len(trial.fitted.labels), trial.nrmse))
    return leader, tuple(trial.effects[-1] for trial in equals if trial is not leader)


def silent(message: str, done: int, total: int) -> None:
    """Progress that nobody sees."""
    del message, done, total
