"""Pressure centre in front of or behind the middle of the patch.

Reference: Pacejka, Tire and Vehicle Dynamics, 3rd ed. (2012), on the brush model.
"""

from dataclasses import dataclass

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Parameter, ResidualSignature, Values, with_shape


@dataclass(frozen=True, kw_only=True)
class PressureSkew(Effect):
    """Pressure times 1 + skew x / a; the load stays."""

    name: str = "pressure_skew"
    summary: str = "the pressure centre is off the middle"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="skew", unit="1", neutral=0.0, start=0.1, lower=-0.95, upper=0.95, scale=0.2),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the angle", sign=-1, rank=2),
        ResidualSignature("the angle", sign=1, rank=3),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Tilt the pressure."""
        return with_shape(traits, lambda u: 1 + values["skew"] * u)
