"""What an attack is, and what it says afterwards; a class of attack is one of them under its name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
from time import monotonic


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

    def rounds(self) -> "Callable[[int], bool]":
        """A clock that starts now: whether to go on after so many inputs."""
        end = monotonic() + self.seconds
        return lambda done: done < self.inputs and monotonic() < end


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a class did.

    Attributes:
        inputs: files, runs, samples or examples tried.
        failures: one line each; none where all promises held.
        note: one line on what was not as usual, empty for nothing.
    """

    inputs: int
    failures: tuple[str, ...] = ()
    note: str = ""


Attack = Callable[[Effort], Outcome]
"""Whatever it raises counts as a failure."""
Classes = Mapping[str, Attack]
"""By the name on the command line."""


def one_by_one(attempt: Callable[[int], str | None]) -> Attack:
    """An attack of numbered attempts.

    Args:
        attempt: takes the number of the attempt, counted from the seed on; returns a line on what went
            wrong, None for nothing.
    """

    def attack(effort: Effort) -> Outcome:
        goes_on, failures = effort.rounds(), []
        for done in count():
            if not goes_on(done):
                return Outcome(inputs=done, failures=tuple(failures))
            if failure := attempt(effort.seed + done):
                failures.append(failure)
        raise AssertionError

    return attack
