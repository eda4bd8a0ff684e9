"""Zones of the patch by the state machine of [Györök 2022], and the torque that follows from them.

From rest the deformation has three zones. A reversal, at psi_max, makes five of them, and they are
three again once |psi| exceeds |psi_max| ([Györök 2022], section 3.1 and fig. 3.5). A reversal inside
five zones would make seven. [Györök 2022] neglects these: psi_max and the five zones stay, and the
torque runs back on the branch that it came on. The published files agree: their one reversal inside five
zones (piros2, 18.86 s of the author's time) changes neither psi_max nor direction nor zones. It is only
0.6 mrad high and may also have been taken for noise.

On either side of a reversal the torque is the virgin curve M_v of the patch at rest,

    three zones: M_z = M_v(psi),      five zones: M_z = M_v(psi_max) + 2 M_v((psi - psi_max) / 2),

which are the integrals (2.3) of [Györök 2022], (3.4), (3.5) and (3.6), as a test shows. The present load
is used for the whole history, as there.

[Györök 2022] counts three and five zones (figures 5.6 and 5.7). Every reversal within them makes two
more, until the angle passes the turning point before it and both are deleted, by Madelung's rules.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError, Rig, TurningPoints, virgin_torque
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import BufferedCall

POINT = ("mu", "turn", "turn_back", "F_N", "k", "a", "e")
"""Inputs of the torque of the zones: [1], [rad], [rad], [N], [N/m^2], [m], [m]."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ZoneState:
    """State of the state machine; angles are measured from where the patch stood at rest."""

    extreme: float = 0.0  # Farthest angle so far on the present curve of three zones [rad].
    psi_max: float = 0.0  # Angle of the last reversal, 0 before the first [rad].
    zones: int = 3  # Number of zones, 3 or 5.

    @property
    def direction(self) -> int:
        """Direction of turning, 1 or -1, that the zones are due to; 0 at rest."""
        side = self.extreme if self.zones == 3 else -self.psi_max
        return int(np.sign(side))


def advance_zones(before: ZoneState, psi: float, least_turn: float) -> ZoneState:
    """The state machine after one more angle, [Györök 2022], fig. 3.5.

    There psi_max is found afterwards, on a filtered angle. Here a reversal counts as soon as the angle
    has come back from its extreme by more than `least_turn`. Samples before that were taken for three
    zones; psi_max is the extreme itself. A false reversal ends where the angle goes on beyond it.
    psi counts from rest [rad].
    """
    after = before
    if before.zones == 3:
        if before.extreme * psi >= 0 and abs(psi) >= abs(before.extreme):
            return replace(before, extreme=psi)
        if abs(psi - before.extreme) <= least_turn:
            return before
        after = replace(before, psi_max=before.extreme, zones=5)
    return replace(after, extreme=psi, zones=3) if abs(psi) > abs(after.psi_max) else after


def turns_from_rest_and_reversal(state: ZoneState, psi: float) -> tuple[float, float]:
    """The turn from rest and the turn since the last reversal, 0 in three zones [rad]."""
    return (psi, 0.0) if state.zones == 3 else (state.psi_max, psi - state.psi_max)


TorqueCurve = Callable[[float], tuple[float, float]]
"""M_z of one sample [N m] and its derivative by mu, over mu."""


def zone_torque_curve(turns: tuple[float, float], F_N: float, k: float, rig: Rig) -> TorqueCurve:
    """The torque over mu of a patch with three or five zones.

    Turns are those of `turns_from_rest_and_reversal` [rad].
    """
    # It works in place: a call takes a microsecond.
    buffered = BufferedCall(_build_zone_torque())
    buffered.inputs[0][:] = (1.0, *turns, F_N, k, rig.a, rig.e)

    def torque(mu: float) -> tuple[float, float]:
        buffered.inputs[0][0] = mu
        buffered.call()
        M_z, by_mu = buffered.outputs[0].tolist()
        return M_z, by_mu

    return torque


@cache
def _build_zone_torque() -> ca.Function:
    point = ca.SX.sym("point", len(POINT))
    mu, turn, turn_back, F_N, k, a, e = ca.vertsplit(point)
    rest = (F_N, mu, k, a, e)
    M_z = virgin_torque(turn, *rest) + 2 * virgin_torque(turn_back / 2, *rest)
    outputs = ca.vertcat(M_z, ca.jacobian(M_z, mu))
    return ca.Function("zone_torque", [point], [outputs], ["point"], ["torque"])


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
        least_turn: turn back by which a reversal counts [rad], as of `RootObserver`.

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
        true_zones=np.array(_zones_in_memory(angles, least_turn)),
    )


def _zones_in_memory(angles: Iterable[float], least_turn: float) -> list[int]:
    """Zones by all turning points in memory at every sample; angles from rest."""
    memory, farthest, zones = TurningPoints(), 0.0, []
    for angle in angles:
        if (farthest - memory.psi[-1]) * (angle - farthest) >= 0:
            farthest = angle
        elif abs(angle - farthest) > least_turn:
            memory, farthest = memory.with_new_point(farthest, 0.0), angle
        while (farthest - memory.loop_closing_angle) * (farthest - memory.psi[-1]) > 0:
            # The curve goes on as if the last loop, or the first reversal, had never been.
            memory = memory.without_closed_loop()
        zones.append(memory.zone_count)
    return zones
