"""Electric power steering: steering torque and angle measured; see `observers.measurement_model`."""

from dataclasses import dataclass

import casadi as ca

from observers.measurement_model import (
    Expression,
    Measurement,
    Parts,
    chosen,
    clean_load,
    is_known,
    walk,
    walking_prior,
)
from observers.protocol import Sample
from observers.tuning import REFERENCE_STEP, Tuning
from symbolic import InvalidInputError, Rig, full_slide_torque

STALE = 0.1
"""Time after which a steering torque that was held may be off by all of full slide [s]."""
USUAL_STEP = 0.02
"""Longer steps count as a steering torque that was held for the rest [s]; a wheel swings in 0.2 s."""


@dataclass(frozen=True, kw_only=True)
class SteeringTorque:
    """The steering torque is measured, and the angle; states psi, psi_dot, mu and as chosen.

    Samples should come every 10 ms or faster: the wheel swings on the tyre at some 5 Hz, and steps of
    60 ms and more are beyond what the integration bears. `Ekf.iterations` has no effect here, as the
    measurement is linear. A slope of the torque by the rate (contact damping) is left out of the
    derivatives; it belongs into b_t.

    Attributes:
        zero: the zero M_0 of the torque channel is a state [N m]; it acts as a torque on the wheel.
        stiffness: k over its nominal value is a state [1].
    """

    zero: bool = False
    stiffness: bool = False

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return chosen(log_mu=True, psi=True, psi_dot=True, M_0=self.zero, stiffness=self.stiffness)

    @property
    def turns(self) -> bool:
        """The patch follows the estimated angle."""
        return True

    def check(self, rig: Rig) -> None:
        """The equation of motion needs J_A and b_t."""
        missing = [name for name in ("J_A", "b_t") if getattr(rig, name) is None]
        if missing:
            raise InvalidInputError(
                f"the rig lacks {' and '.join(missing)}: where the steering torque is measured, J_A"
                " [kg m^2] and b_t [N m s/rad] must be known"
            )

    def prior(self, tuning: Tuning, first: Sample, slide: float) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation of every state: the wheel at rest where it is first seen."""
        return walking_prior(tuning, self.states, slide) | {
            "psi": (first.psi, tuning.psi_noise),
            "psi_dot": (0.0, tuning.psi_dot_std),
        }

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """Without a steering torque the last one goes on; the longer, the less it is worth."""
        F_N, load_held = clean_load(sample, last)
        lost = ca.logic_not(is_known(sample["M"]))
        made = {
            "psi": sample["psi"],
            "psi_dot": 0,
            "F_N": F_N,
            "dt": sample["dt"],
            "M_z": 0,
            "M": ca.if_else(lost, last["M"], sample["M"]),
            "lost": ca.if_else(lost, last["lost"] + sample["dt"], 0),
        }
        return made, ca.logic_or(load_held, lost)

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, beliefs: Parts
    ) -> tuple[Parts, Parts]:
        """One leapfrog step: a kick at the last sample, a drift to this one.

        The torque noise acts as a white torque, so that what it does to the rate grows with the time.
        """
        dt, slide = now["dt"], full_slide_torque(now["F_N"], rig["a"])
        after, variance = walk(x, slide, dt, beliefs)
        # An empty place of a window has dt = 0; neither to it nor from it does anything move.
        kick = ca.if_else(dt > 0, (last["dt"] + dt) / 2, 0)
        damping = kick * rig["b_t"] / (2 * rig["J_A"])
        torque = M_z + last["M"] + x.get("M_0", 0)
        rate = ((1 - damping) * x["psi_dot"] + kick * torque / rig["J_A"]) / (1 + damping)
        after |= {"psi": x["psi"] + dt * rate, "psi_dot": rate}
        white = (beliefs["noise"] * slide) ** 2 * REFERENCE_STEP * kick
        # A held torque errs to one side for about as long as it takes to grow stale; so does one between
        # samples that are far apart, and there the leapfrog itself is at its end.
        age = last["lost"] + ca.fmax(0, dt - USUAL_STEP)
        stale = (ca.fmin(1, age / STALE) * slide) ** 2 * STALE * kick
        # Disturbances hit the rate after the drift, so that the next step carries them to the angle.
        return after, variance | {"psi": 0, "psi_dot": (white + stale) / rig["J_A"] ** 2}

    def reading(self, x: Parts, M_z: Expression, now: Parts, rig: Parts, beliefs: Parts) -> Measurement:
        """The angle [rad]."""
        del M_z, rig
        return Measurement(
            expected=x["psi"],
            measured=now["psi"],
            precision=ca.if_else(now["dt"] > 0, 1 / beliefs["psi_noise"] ** 2, 0),
            ordinary=ca.inf,
        )
