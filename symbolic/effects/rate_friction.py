"""Friction that grows, or falls, with the logarithm of the sliding speed, as that of rubber does.

Reference: Grosch, The relation between the friction and visco-elastic properties of rubber,
Proc. R. Soc. A 274 (1963) 21: over part of the rising flank of his master curve, a line in log speed.
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.bristle_slip import REFERENCE_SPEED, REST_SPEED
from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values, with_limit

MIN_FACTOR = 0.05
"""The logarithm is not followed below this factor [1]."""


@dataclass(frozen=True, kw_only=True)
class RateFriction(Effect):
    """Limit times 1 + c ln(sqrt(v^2 + v_0^2) / v_ref), v = |x - e| |psi_dot|.

    That is the speed at which a bristle slides if all of it is slip; `frictional_creep` takes its own.
    """

    name: str = "rate_friction"
    summary: str = (
        "friction changes by the same amount each time sliding is ten times as fast; the model's mu is"
        " friction at 1 mm/s"
    )
    family = "friction over speed"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="c", unit="1", neutral=0.0, start=0.02, lower=-0.3, upper=0.3, scale=0.05, of="friction"
        ),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the direction of friction times log speed", sign=1),
        ResidualSignature("the signed angle since the last reversal", sign=1),
        ResidualSignature("the signed time since the last reversal", sign=1),
        ResidualSignature("the yaw rate", sign=1, rank=1),
        ResidualSignature("the direction of turning", sign=1, rank=1),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """The limit of each bristle follows the speed at which the wheel drives it."""

        def factor(speed: Expression) -> Expression:
            regular = ca.sqrt(speed**2 + REST_SPEED**2)
            return ca.fmax(MIN_FACTOR, 1 + values["c"] * ca.log(regular / REFERENCE_SPEED))

        return with_limit(traits, factor)
