"""Friction that differs by direction of turning.

An empirical form; on rubber friction in general: Persson, Sliding Friction, 2nd ed. (2000).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values

ASYMMETRY_RATIO = "asymmetric_friction.ratio"
"""Its ratio among the values of a model."""


@dataclass(frozen=True, kw_only=True)
class AsymmetricFriction(Effect):
    """Limit times ratio while the wheel turns with psi_dot > 0."""

    name: str = "asymmetric_friction"
    summary: str = "friction differs by direction of turning"
    family = "friction over direction"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="ratio", unit="1", neutral=1.0, start=1.05, lower=0.3, upper=3.0, scale=0.2),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the magnitude of the torque"),
        ResidualSignature("the signed angle since the last reversal", sign=1, rank=2),
        ResidualSignature("the signed time since the last reversal", sign=1, rank=2),
    )

    def friction(self, signals: Signals, memory: Expression, values: Values) -> Expression:
        """Factor on the friction limit [1]."""
        return ca.if_else(signals.psi_dot > 0, values["ratio"], 1)


def weaker_share_below_mean(values: Mapping[str, float]) -> float:
    """Share of the mean of both directions that the weaker one holds less [1], by values of a model.

    0 where they are alike, as without this effect.
    """
    ratio = values.get(ASYMMETRY_RATIO, 1.0)
    return abs(1 - ratio) / (1 + ratio)
