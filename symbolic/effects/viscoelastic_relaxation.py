"""A Maxwell branch beside the bristle springs: stress that fades while the wheel rests.

Reference: Ferry, Viscoelastic Properties of Polymers, 3rd ed. (1980): the standard linear solid.
"""

from dataclasses import dataclass, replace

from symbolic.bristle_patch import BristleTraits, Relaxation
from symbolic.effects.base import Effect, Parameter, ResidualSignature, Values


@dataclass(frozen=True, kw_only=True)
class ViscoelasticRelaxation(Effect):
    """Each bristle spring has a parallel branch of stiffness gain k and relaxation time `time`."""

    name: str = "viscoelastic_relaxation"
    summary: str = "bristle stress relaxes with time"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="gain", unit="1", neutral=0.0, start=0.3, lower=0.0, upper=10.0, scale=0.3),
        Parameter(name="time", unit="s", neutral=None, start=0.5, lower=0.02, upper=20.0, scale=0.5),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the rate of the torque", sign=-1),
        ResidualSignature("the angle", sign=1, rank=1),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Add the branch to every bristle."""
        return replace(traits, relaxation=Relaxation(gain=values["gain"], time=values["time"]))
