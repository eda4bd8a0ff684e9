"""Ways on from the present model: an effect more, one less, one for another, a small but evident one."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from identification.reading.recordings import Recording
from identification.selecting.attempts import Attempts
from identification.selecting.rules import (
    earns_its_place,
    is_better,
    is_evident,
    tells_apart,
    the_only_promising,
)
from identification.selecting.scoring import LEAST_GAIN
from identification.selecting.trials import Trial

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
        proves: True where what is added is small but evident.
    """

    tried: Sequence[Trial]
    ways: Sequence[Way]
    holds: Judge
    forward: bool = False
    proves: bool = False


def moves(
    ranked: Trial,
    waves: Sequence[Sequence[str]],
    proven: set[str],
    made: Attempts,
    try_all: Try,
) -> Iterator[Move]:
    """Forward, else backward, else an exchange, else what is small but evident.

    Args:
        ranked: the present model, coarsely fitted.
        waves: candidates, a group to be tried only if none before it helps.
        proven: effects that are here because they are evident; they are not dropped for being small.
        made: where trials are made.
        try_all: makes coarse trials of (sets of effects, what to say meanwhile), best first.
    """
    training = made.thin_training
    forward = _forward(ranked, waves, training, try_all)
    yield forward
    yield _backward(ranked, proven, training, try_all)
    yield _exchange(ranked, forward.tried, proven, training, try_all)
    yield _evident(ranked, forward.tried, made)


def _forward(
    ranked: Trial, waves: Sequence[Sequence[str]], training: Sequence[Recording], try_all: Try
) -> Move:
    """Every candidate on top of the present model."""
    label = f"trying effects on top of {', '.join(ranked.effects) or 'the declared structure'}"
    tried: list[Trial] = []
    ways: list[Way] = []
    for names in waves:
        if names and not ways:
            tried += try_all([(*ranked.effects, name) for name in names], label)
            tried.sort(key=lambda trial: trial.nrmse)
            ways = ways_of([trial for trial in tried if earns_its_place(trial, ranked, training)])
    return Move(tried=tried, ways=ways, holds=earns_its_place, forward=True)


def _backward(ranked: Trial, proven: set[str], training: Sequence[Recording], try_all: Try) -> Move:
    """The present model without one effect each; the last one has just earned its place."""
    sets = [
        tuple(e for e in ranked.effects if e != gone)
        for gone in ranked.effects[:-1]
        if gone not in proven
    ]
    tried = try_all(sets, f"trying to do without one of {', '.join(ranked.effects)}") if sets else []

    def holds(after: Trial, current: Trial, training: Sequence[Recording]) -> bool:
        return not earns_its_place(current, after, training)

    ways = [Way(trial=trial) for trial in tried if holds(trial, ranked, training)]
    return Move(tried=tried, ways=ways, holds=holds)


def _exchange(
    ranked: Trial,
    tried: Sequence[Trial],
    proven: set[str],
    training: Sequence[Recording],
    try_all: Try,
) -> Move:
    """The candidates that helped most, though not enough, each in the place of one that is there."""
    helpful = [t.effects[-1] for t in tried if t.nrmse < (1 - LEAST_GAIN) * ranked.nrmse][:EXCHANGES]
    sets = [
        (*(e for e in ranked.effects if e != gone), name)
        for name in helpful
        for gone in ranked.effects
        if gone not in proven
    ]
    swapped = try_all(sets, f"exchanging one of {', '.join(ranked.effects)}") if sets else []
    ways = [Way(trial=trial) for trial in swapped if is_better(trial, ranked, training)]
    return Move(tried=swapped, ways=ways, holds=is_better)


def _evident(ranked: Trial, tried: Sequence[Trial], made: Attempts) -> Move:
    """A candidate that leaves nothing but noise and changes the torque little, but beyond doubt.

    What several explain nearly as well may be an error of the patch. That of the other moves is too
    coarse to tell; both models are fitted with a finer one.
    """
    ways = [Way(trial=trial) for trial in the_only_promising(tried, ranked, made.thin_training)]

    def holds(after: Trial, current: Trial, training: Sequence[Recording]) -> bool:
        with_it, without = (made.finest(t.effects, t.fitted.values) for t in (after, current))
        return is_evident(with_it, without, training)

    return Move(tried=tried, ways=ways, holds=holds, proves=True)


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
