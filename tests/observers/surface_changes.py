"""The wheel turned out, back and out again on the independent rig while the ground changes under it."""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from observers import Estimates
from reference_rig import GroundRecording, free_path, friction_step, make_ground_recording
from symbolic import Model
from tests.observers.monte_carlo import estimated

HIGH, LOW = 1.2, 0.5
CORNERS = (0.0, 0.25, -0.25, 0.25)
"""Angles between which the wheel turns [rad]."""
PLACES = (0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
"""Turns since the first reversal at which the ground changes [rad]."""
CLOSE = 0.05
"""Share of mu within which an estimate counts as right [1]."""
STICK = 0.1
"""Turn after a reversal that does not count, as the patch sticks [rad]."""
BRISTLES = Model(discretised=True)
CLEAN: dict[str, Any] = {"model": BRISTLES, "mu_walk": 0.02, "gate": 5.0, "reset_after": 5}
"""Bristles keep what the ground did; a clean sensor's innovations lie within five times its noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Crossing:
    """A recording, when the ground changes in it [s], and to which friction [1]."""

    made: GroundRecording
    when: float
    after: float


@cache
def crossing(seed: int, place: float, before: float, after: float, psi_dot: float = 0.4) -> Crossing:
    """The ground changes at so great a turn since the first reversal [rad]."""
    legs = [abs(b - a) / psi_dot for a, b in pairwise(CORNERS)]
    corners = np.concatenate([[0.0], np.cumsum(legs)])
    when = legs[0] + place / psi_dot
    drive = free_path(corners, np.array(CORNERS))
    made = make_ground_recording(seed, friction_step(when, before, after), drive=drive)
    return Crossing(made=made, when=when, after=after)


def counted_turn(case: Crossing, estimates: Estimates) -> float:
    """Turn after the change until mu is within 10 % for good [rad]; inf for never.

    The first 0.1 rad after a reversal do not count: the patch sticks.
    """
    recording = case.made
    steps = np.diff(recording.psi_true, prepend=recording.psi_true[0])
    since, side, turned = 0.0, 0.0, np.zeros(steps.size)
    for i, step in enumerate(steps):
        since = since + abs(step) if step * side >= 0 else abs(step)
        side = np.sign(step) or side
        turned[i] = abs(step) * (since > STICK)
    late = recording.t >= case.when
    turned = np.cumsum(turned * late)
    off = np.flatnonzero(late & (np.abs(estimates.mu / case.after - 1) > 0.1))
    if off.size == 0:
        return 0.0
    return float(turned[off[-1] + 1]) if off[-1] + 1 < turned.size else float("inf")


def further_turn(made: Crossing, found: Estimates) -> float:
    """How far the wheel turns after the change until mu is close for good [rad]; inf for never."""
    recording = made.made
    turned = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(recording.psi_true)))])
    late = recording.t >= made.when
    off = np.flatnonzero(late & (np.abs(found.mu - made.after) > CLOSE * made.after))
    right = int(off[-1]) + 1 if off.size else int(np.argmax(late))
    if right == turned.size:
        return float("inf")
    return float(turned[right] - np.interp(made.when, recording.t, turned))


def turn_until_known(kind: Any, made: Crossing, **settings: Any) -> float:
    """`further_turn` of an observer with settings in place of those of `CLEAN` [rad]."""
    return further_turn(made, estimated(kind, made.made, **{**CLEAN, **settings}))
