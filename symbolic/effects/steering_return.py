"""Elastic or gravity return torque of the steering.

Reference: Pacejka, Tire and Vehicle Dynamics, 3rd ed. (2012).
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class SteeringReturn(Effect):
    """Adds -stiffness psi to the torque."""

    name: str = "steering_return"
    summary: str = "a torque proportional to the angle"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="stiffness", unit="N m/rad", neutral=0.0, start=0.1, lower=-100.0, upper=100.0,
            scale=1.0,
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the angle", sign=1),)

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Return torque towards psi = 0 for stiffness > 0 [N m]."""
        return -values["stiffness"] * signals.psi
