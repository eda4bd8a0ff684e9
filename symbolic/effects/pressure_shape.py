"""Pressure flatter or sharper than the parabola.

Reference: after the idea of Guo, Ren, A unified semi-empirical tire model with higher accuracy and less
parameters, SAE 1999-01-0785 (pressure distributions of general shape).
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values, with_shape


@dataclass(frozen=True, kw_only=True)
class PressureShape(Effect):
    """Pressure ~ 1 - |x / a|^exponent at the same total load; the parabola has exponent 2."""

    name: str = "pressure_shape"
    summary: str = "the pressure is flatter or sharper than a parabola"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="exponent", unit="1", neutral=2.0, start=2.3, lower=0.6, upper=12.0, scale=1.0),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the angle", sign=-1, rank=1),
        ResidualSignature("the rate of the torque", sign=1, rank=2),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Replace the parabola by 1 - |u|^n, both normalised to the same load."""
        n = values["exponent"]

        def factor(u: Expression) -> Expression:
            flat = (n + 1) / (2 * n) * (1 - ca.fabs(u) ** n)
            return flat / (0.75 * (1 - u**2))

        return with_shape(traits, factor)
