"""A patch of finite width, whose bristles also deform along its length.

A bristle at (x, y) moves along its circle about the kingpin, always in the same direction, so the
two-dimensional stop is a scalar one with the lever arm sqrt((x - e)^2 + y^2).

Reference: Pacejka, Tire and Vehicle Dynamics, 3rd ed. (2012), on the brush model with turn slip.
"""

from dataclasses import dataclass, replace

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Parameter, ResidualSignature, Values


@dataclass(frozen=True, kw_only=True)
class PatchWidth(Effect):
    """Bristles spread over the width |y| <= half_width, with the load uniform in y."""

    name: str = "patch_width"
    summary: str = "the patch has a width"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="half_width", unit="m", neutral=0.0, start=0.015, lower=0.0, upper=0.15, scale=0.02
        ),
    )
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the angle", sign=-1, rank=3),)

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Spread the bristles over the half-width [m]."""
        return replace(traits, half_width=values["half_width"])
