"""A car's front axle: the force on the rack is measured, as torque of the mean wheel.

    M_z = h(history of the angle, mu) + M_0 + gear D,    D = -(r/2 F_f + share |M_z|) z

D [N m] is the torque of the gear's dry friction as declared; the state `gear` is the level of it over
that, one number for both directions: what they differ by is part of the zero M_0. z is the gear's
presliding, Dahl's: from -1 it approaches 1 as 1 - 2 exp(-turn / presliding) [Dahl 1968], along an angle
that follows the measured one with play of its noise. So the gear turns over at once on a reversal, the
tyre over an angle of its own, which tells them apart. While z turns over, its presliding, known by
`PRESLIDING` only, makes D uncertain. No Stribeck effect: none was seen on a test rig [IDETC 2015].
"""

from dataclasses import dataclass
from math import hypot, sin
from typing import ClassVar

import casadi as ca

from observers.layout import Expression, Parts
from observers.measurement.measurement_model import AligningTorque, Measurement, Moments, select_states
from observers.measurement.torque_error import is_known
from symbolic import full_slide_arm
from symbolic.vehicle.contact_about_kingpin import contact_growth_at_full_lock
from symbolic.vehicle.mean_wheel import lever_and_contact_growth
from symbolic.vehicle.steering import jacking_torque, lock_angle
from symbolic.vehicle.vehicle import STD_PER_TOLERANCE, Vehicle

JACKING = 0.08
"""Standard deviation of the return torque as a share of it [1]: angles within 1 deg, wheel radius; that
of the load adds in quadrature."""
GEAR_STD = 0.8
"""Standard deviation of the gear's friction over its tolerance [1]: more than if it may be anywhere
within, so that bands hold on slippery ground, where it is as large as the tyres' torque, with all values
at an end of theirs at once; it is learnt, and this widens bands by little."""
SCALE_SHARE = 0.1
"""Share of another stiffness that is the torque's scale: its variance over that of both, of the usual
tolerances [1]."""
PRESLIDING = 0.5
"""Standard deviation of the logarithm of the presliding [1]."""
TURNING_OVER = 0.75
"""Largest derivative of z by the logarithm of the presliding, over (1 - z^2)^(1/2), nearly [1]."""
GROWTH = 0.5
"""Standard deviation of the torque's growth towards the locks as a share of it [1]: on split ground the
nose gives way, and the contacts turn about their middles."""
RESTING = 0.5
"""Standard deviation of z while the wheels rest [1]: before the first turn it may be anything, and later
the hands move the gear by less than an angle's noise."""
GEAR_WALK = 0.01
"""Random walk of the gear's friction as a share of the declared one [1/sqrt(s)]."""


@dataclass(frozen=True, kw_only=True)
class RackForce(AligningTorque):
    """The force on the rack is measured; states mu, the torque's zero and the gear's friction.

    Attributes:
        stiffness: k over its nominal value is a state [1]: suspension and tyre are known roughly.
        friction: torque of the gear's dry friction as declared, straight ahead [N m].
        load_share: share of the torque by which it grows [1].
        gear_spread: standard deviation of the gear's friction over the declared one [1].
        presliding: turn in which it turns over, from the middle [rad].
        jacking: standard deviation of the return torque over the sine of the angle [N m].
        error: standard deviation of the torque's error that lasts [N m].
        slack: play of the angle's noise, either way [rad].
        damping: standard deviation of the damping [N m s/rad].
        growth: standard deviation of the torque's growth over its share, over sin^2 of the angle [1].
        inverse_lever_growth: by which one over the lever grows with the square of the angle [1/rad^2].
    """

    stiffness: bool = True
    friction: float = 0.0
    load_share: float = 0.0
    gear_spread: float = 0.0
    presliding: float = 1e-3
    jacking: float = 0.0
    error: float = 0.0
    slack: float = 2e-4
    damping: float = 0.0
    growth: float = 0.0
    inverse_lever_growth: float = 0.0
    # Load and levers are known far better than the stiffness of tyre and suspension.
    gain_share: ClassVar[float] = SCALE_SHARE
    # Friction that turns over looks like noise.
    torque_state: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def of(cls, vehicle: Vehicle, *, brakes: bool | None = None, **chosen: bool) -> "RackForce":
        """That of a vehicle, its wheels held or not; `zero` and `stiffness` may be chosen."""
        held, lock = vehicle.brakes if brakes is None else brakes, lock_angle(vehicle)
        share = hypot(JACKING, STD_PER_TOLERANCE * vehicle.tolerances.load)
        return cls(
            friction=vehicle.steering_arm / 2 * vehicle.gear_friction,
            load_share=vehicle.gear_load_share,
            gear_spread=GEAR_STD * vehicle.tolerances.gear_friction,
            presliding=vehicle.presliding / vehicle.steering_arm,
            error=vehicle.steering_arm / 2 * vehicle.force_error,
            jacking=share * abs(float(jacking_torque(vehicle, lock))) / sin(lock),
            damping=STD_PER_TOLERANCE * vehicle.tolerances.damping * vehicle.damping,
            growth=GROWTH * abs(contact_growth_at_full_lock(vehicle, brakes=held).torque),
            inverse_lever_growth=lever_and_contact_growth(vehicle, brakes=held) / lock**2,
            **chosen,
        )

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return select_states(
            log_mu=True, M_0=self.zero, stiffness=self.stiffness, gear=self.friction > 0
        )

    def prior(self, tuning: Parts, first: Parts, slide_torque: Expression) -> dict[str, Moments]:
        """Mean and variance of every state."""
        return super().prior(tuning, first, slide_torque) | {"gear": (1, self.gear_spread**2)}

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """As where the aligning torque is measured, with the gear's presliding and its torque."""
        now, imputed = super().clean(sample, last)
        psi, before, slack = now["psi"], last["gear_angle"], self.slack
        angle = ca.fmax(psi - slack, ca.fmin(psi + slack, before))
        side = ca.if_else(angle >= before, 1, -1)
        left = ca.exp(-ca.fabs(angle - before) / self.presliding)
        slip = side - (side - last["slip"]) * left
        known = is_known(now["M_z"])
        torque = ca.if_else(known, ca.fabs(ca.if_else(known, now["M_z"], 0)), 0)
        level = self.friction / (1 + self.inverse_lever_growth * psi**2) + self.load_share * torque
        turning = TURNING_OVER * PRESLIDING * ca.sqrt(ca.fmax(0, 1 - slip**2))
        # What is wrong of the return torque is so all along the way.
        returned = self.jacking * ca.sin(psi)
        lasting = (self.growth * ca.sin(psi) ** 2 * torque) ** 2 + returned**2 + self.error**2
        drag = self.damping * (psi - last["psi"]) / now["dt"]
        resting = RESTING * ca.exp(-ca.fabs(angle - before) / slack)
        uncertain = ca.sqrt(level**2 * (turning**2 + resting**2) + drag**2 + lasting)
        gear = {"gear_angle": angle, "slip": slip, "dry": -level * slip, "dry_std": uncertain}
        return {**now, **gear}, imputed

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """All states are random walks."""
        after, variance = super().motion(x, M_z, last, now, rig, tuning)
        gear = x.get("gear", 0), now["dt"] * GEAR_WALK**2
        return {**after, "gear": gear[0]}, {**variance, "gear": gear[1]}

    def measurement(
        self, x: Parts, M_z: Expression, now: Parts, rig: Parts, tuning: Parts
    ) -> Measurement:
        """The torque of the mean wheel with the gear's and the zero of its channel [N m]."""
        expected = M_z + x.get("M_0", 0) + x.get("gear", 0) * now["dry"]
        return self._torque_measurement(expected, x, now, rig, tuning, now["dry_std"])

    def _unit_slide_torque(self, now: Parts, rig: Parts) -> Expression:
        """Torque of full slide at mu = 1 [N m]."""
        return now["F_N"] * full_slide_arm(rig["a"], rig["e"])
