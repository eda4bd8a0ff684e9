"""Direction and number of zones of the patch along a recording, by [Györök 2022] and in full.

[Györök 2022] counts three and five zones (section 3.1, figures 5.6 and 5.7). Every reversal within them
makes two more, until the angle passes the turning point before it and both are deleted, by Madelung's
rules.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from observers.thesis.zone_state_machine import ZoneState, advance_zones
from symbolic import InvalidInputError

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ZoneHistory:
    """Direction and number of zones at every sample; arrays of shape (n,).

    Attributes:
        direction: of turning, 1 or -1, by the state machine of [Györök 2022]; 0 at rest.
        psi_max: angle of the last reversal by the state machine, 0 before the first [rad].
        zones: 3 or 5, by the state machine.
        true_zones: 3, 5, 7 and so on, from all turning points in memory.
    """

    direction: Counts
    psi_max: Array
    zones: Counts
    true_zones: Counts


def zone_history(psi: Array, least_turn: float = 5e-4) -> ZoneHistory:
    """Direction and zones at every sample, causally.

    Args:
        psi: yaw angle, shape (n,), without gaps; the patch stands at rest at its first sample [rad].
        least_turn: turn back by which a reversal counts [rad], as of `ZoneRootSolver`.

    Raises:
        InvalidInputError: psi is no such array, or least_turn is out of range.
    """
    if psi.ndim != 1 or psi.size == 0 or not np.isfinite(psi).all():
        raise InvalidInputError("psi must be finite and of shape (n,) with n >= 1")
    if not 0 <= least_turn < np.inf:
        raise InvalidInputError(f"least_turn must be finite and at least 0 rad, got {least_turn}")
    angles = (psi - psi[0]).tolist()
    state, states = ZoneState(), []
    for angle in angles:
        state = advance_zones(state, angle, least_turn)
        states.append(state)
    reversed_once = np.array([state.psi_max for state in states])
    return ZoneHistory(
        direction=np.array([state.direction for state in states]),
        psi_max=np.where(reversed_once != 0, reversed_once + psi[0], 0.0),
        zones=np.array([state.zones for state in states]),
        true_zones=3 + 2 * np.array(_depths(angles, least_turn)),
    )


def _depths(angles: Iterable[float], least_turn: float) -> list[int]:
    """Turning points in memory at every sample; angles from rest."""
    turns: list[float] = []
    farthest, depths = 0.0, []
    for angle in angles:
        side = farthest - (turns[-1] if turns else 0.0)
        if side * (angle - farthest) >= 0:
            farthest = angle
        elif abs(angle - farthest) > least_turn:
            turns.append(farthest)
            farthest = angle
        while turns and _is_beyond_last_reversal(turns, farthest):
            # The curve goes on as if the last loop, or the first reversal, had never been.
            del turns[-2:]
        depths.append(len(turns))
    return depths


def _is_beyond_last_reversal(reversals: list[float], extreme: float) -> bool:
    """True where the angle has gone on beyond the last turning point on its side."""
    if len(reversals) == 1:
        return abs(extreme) > abs(reversals[0])
    before, last = reversals[-2:]
    return (extreme - before) * (before - last) > 0
