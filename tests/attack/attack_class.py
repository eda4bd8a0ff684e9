"""What an attack is, how long it goes on, and what it says afterwards."""

import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from random import Random
from time import monotonic
from typing import Any, NamedTuple

BUFFER = 8192
"""Random bytes that an example of hypothesis is drawn from."""


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How long a class goes on: until the seconds are over or the inputs are used up.

    Attributes:
        seconds: of one class [s].
        inputs: of one class; what cannot be counted beforehand may exceed it.
        seed: of whatever is drawn.
    """

    seconds: float
    inputs: int
    seed: int = 0


class Tried(NamedTuple):
    """How many files, runs, samples or examples were tried, a line on what went wrong, and a note."""

    inputs: int
    failure: str | None = None
    note: str = ""


Attack = Callable[[Effort], Iterator[Tried]]
"""Goes on for ever, or ends where there is no more to try; whatever it raises counts as a failure."""
Classes = Mapping[str, Attack]
"""By the name on the command line."""


def one_by_one(attempt: Callable[[int], str | None]) -> Attack:
    """An attack of numbered attempts, counted from the seed on; each returns a line for a failure."""
    return lambda effort: (Tried(1, attempt(number)) for number in count(effort.seed))


def examples(*tests: Callable[..., Any]) -> Attack:
    """An attack that draws examples of each test of hypothesis in turn; none may take a fixture."""

    def attack(effort: Effort) -> Iterator[Tried]:
        for drawn in count():
            test: Any = tests[drawn % len(tests)]
            buffer = Random(effort.seed * 10**9 + drawn).randbytes(BUFFER)
            try:
                # None where no example can be drawn from the bytes.
                yield Tried(test.hypothesis.fuzz_one_input(buffer) is not None)
            except Exception as error:
                yield Tried(1, f"{test.__name__}: {type(error).__name__}: {error}")

    return attack


class Outcome(NamedTuple):
    """Inputs that a class has tried, its failures, none twice, and its last note."""

    inputs: int
    failures: tuple[str, ...]
    note: str


def undertake(attack: Attack, effort: Effort) -> Outcome:
    """The outcome of an attack after so much effort."""
    end, inputs, failures, note = monotonic() + effort.seconds, 0, dict[str, None](), ""
    try:
        for tried in attack(effort):
            inputs, note = inputs + tried.inputs, tried.note or note
            failures |= dict.fromkeys(filter(None, [tried.failure]))
            if inputs >= effort.inputs or monotonic() > end:
                break
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        failures[f"{type(error).__name__} at {place.filename}:{place.lineno}: {error}"] = None
    return Outcome(inputs, tuple(failures), note)
