"""Which candidate goes on, and which next where it does not hold."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest

from identification import Recording
from identification.selection.moves import Move, Way, moves, ways_of
from identification.selection.stepwise_search import RUNNERS_UP, held
from identification.selection.trial_runner import Attempts
from identification.selection.trials import Trial
from tests.identification.selection.compared import trials

Pair = tuple[Trial, list[Recording]]


def named(trial: Trial, name: str) -> Trial:
    return replace(trial, effects=(name,))


def test_the_best_goes_on_where_it_can_be_told_from_the_rest(pair: Pair) -> None:
    best, other = (named(t, n) for t, n in zip(trials(pair, 0.0, 2.5), "ab", strict=True))
    ways = ways_of([best, other])

    assert [way.trial for way in ways] == [best, other]
    assert [way.others for way in ways] == [(), ()]


def test_of_equals_the_one_with_the_fewest_parameters_goes_on(pair: Pair) -> None:
    dearer, other = (named(t, n) for t, n in zip(trials(pair, 0.0, 1.5), "ab", strict=True))
    ways = ways_of([dearer, other])

    assert [way.trial for way in ways] == [other, dearer]
    assert [way.others for way in ways] == [("a",), ()]


@pytest.mark.parametrize(
    ("first", "expected"), [(0, 0), (1, 1), (RUNNERS_UP, RUNNERS_UP), (RUNNERS_UP + 1, None)]
)
def test_the_next_best_is_tried_where_the_best_does_not_hold(
    pair: Pair, first: int, expected: int | None
) -> None:
    """What was ranked coarsely is fitted on everything, a few of them at most."""
    coarse = [named(pair[0], name) for name in "abcde"]
    fitted: list[str] = []

    def whole(effects: tuple[str, ...], start: object) -> Trial:
        del start
        fitted.extend(effects)
        return named(pair[0], effects[0])

    def holds(after: Trial, current: Trial, training: Sequence[Recording]) -> bool:
        assert current is pair[0]
        assert training == pair[1]
        return after.effects[0] >= coarse[first].effects[0]

    move = Move(tried=coarse, ways=[Way(trial=trial) for trial in coarse], holds=holds)
    made = cast(Attempts, SimpleNamespace(whole=whole, training=pair[1]))
    found = held(move, pair[0], made)

    assert fitted == list("abcde"[: min(first, RUNNERS_UP) + 1])
    assert (found and found[0].trial) is (None if expected is None else coarse[expected])


def test_idle_candidates_are_tried_where_the_others_do_not_hold(pair: Pair) -> None:
    """The model before is as good as they are, so none of them earns its place."""
    asked: list[list[tuple[str, ...]]] = []

    def try_all(sets: Sequence[tuple[str, ...]], label: str) -> list[Trial]:
        del label
        asked.append(list(sets))
        return [replace(pair[0], effects=effects) for effects in sets]

    first, second, backward, exchange = moves(pair[0], (["a", "b"], ["c"]), pair[1][:1], try_all)

    assert asked == [[("a",), ("b",)], [("c",)]]
    assert [trial.effects for trial in first.tried] == [("a",), ("b",)]
    assert [trial.effects for trial in second.tried] == [("a",), ("b",), ("c",)]
    assert (first.forward, second.forward) == (True, True)
    assert (backward.forward, exchange.forward) == (False, False)
    assert not any(move.ways for move in (first, second, backward, exchange))
