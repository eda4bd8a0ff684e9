"""Backlash in series with the patch: a gap that is crossed at no torque.

Between the angle sensor and the patch a joint, a key or a gear has play. While its flanks touch, the
patch follows; when the torque changes sign, the wheel turns on through the gap and no torque arises.
The gap is a dead zone beside the compliance in series; contact of the flanks is rounded, so that the
torque has a derivative everywhere.

Another law is the play operator: an angle sensor that sits behind play of its own, with dry friction
that holds it. There the patch is held too while the gap is crossed, and its torque stays what it was.

Reference: Nordin and Gutman, Controlling mechanical systems with backlash - a survey, Automatica 38
(2002) 1633, on the dead-zone model of a shaft and on the play operator. The rounding is ours.
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values

ROUNDING = 1e-4
"""Torque over load at which 70 % of a half of the gap are crossed [m]; 0.5 % of a full slide's."""


@dataclass(frozen=True, kw_only=True)
class Backlash(Effect):
    """The patch is turned by psi + gap/2 s, s = w / sqrt(1 + w^2), w = M_z / (F_N `ROUNDING`).

    A recording begins in the middle of the gap if nothing else is known; `pretwist` moves it.
    """

    name: str = "backlash"
    summary: str = "play in series with the patch, crossed at no torque"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="gap", unit="rad", neutral=0.0, start=0.005, lower=0.0, upper=0.5, scale=0.02),
    )
    is_gap: bool = True
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the torque near zero", sign=1),)

    def deflection(self, M_z: Expression, F_N: Expression, values: Values) -> Expression:
        """The part of the gap that the torque has crossed [rad]."""
        w = M_z / (F_N * ROUNDING)
        return values["gap"] / 2 * w / ca.sqrt(1 + w**2)
