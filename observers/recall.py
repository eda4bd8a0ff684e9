"""What a window keeps of the patch, so that M_z at each of its samples can be had for other states.

Two ways, one interface. `Kept`: where the memory depends on no state, the advanced memory of every
sample is kept and only the torque is taken anew. `Followed`: else the memory before the oldest sample is
kept, and the patch is taken through the window again, at the states.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import casadi as ca

from observers.linear import directions
from observers.meeting import (
    build_meeting,
    build_torque,
    carries,
    history_fields,
    signals_of,
    states_of_tyre,
)
from observers.sensing import CLEAN, Sensing
from symbolic import SIGNALS, Model

Parts = Mapping[str, ca.MX]
DT = CLEAN.index("dt")


class Recall(Protocol):
    """What a window keeps; rig begins with a and e, samples hold `CLEAN` in their first rows."""

    @property
    def fields(self) -> tuple[tuple[str, int, int], ...]:
        """Names and shapes of the parts kept."""

    def leave(
        self, parts: Parts, oldest: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[Parts, ca.MX, ca.MX]:
        """The parts without the oldest sample; its M_z and slopes at its x."""

    def newest(self, parts: Parts) -> tuple[ca.MX, ca.MX]:
        """M_z and slopes of the newest sample, before another enters; 0 where no motion needs them."""

    def enter(self, parts: Parts, now: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX) -> Parts:
        """The parts with the new sample."""

    def along(
        self, parts: Parts, samples: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[ca.MX, ca.MX]:
        """M_z (1, N) and slopes (d, N) of every sample at its x (n, N)."""


@cache
def recall_of(model: Model, sensing: Sensing, window: int) -> Recall:
    """The way that suits a model."""
    free = not (sensing.turns or carries(model, sensing))
    kind: type[Kept] | type[Followed] = Kept if free else Followed
    return kind(model=model, sensing=sensing, window=window)


@dataclass(frozen=True, kw_only=True)
class Kept:
    """The memory after every sample, which no state changes."""

    model: Model
    sensing: Sensing
    window: int

    @property
    def fields(self) -> tuple[tuple[str, int, int], ...]:
        """Memories after each sample, and the signals that the patch saw."""
        return (("memories", self.model.memory_size, self.window), ("seen", len(SIGNALS), self.window))

    def leave(
        self, parts: Parts, oldest: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[Parts, ca.MX, ca.MX]:
        """Nothing is dropped before the new one enters; see `Recall.leave`."""
        del oldest
        torque = build_torque(self.model, self.sensing)
        M_z, slopes = torque(
            parts["memories"][:, 0], parts["seen"][:, 0], states_of_tyre(self.sensing, x), theta, rig[:2]
        )
        return parts, M_z, slopes

    def newest(self, parts: Parts) -> tuple[ca.MX, ca.MX]:
        """States that only walk ask for no torque; see `Recall.newest`."""
        del parts
        return ca.MX(0), ca.MX.zeros(len(directions(self.sensing)))

    def enter(self, parts: Parts, now: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX) -> Parts:
        """Advance the newest memory; see `Recall.enter`."""
        signals = signals_of(self.sensing, x, now)
        memory, seen = self.model.advance(parts["memories"][:, -1], signals, theta, rig[:2])
        return {
            "memories": ca.horzcat(parts["memories"][:, 1:], memory),
            "seen": ca.horzcat(parts["seen"][:, 1:], seen),
        }

    def along(
        self, parts: Parts, samples: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[ca.MX, ca.MX]:
        """The torque alone; see `Recall.along`."""
        del samples
        torque = build_torque(self.model, self.sensing).map(self.window)
        constant = (ca.repmat(vector, 1, self.window) for vector in (theta, rig[:2]))
        M_z, slopes = torque(
            parts["memories"], parts["seen"], states_of_tyre(self.sensing, x), *constant
        )
        return M_z, slopes


@dataclass(frozen=True, kw_only=True)
class Followed:
    """The memory before the oldest sample, followed through the window at the states."""

    model: Model
    sensing: Sensing
    window: int

    @property
    def fields(self) -> tuple[tuple[str, int, int], ...]:
        """The history before the oldest sample, M_z and slopes of the newest."""
        count = build_meeting(self.model, self.sensing).size1_out("slopes")
        return (*history_fields(self.model, self.sensing), ("M_z", 1, 1), ("slopes", count, 1))

    def leave(
        self, parts: Parts, oldest: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[Parts, ca.MX, ca.MX]:
        """The history meets the oldest sample; see `Recall.leave`."""
        *history, M_z, slopes = self._meet_or_pass(*self._history(parts), oldest, x, theta, rig[:2])
        names = (name for name, *_ in history_fields(self.model, self.sensing))
        return {**parts, **dict(zip(names, history, strict=True))}, M_z, slopes

    def newest(self, parts: Parts) -> tuple[ca.MX, ca.MX]:
        """As the last pass left them; see `Recall.newest`."""
        return parts["M_z"], parts["slopes"]

    def enter(self, parts: Parts, now: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX) -> Parts:
        """The new sample is met on the way through the window; see `Recall.enter`."""
        del now, x, theta, rig
        return parts

    def along(
        self, parts: Parts, samples: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[ca.MX, ca.MX]:
        """Once through the window; see `Recall.along`."""
        history = self._history(parts)
        through = self._meet_or_pass.mapaccum("window_followed", self.window, len(history), {})
        constant = (ca.repmat(vector, 1, self.window) for vector in (theta, rig[:2]))
        *_, M_z, slopes = through(*history, samples[: len(CLEAN), :], x, *constant)
        return M_z, slopes

    def _history(self, parts: Parts) -> list[ca.MX]:
        return [parts[name] for name, *_ in history_fields(self.model, self.sensing)]

    @property
    def _meet_or_pass(self) -> ca.Function:
        return _build_meet_or_pass(self.model, self.sensing)


@cache
def _build_meet_or_pass(model: Model, sensing: Sensing) -> ca.Function:
    """(*history, sample, x, theta, geometry) -> (*history, M_z, slopes); nothing in an empty place."""
    meeting = build_meeting(model, sensing)
    history = [ca.MX.sym(*field) for field in history_fields(model, sensing)]
    sample, x = ca.MX.sym("sample", len(CLEAN)), ca.MX.sym("x", len(sensing.states))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    made = meeting(*history, signals_of(sensing, x, sample), states_of_tyre(sensing, x), theta, geometry)
    otherwise: list[ca.MX] = [*history, ca.MX(0), ca.MX(0)]
    chosen = [ca.if_else(sample[DT] > 0, a, b) for a, b in zip(made, otherwise, strict=True)]
    return ca.Function("met_or_passed", [*history, sample, x, theta, geometry], chosen)
