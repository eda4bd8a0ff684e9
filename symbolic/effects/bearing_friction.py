"""Dry friction in the kingpin or in the mount of the sensor.

Reference: Armstrong-Helouvry, Control of Machines with Friction (1991); the smooth step is ours.
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values

TURNING = 0.01
"""Yaw rate above which the wheel counts as turning [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class BearingFriction(Effect):
    """Adds -M_c tanh(psi_dot / omega_0) to the torque."""

    name: str = "bearing_friction"
    summary: str = "dry friction outside the patch"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="M_c", unit="N m", neutral=0.0, start=0.1, lower=0.0, upper=20.0, scale=0.5),
    )
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the direction of turning", sign=1),)

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Dry friction torque, against the motion for M_c > 0 [N m]."""
        return -values["M_c"] * ca.tanh(signals.psi_dot / TURNING)
