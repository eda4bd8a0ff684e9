"""The memory of turning points: the exact patch under a constant load, in closed form.

The limits of every bristle are symmetric, so Masing's rules hold: from a turning point psi_r on, where
the torque was M_r,

    M_z = M_r + 2 M_v((psi - psi_r) / 2),

with M_v the torque of the virgin patch. A loop that closes is forgotten (Madelung). The same patch
under a changing load, and as one expression, is `symbolic.exact_zone_patch`.
"""

from dataclasses import dataclass
from math import nan

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from symbolic.errors import InvalidInputError
from symbolic.exact_zone_patch import FAR
from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression
from symbolic.patch_moment_by_zones import (
    edge_to_boundary_distance,
    full_slide_level,
    unit_corner_moment,
)
from symbolic.rig_and_tyre import Rig, Tyre


def virgin_torque(
    psi: Expression, F_N: Expression, mu: Expression, k: Expression, a: Expression, e: Expression
) -> Expression:
    """M_v: torque of a virgin patch turned by psi [N m], [Györök 2022], (2.3) with (3.4).

    Args:
        psi: the turn, of either sign; M_v is odd [rad].
        F_N: vertical load [N].
        mu: coefficient of friction [1].
        k: distributed lateral stiffness [N/m^2].
        a: half-length of the contact patch [m].
        e: caster length [m].
    """
    slope = full_slide_level(F_N, a) * mu / k
    boundary = slope / ca.fmax(ca.fabs(psi), slope / FAR)
    return -k * psi * (unit_corner_moment(0, a, e) - unit_corner_moment(boundary, a, e))


def branch_torque(psi: Expression, branch: Expression, *constants: Expression) -> Expression:
    """M_z [N m] on a branch as of `TurningPoints.branch`; constants are F_N, mu, k, a and e."""
    psi_r, M_r, scale = ca.vertsplit(branch)
    return M_r + scale * virgin_torque((psi - psi_r) / scale, *constants)


@dataclass(frozen=True, kw_only=True)
class TurningPoints:
    """Turning points that determine the torque (the memory of the patch), oldest first.

    Attributes:
        psi: the angle of rest, then the turning points [rad].
        M_z: the aligning torque at each [N m].
    """

    psi: tuple[float, ...] = (0.0,)
    M_z: tuple[float, ...] = (0.0,)

    @property
    def branch(self) -> tuple[float, float, float]:
        """Angle [rad] and torque [N m] at the beginning of the present branch, and its scale [1]."""
        return self.psi[-1], self.M_z[-1], 1.0 if len(self.psi) == 1 else 2.0

    @property
    def loop_closing_angle(self) -> float:
        """The angle at which the present loop closes; NaN on the virgin branch [rad]."""
        if len(self.psi) == 1:
            return nan
        return 2 * self.psi[0] - self.psi[1] if len(self.psi) == 2 else self.psi[-2]

    @property
    def zone_count(self) -> int:
        """Zones of the deformation while the wheel turns: 3 on the virgin branch, 2 a turning point."""
        return 2 * len(self.psi) + 1

    def with_new_point(self, psi: float, M_z: float) -> "TurningPoints":
        """The memory after a turn back at an angle [rad] with the torque there [N m]."""
        return TurningPoints(psi=(*self.psi, psi), M_z=(*self.M_z, M_z))

    def without_last_point(self) -> "TurningPoints":
        """The memory without the last turn back: the wheel has not turned since."""
        return self._without_points(1)

    def without_closed_loop(self) -> "TurningPoints":
        """The memory after the present loop has closed: its two turning points are forgotten."""
        return self._without_points(2)

    def _without_points(self, turns: int) -> "TurningPoints":
        kept = max(1, len(self.psi) - turns)
        return TurningPoints(psi=self.psi[:kept], M_z=self.M_z[:kept])


def lateral_deformation(
    x: ArrayLike, psi: float, memory: TurningPoints, F_N: float, rig: Rig, tyre: Tyre
) -> Array:
    """The lateral deformation q(x) of the patch [m], [Györök 2022], (2.15) and (2.16).

    Every bristle is a stop, and between turning points it moves one way, so one clip a branch is exact.

    Args:
        x: places in [-a, a], shape (n,) [m].
        psi: the present angle [rad].
        memory: turning points of the patch.
        F_N: vertical load [N].
        rig: a and e are used.
        tyre: k and mu.
    """
    places = np.asarray(x, dtype=np.float64)
    limit = deformation_limit(places, F_N, rig, tyre)
    q = np.zeros_like(places)
    for turn in np.diff([*memory.psi, psi]):
        q = np.clip(q - (places - rig.e) * turn, -limit, limit)
    return q


def zone_boundaries(psi: float, memory: TurningPoints, F_N: float, rig: Rig, tyre: Tyre) -> Array:
    """Boundaries between the zones of the deformation, from rear to front [m].

    Every branch has left one boundary on either side of the kingpin: there the bristles just reached
    their limit. The outermost ones bound what slides while the wheel turns on.

    Args:
        psi: the present angle [rad].
        memory: turning points of the patch.
        F_N: vertical load [N].
        rig: a and e are used.
        tyre: k and mu.
    """
    slope = full_slide_level(F_N, rig.a) * require_mu(tyre) / tyre.k
    turns = np.abs(np.diff([*memory.psi, psi]))
    scales = np.where(np.arange(len(turns)) == 0, 1.0, 2.0)
    z = scales[turns > 0] * slope / turns[turns > 0]
    front = [rig.a - float(edge_to_boundary_distance(each, rig.a, rig.a - rig.e)) for each in z]
    rear = [-rig.a + float(edge_to_boundary_distance(each, rig.a, rig.a + rig.e)) for each in z]
    return np.array(sorted([*rear, *front]))


def deformation_limit(x: ArrayLike, F_N: float, rig: Rig, tyre: Tyre) -> Array:
    """The largest deformation q_cr(x) that friction allows [m], [Györök 2022], (2.1).

    Raises:
        InvalidInputError: the tyre has no mu.
    """
    places = np.asarray(x, dtype=np.float64)
    level = full_slide_level(F_N, rig.a) * require_mu(tyre) / tyre.k
    return np.asarray(level * (rig.a**2 - places**2))


def require_mu(tyre: Tyre) -> float:
    """The tyre's mu [1]; refused where it has none."""
    if tyre.mu is None:
        raise InvalidInputError("a simulation needs the tyre's mu, got none")
    return tyre.mu
