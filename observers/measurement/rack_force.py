"""A car's front axle: the force on the rack is measured, as torque of the wheel that stands for both.

    M_z = h(history of the angle, mu) + M_0 + gear D,    D = -(r/2 F_f + share |M_z|) z

D [N m] is the torque of the gear's dry friction as declared; the state `gear` is the level of it over
that, one number for both directions: what they differ by is part of the zero M_0. z is the gear's
presliding, an elastoplastic stop: it goes from -1 to 1 within twice the presliding and stays there. So
the gear turns over at once on a reversal, the tyre over an angle of its own, which tells them apart.
No Stribeck effect: none was seen on a test rig [IDETC 2015].
"""

from dataclasses import dataclass

import casadi as ca

from observers.layout import Expression, Parts
from observers.measurement.measurement_model import (
    LONGEST,
    AligningTorque,
    Measurement,
    Moments,
    random_walk,
    select_states,
)
from observers.measurement.torque_error import (
    huber_scale,
    independent_share,
    is_known,
    model_error_variance,
    white_variance,
)
from observers.tuning import REFERENCE_STEP
from symbolic import full_slide_arm
from symbolic.parameters import EVEN
from symbolic.vehicle.steering import lever_growth, lock_angle
from symbolic.vehicle.vehicle import Vehicle

GEAR_WALK = 0.01
"""Random walk of the gear's friction as a share of the declared one [1/sqrt(s)]."""


@dataclass(frozen=True, kw_only=True)
class RackForce(AligningTorque):
    """The force on the rack is measured; states mu, the torque's zero and the gear's friction.

    Attributes:
        friction: torque of the gear's dry friction as declared, straight ahead [N m].
        load_share: share of the torque by which it grows [1].
        spread: standard deviation of the gear's friction over the declared one [1].
        presliding: turn in which it turns over, from the middle [rad].
        lever_growth: by which one over the lever grows with the square of the angle [1/rad^2].
    """

    friction: float = 0.0
    load_share: float = 0.0
    spread: float = 0.0
    presliding: float = 1e-3
    lever_growth: float = 0.0

    @classmethod
    def of(cls, vehicle: Vehicle, **chosen: bool) -> "RackForce":
        """That of a vehicle; `zero` and `stiffness` may be chosen."""
        return cls(
            friction=vehicle.steering_arm / 2 * vehicle.gear_friction,
            load_share=vehicle.gear_load_share,
            spread=EVEN * vehicle.tolerances.gear_friction,
            presliding=vehicle.presliding / vehicle.steering_arm,
            lever_growth=lever_growth(vehicle) / lock_angle(vehicle) ** 2,
            **chosen,
        )

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return select_states(log_mu=True, M_0=self.zero, stiffness=self.stiffness, gear=self.has_gear)

    @property
    def has_gear(self) -> bool:
        """Whether there is dry friction, whose level is a state."""
        return self.friction > 0

    @property
    def gear_spread(self) -> float:
        """Standard deviation of the gear's friction over the declared one [1]."""
        return self.spread

    def prior(self, tuning: Parts, first: Parts, slide: Expression) -> dict[str, Moments]:
        """Mean and variance of every state."""
        return super().prior(tuning, first, slide) | {"gear": (1, self.spread**2)}

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """As where the aligning torque is measured, with the gear's presliding and its torque."""
        now, imputed = super().clean(sample, last)
        turn = (now["psi"] - last["psi"]) / self.presliding
        slip = ca.fmax(-1, ca.fmin(1, last["slip"] + turn))
        known = is_known(now["M_z"])
        torque = ca.if_else(known, ca.fabs(ca.if_else(known, now["M_z"], 0)), 0)
        level = self.friction / (1 + self.lever_growth * now["psi"] ** 2) + self.load_share * torque
        return now | {"slip": slip, "dry": -level * slip}, imputed

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """All states are random walks."""
        del M_z, last
        after, variance = random_walk(x, _slide(now, rig), now["dt"], tuning)
        return after | {"gear": x.get("gear", 0)}, variance | {"gear": now["dt"] * GEAR_WALK**2}

    def measurement(
        self, x: Parts, M_z: Expression, now: Parts, rig: Parts, tuning: Parts
    ) -> Measurement:
        """The torque of the mean wheel with the gear's and the zero of its channel [N m]."""
        slide, dt = _slide(now, rig), ca.fmin(now["dt"], LONGEST)
        independent = independent_share(now["travel"], tuning["error_travel"])
        noise, error = white_variance(rig, tuning, slide), model_error_variance(x, tuning)
        variance = error * dt + REFERENCE_STEP * noise * independent
        return Measurement(
            expected=M_z + x.get("M_0", 0) + x.get("gear", 0) * now["dry"],
            measured=now["M_z"],
            precision=dt * independent / (variance * slide**2),
            huber_scale=huber_scale(x, tuning, noise) * slide**2,
            independent=independent,
        )


def _slide(now: Parts, rig: Parts) -> Expression:
    """Torque of full slide at mu = 1 [N m]."""
    return now["F_N"] * full_slide_arm(rig["a"], rig["e"])
