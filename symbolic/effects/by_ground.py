"""Parameters that belong to a ground and not to the tyre alone.

The law of friction is of the pair of tyre and ground, the carcass is of the tyre: Grosch, The relation
between the friction and visco-elastic properties of rubber, Proc. R. Soc. A 274 (1963) 21, measures one
rubber on several tracks. The bristles' stiffness holds that of the contact of asperities in series.
"""

from dataclasses import dataclass
from typing import Literal

from symbolic.effects.base import Effect, Parameter, Scope


@dataclass(frozen=True, kw_only=True)
class ByGround(Effect):
    """Parameters that would belong to the tyre have a value for each ground.

    It has none of its own, and changes nothing while every ground has the same values.
    """

    parameters: tuple[Parameter, ...] = ()
    of: Literal["friction", "stiffness"]  # Which parameters, see `Parameter.of`.

    def scope_of(self, parameter: Parameter) -> Scope:
        """The ground, for parameters of this kind that belong to the tyre otherwise."""
        moved = parameter.of == self.of and parameter.scope == "tyre" and not parameter.fixed
        return "ground" if moved else parameter.scope


GROUND_SCOPES: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        ByGround(
            name="friction_by_ground", summary="every ground has a law of friction of its own",
            of="friction",
        ),
        ByGround(
            name="stiffness_by_ground", summary="every ground has a stiffness of its own", of="stiffness"
        ),
    )
}  # fmt: skip
"""Effects without parameters, by name."""
