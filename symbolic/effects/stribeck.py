"""Static friction above kinetic, falling exponentially with sliding speed.

Reference: the exponential form reviewed in Armstrong-Helouvry, Dupont, Canudas de Wit, A survey of
models, analysis tools and compensation methods for the control of machines with friction,
Automatica 30 (1994) 1083.
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Parameter, ResidualSignature, Values, with_limit


@dataclass(frozen=True, kw_only=True)
class Stribeck(Effect):
    """Limit times 1 + (ratio - 1) exp(-v / v_s), v the local sliding speed.

    The ratio is one or more: friction that rises with speed is what `rate_friction` is for.
    """

    name: str = "stribeck"
    summary: str = "static friction is above kinetic"
    family = "friction over speed"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="ratio", unit="1", neutral=1.0, start=1.1, lower=1.0, upper=3.0, scale=0.2,
            of="friction",
        ),
        Parameter(
            name="v_s", unit="m/s", neutral=None, start=0.003, lower=0.0002, upper=0.03, scale=0.003,
            of="friction",
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the direction of friction times log speed", sign=-1),
        ResidualSignature("the yaw rate", sign=-1),
        ResidualSignature("the direction of turning", sign=-1),
        ResidualSignature("the signed angle since the last reversal", sign=-1),
        ResidualSignature("the signed time since the last reversal", sign=-1),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """The limit of each bristle follows its own sliding speed, |x - e| |psi_dot|."""
        return with_limit(
            traits, lambda speed: 1 + (values["ratio"] - 1) * ca.exp(-speed / values["v_s"])
        )
