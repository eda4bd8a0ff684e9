"""Friction that grows with the logarithm of each bristle's own sliding speed, so that it creeps.

`rate_friction` takes the speed |x - e| |psi_dot| at which the wheel drives a bristle; here it is the
speed at which the bristle slides (`symbolic.bristle_slip`). One that the turning wheel still
loads does not slide yet, and one that is no longer driven creeps on, ever slower, in place of losing
stress at once.

Reference: Rice, Lapusta, Ranjith, Rate and state dependent friction and the stability of sliding between
elastically deformable solids, J. Mech. Phys. Solids 49 (2001) 1865: the direct effect, linear in log
speed (cut off at v_0 here, an arcsinh there); for rubber Grosch, Proc. R. Soc. A 274 (1963) 21.
"""

from dataclasses import dataclass, replace

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Parameter, ResidualSignature, Values


@dataclass(frozen=True, kw_only=True)
class FrictionalCreep(Effect):
    """Limit times 1 + c ln(v / v_ref), v each bristle's own sliding speed, not below v_0."""

    name: str = "frictional_creep"
    summary: str = (
        "friction grows by the same amount each time bristles slide ten times as fast, so that they"
        " creep; the model's mu is friction at 1 mm/s"
    )
    family = "friction over speed"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="c", unit="1", neutral=0.0, start=0.02, lower=0.0, upper=0.3, scale=0.05, of="friction"
        ),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the direction of friction times log speed", sign=1, rank=1),
        ResidualSignature("the signed angle since the last reversal", sign=1, rank=1),
        ResidualSignature("the signed time since the last reversal", sign=1, rank=1),
        ResidualSignature("the yaw rate", sign=1, rank=2),
        ResidualSignature("the rate of the torque", sign=-1, rank=1),
        ResidualSignature("the angle", sign=1, rank=2),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Every bristle slips as far as its own speed lets friction bear."""
        return replace(traits, creep=values["c"])
