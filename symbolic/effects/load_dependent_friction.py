"""Friction that falls with load, as that of rubber does.

Reference: Schallamach, The load dependence of rubber friction, Proc. Phys. Soc. B 65 (1952) 657.
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values

REFERENCE_LOAD = 400.0
"""Load at which the factor is one [N]."""


@dataclass(frozen=True, kw_only=True)
class LoadDependentFriction(Effect):
    """Limit times (F_N / F_ref)^(-n)."""

    name: str = "load_dependent_friction"
    summary: str = "friction depends on the load"
    family = "friction over load"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="n", unit="1", neutral=0.0, start=0.1, lower=-3.0, upper=3.0, scale=0.3, of="friction"
        ),
    )
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the torque times the load"),)

    def friction(self, signals: Signals, memory: Expression, values: Values) -> Expression:
        """Factor on the friction limit, one at the reference load [1]."""
        return (signals.F_N / REFERENCE_LOAD) ** (-values["n"])
