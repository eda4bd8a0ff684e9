"""Ways on from the present model: an effect more, an effect less, one for another."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from identification.reading.recordings import Recording
from identification.selection.criteria import earns_its_place, is_better, tells_apart
from identification.selection.scoring import LEAST_GAIN
from identification.selection.trials import Trial

EXCHANGES = 3
"""Candidates that may take the place of another effect when nothing more can be added."""

Try = Callable[[Sequence[tuple[str, ...]], str], list[Trial]]
Judge = Callable[[Trial, Trial, Sequence[Recording]], bool]


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """One way on.

    Attributes:
        trial: where it leads, coarsely fitted.
        others: effects that would have done as well.
    """

    trial: Trial
    others: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Move:
    """A kind of change of the present model.

    Attributes:
        tried: what was tried, best first, coarsely fitted.
        ways: those worth going, best first.
        holds: whether (after, current, training) still speaks for it on the whole recordings.
        forward: True where any effect may be added.
    """

    tried: Sequence[Trial]
    ways: Sequence[Way]
    holds: Judge
    forward: bool = False


def moves(
    ranked: Trial, waves: Sequence[Sequence[str]], training: Sequence[Recording], try_all: Try
) -> Iterator[Move]:
    """Forward, else backward, else an exchange of one effect for another.

    Args:
        ranked: the present model, coarsely fitted.
        waves: candidates, a group to be tried only if none before it helps.
        training: the training recordings as coarse trials are made on them.
        try_all: makes coarse trials of (sets of effects, what to say meanwhile), best first.
    """
    for forward in _forward(ranked, waves, training, try_all):
        yield forward
    yield _backward(ranked, training, try_all)
    yield _exchange(ranked, forward.tried, training, try_all)


def _forward(
    ranked: Trial, waves: Sequence[Sequence[str]], training: Sequence[Recording], try_all: Try
) -> Iterator[Move]:
    """Every candidate on top of the present model, a wave at a time."""
    label = f"trying effects on top of {', '.join(ranked.effects) or 'the declared structure'}"
    tried: list[Trial] = []
    for names in waves:
        new = try_all([(*ranked.effects, name) for name in names], label) if names else []
        tried = sorted([*tried, *new], key=lambda trial: trial.nrmse)
        ways = ways_of([trial for trial in new if earns_its_place(trial, ranked, training)])
        yield Move(tried=tried, ways=ways, holds=earns_its_place, forward=True)


def _backward(ranked: Trial, training: Sequence[Recording], try_all: Try) -> Move:
    """The present model without one effect each, but for the one that came last."""
    sets = [tuple(e for e in ranked.effects if e != gone) for gone in ranked.effects[:-1]]
    tried = try_all(sets, f"trying to do without one of {', '.join(ranked.effects)}") if sets else []

    def holds(after: Trial, current: Trial, training: Sequence[Recording]) -> bool:
        return not earns_its_place(current, after, training)

    ways = [Way(trial=trial) for trial in tried if holds(trial, ranked, training)]
    return Move(tried=tried, ways=ways, holds=holds)


def _exchange(
    ranked: Trial, tried: Sequence[Trial], training: Sequence[Recording], try_all: Try
) -> Move:
    """The candidates that helped most, though not enough, each in the place of one that is there."""
    helpful = [t.effects[-1] for t in tried if t.nrmse < (1 - LEAST_GAIN) * ranked.nrmse][:EXCHANGES]
    sets = [
        (*(e for e in ranked.effects if e != gone), name) for name in helpful for gone in ranked.effects
    ]
    swapped = try_all(sets, f"exchanging one of {', '.join(ranked.effects)}") if sets else []
    ways = [Way(trial=trial) for trial in swapped if is_better(trial, ranked, training)]
    return Move(tried=swapped, ways=ways, holds=is_better)


def ways_of(worthy: Sequence[Trial]) -> list[Way]:
    """The candidates in the order in which they should go on, each with those that would do as well.

    The best comes first, or the one with the fewest parameters among those that cannot be told from it.
    """
    ways, left = [], list(worthy)
    while left:
        equals = [trial for trial in left if not tells_apart(left[0], trial)]
        leader = min(equals, key=lambda trial: (len(trial.fitted.labels), trial.nrmse))
        others = tuple(trial.effects[-1] for trial in equals if trial is not leader)
        ways.append(Way(trial=leader, others=others))
        left.remove(leader)
    return ways
