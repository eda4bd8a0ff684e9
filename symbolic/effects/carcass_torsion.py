"""Torsion of carcass and rim in series with the contact patch.

Reference: Pacejka, Tire and Vehicle Dynamics, 3rd ed. (2012), on carcass compliance.
"""

import math
from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values


@dataclass(frozen=True, kw_only=True)
class CarcassTorsion(Effect):
    """The patch is turned by psi + M_z / k_t, solved for at every sample."""

    name: str = "carcass_torsion"
    summary: str = "the carcass twists in series with the patch"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="k_t", unit="N m/rad", neutral=math.inf, start=300.0, lower=10.0, upper=math.inf,
            scale=300.0, inverse=True,
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the angle", sign=-1),
        ResidualSignature("the rate of the torque", sign=1, rank=1),
    )

    def deflection(self, M_z: Expression, F_N: Expression, values: Values) -> Expression:
        """The torque over the torsional stiffness [rad]."""
        return M_z * values["1/k_t"]
