"""Viscous torque in what the load plate measures.

The linear viscous term; on the standing tyre: Pacejka, Tire and Vehicle Dynamics (2012).
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class ContactDamping(Effect):
    """Adds -c psi_dot to the torque."""

    name: str = "contact_damping"
    summary: str = "a torque proportional to the yaw rate"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m s/rad", neutral=0.0, start=0.1, lower=0.0, upper=20.0, scale=1.0),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the yaw rate", sign=1),
        ResidualSignature("the rate of the torque", sign=-1, rank=2),
    )

    torque_by_ground: bool = True

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Viscous torque, against the motion for c > 0 [N m]."""
        return -values["c"] * signals.psi_dot
