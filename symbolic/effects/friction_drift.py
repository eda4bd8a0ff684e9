"""Friction that changes with the angle turned, counted both ways: it beds in, or wears.

How much belongs to the ground: rubber that beds in on steel need not do so on emery.

An empirical form; on rubber friction in general: Persson, Sliding Friction, 2nd ed. (2000).
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class FrictionDrift(Effect):
    """Limit times 1 + gain (1 - exp(-s / scale)), s the angle turned so far, counted both ways."""

    name: str = "friction_drift"
    summary: str = "friction changes with the way turned"
    family = "friction over time"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="gain", unit="1", neutral=0.0, start=0.1, lower=-0.9, upper=3.0, scale=0.1,
            scope="ground",
        ),
        Parameter(name="scale", unit="rad", neutral=None, start=0.5, lower=0.05, upper=20.0, scale=0.5),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the torque times the time"),
        ResidualSignature("the signed angle since the last reversal", sign=1, rank=3),
        ResidualSignature("the signed time since the last reversal", sign=1, rank=3),
    )
    memory: int = 2

    def initial(self, signals: Signals) -> Expression:
        """The last angle [rad] and the travel so far, counted both ways [rad]."""
        return ca.vertcat(signals.psi, 0)

    def transform_inputs(
        self, signals: Signals, memory: Expression, values: Values
    ) -> tuple[Signals, Expression]:
        """Add up the travel."""
        travel = memory[1] + ca.fabs(signals.psi - memory[0])
        return signals, ca.vertcat(signals.psi, travel)

    def friction(self, signals: Signals, memory: Expression, values: Values) -> Expression:
        """Factor on the friction limit [1]."""
        return 1 + values["gain"] * (1 - ca.exp(-memory[1] / values["scale"]))
