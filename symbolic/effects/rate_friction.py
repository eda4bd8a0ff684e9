"""Friction that grows, or falls, with the logarithm of the sliding speed, as that of rubber does.

Source: Grosch, The relation between the friction and visco-elastic properties of rubber,
Proc. R. Soc. A 274 (1963) 21: over part of the rising flank of his master curve, a line in log speed.

Where friction grows, the speed is each bristle's own (`symbolic.slip`): one that the turning wheel still
loads does not slide yet, and one that is no longer driven creeps. Where it falls, that balance has more
than one solution, and inertia would choose; there the speed is the one at which the wheel drives the
bristle, |x - e| |psi_dot|.
"""

from dataclasses import dataclass, replace

import casadi as ca

from symbolic.bristles import BristleTraits
from symbolic.effects.base import Effect, Expression, Parameter, Values, with_limit
from symbolic.slip import REFERENCE_SPEED, REST_SPEED, RateLaw

LEAST_FACTOR = 0.05
"""The logarithm is not followed below this factor [1]."""


@dataclass(frozen=True, kw_only=True)
class RateFriction(Effect):
    """Limit times 1 + c ln(v / v_ref), v the sliding speed, not below v_0."""

    name: str = "rate_friction"
    summary: str = "friction changes with log sliding speed"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="1", neutral=0.0, start=0.02, lower=-0.3, upper=0.3, scale=0.05),
    )
    discrete: bool = True

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """The limit of each bristle follows its sliding speed."""
        c = values["c"]

        def factor(speed: Expression) -> Expression:
            regular = ca.sqrt(speed**2 + REST_SPEED**2)
            return ca.fmax(LEAST_FACTOR, 1 + ca.fmin(c, 0) * ca.log(regular / REFERENCE_SPEED))

        return replace(with_limit(traits, factor), law=RateLaw(c=ca.fmax(c, 0)))
