"""Electric power steering: steering torque and angle are measured.

    J_A psi'' = -b_t psi' + M_z + M + M_0,

[Györök 2022], (2.13), with the sign of M_z that (2.3) there needs. The response of the wheel to a known
torque determines M_z. The motion is integrated by the Störmer-Verlet leapfrog, damping implicit: psi' is
the rate halfway between two samples, so that M_z is needed at samples only.

Source of the leapfrog: Verlet, Phys. Rev. 159 (1967) 98.
"""

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca

from observers.layout import Expression, Parts, named
from observers.measurement.measurement_model import (
    CLEAN,
    GAIN_SHARE,
    RIG,
    Measurement,
    Moments,
    impute_load,
    predict_random_walk,
    random_walk_prior,
    select_states,
)
from observers.measurement.torque_error import (
    declared_sensor_variance,
    independent_sample_share,
    is_known,
    model_error_variance,
    relative_sensor_noise_variance,
)
from observers.tuning import REFERENCE_STEP, TUNING_FIELDS
from symbolic import InvalidInputError, Model, Rig, full_slide_torque
from symbolic.rig_and_tyre import EVEN

STALE = 0.1
"""Age at which the error of an imputed steering torque reaches full slide [s]."""
MIN_YAW_RATE = 0.1
"""Least divisor in the correlation time of the model's error, `error_travel` / yaw rate [rad/s]."""
USUAL_STEP = 0.02
"""The part of a step beyond this counts as age of the steering torque [s]; a wheel swings in 0.2 s."""
BLOCK = ("time", "psi_sum", "M_sum", "psi_a", "time_a", "psi_b", "M_b", "time_b", "blocks")
"""State of `SteeringTorque.observed_torque`: sums over the present block of samples, then means of the
last two, their times and number."""
DAMPING_STD = 0.2 * EVEN
"""Standard deviation of b_t over its value, which may be off by 20 % [1]."""
BLOCK_TIME = 0.0399
"""Least length of a block of samples [s]: the angle's second difference needs the time."""
MIN_TIME_DIVISOR = 1e-9
"""Least divisor that is a time [s]."""


def damping_variance(rig: Parts, rate: Expression) -> Expression:
    """Variance of the torque of the damping at a yaw rate [rad/s], as far as b_t is known [N^2 m^2]."""
    return (DAMPING_STD * rig["b_t"] * rate) ** 2


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

    zero: bool = True
    stiffness: bool = False
    # The rate is estimated.
    channels: ClassVar[tuple[str, ...]] = ("psi", "F_N", "M")
    # The measured angle is a state.
    is_linear: ClassVar[bool] = True
    # The wheel's inertia takes part of the torque.
    scaled: ClassVar[str] = ""
    torque_state: ClassVar[tuple[str, ...]] = BLOCK
    gear_spread: ClassVar[float] = 0.0
    gain_share: ClassVar[float] = GAIN_SHARE

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return select_states(
            log_mu=True, psi=True, psi_dot=True, M_0=self.zero, stiffness=self.stiffness
        )

    def observed_torque(
        self, before: Parts, sample: Parts, rig: Expression, tuning: Expression
    ) -> tuple[Parts, Expression, Expression, Expression]:
        """M_z = J_A psi'' + b_t psi' - M of the middle one of three blocks of samples."""
        values, noise = named(RIG, rig), named(TUNING_FIELDS, tuning)["psi_noise"]
        known = ca.logic_and(is_known(sample["psi"]), is_known(sample["M"]))
        known = ca.logic_and(known, sample["dt"] <= 1.05 * USUAL_STEP)
        sums = {
            name: ca.if_else(known, before[name] + add * sample["dt"], 0)
            for name, add in (("time", 1), ("psi_sum", sample["psi"]), ("M_sum", sample["M"]))
        }
        closes = sums["time"] > BLOCK_TIME
        span = ca.fmax(sums["time"], MIN_TIME_DIVISOR)
        psi, M = sums["psi_sum"] / span, sums["M_sum"] / span
        first = ca.fmax(before["time_a"] + before["time_b"], MIN_TIME_DIVISOR) / 2
        second = ca.fmax(before["time_b"] + span, MIN_TIME_DIVISOR) / 2
        acceleration = (psi - before["psi_b"]) / second - (before["psi_b"] - before["psi_a"]) / first
        acceleration = 2 * acceleration / (first + second)
        rate = (psi - before["psi_a"]) / (first + second)
        M_z = values["J_A"] * acceleration + values["b_t"] * rate - before["M_b"]
        ready = ca.logic_and(closes, before["blocks"] >= 2)
        variance = 6 * (values["J_A"] * noise / (first * second)) ** 2
        variance += declared_sensor_variance(values) * ca.fmin(1, sample["dt"] / span)
        variance += damping_variance(values, rate)
        moved = {
            "psi_a": before["psi_b"], "time_a": before["time_b"], "psi_b": psi, "M_b": M, "time_b": span,
            "blocks": before["blocks"] + 1,
        }  # fmt: skip
        after = {name: ca.if_else(closes, 0, total) for name, total in sums.items()}
        after |= {
            name: ca.if_else(known, ca.if_else(closes, new, before[name]), 0)
            for name, new in moved.items()
        }
        # Without a torque the path goes on: a turn back that nobody saw would pass for less friction.
        unseen = ca.if_else(is_known(sample["M"]), float("nan"), sample["psi"])
        psi = ca.if_else(ready, before["psi_b"], unseen)
        M_z = ca.if_else(ready, M_z, float("nan"))
        return after, psi, M_z, ca.if_else(ready, variance, 0)

    def check(self, rig: Rig, model: Model) -> None:
        """The equation of motion needs J_A and b_t; no effect may sit in the sensor of M_z."""
        missing = [name for name in ("J_A", "b_t") if getattr(rig, name) is None]
        if missing:
            raise InvalidInputError(
                f"the rig lacks {' and '.join(missing)}: where the steering torque is measured, J_A"
                " [kg m^2] and b_t [N m s/rad] must be known; of a slow wheel, --map M_z=-M serves a"
                " torque sensor between steering and wheel"
            )
        sensors = [effect.name for effect in model.effects if effect.sensor]
        if sensors:
            raise InvalidInputError(
                f"the model's {sensors[0]} belongs to the channel of the aligning torque, which is not"
                " measured here; leave the effect out"
            )

    def prior(self, tuning: Parts, first: Parts, slide_torque: Expression) -> dict[str, Moments]:
        """Mean and variance of every state: the wheel at rest at its first angle."""
        return random_walk_prior(tuning, self.states, slide_torque) | {
            "psi": (first["psi"], tuning["psi_noise"] ** 2),
            "psi_dot": (0, tuning["psi_dot_std"] ** 2),
        }

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """Impute a missing steering torque by the last one; its error grows with its age."""
        F_N, load_imputed, _ = impute_load(sample, last)
        missing = ca.logic_not(is_known(sample["M"]))
        now = dict.fromkeys(CLEAN, 0) | {
            "psi": sample["psi"], "F_N": F_N, "F_N_first": last["F_N_first"], "dt": sample["dt"],
            "interval": sample["dt"],
            "M": ca.if_else(missing, last["M"], sample["M"]),
            "M_age": ca.if_else(missing, last["M_age"] + sample["dt"], 0),
        }  # fmt: skip
        return now, ca.logic_or(load_imputed, missing)

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """One leapfrog step: a kick at the last sample, a drift to this one.

        The torque noise acts as a white torque, so that what it does to the rate grows with the time. So
        does the model's error, as strong as it is over the time in which it is one independent sample.
        """
        dt, slide_torque = now["dt"], full_slide_torque(now["F_N"], rig["a"])
        after, variance = predict_random_walk(x, slide_torque, dt, tuning)
        # An empty place of a window has dt = 0: there is no motion to it or from it.
        kick = ca.if_else(dt > 0, (last["dt"] + dt) / 2, 0)
        damping = kick * rig["b_t"] / (2 * rig["J_A"])
        torque = M_z + last["M"] + x.get("M_0", 0)
        rate = ((1 - damping) * x["psi_dot"] + kick * torque / rig["J_A"]) / (1 + damping)
        after |= {"psi": x["psi"] + dt * rate, "psi_dot": rate}
        relative = damping_variance(rig, x["psi_dot"]) / slide_torque**2
        lasting = tuning["error_travel"] / ca.fmax(MIN_YAW_RATE, ca.fabs(x["psi_dot"]))
        density = (
            relative_sensor_noise_variance(rig, tuning, slide_torque) * REFERENCE_STEP
            + (model_error_variance(x, tuning) + relative) * lasting
        )
        white = density * slide_torque**2 * kick
        # The error of an imputed torque is correlated over about `STALE`; so is that of a torque between
        # samples that are far apart, where the leapfrog is inaccurate too.
        age = last["M_age"] + ca.fmax(0, dt - USUAL_STEP)
        stale = (ca.fmin(1, age / STALE) * slide_torque) ** 2 * STALE * kick
        # Disturbances hit the rate after the drift, so that the next step carries them to the angle.
        return after, variance | {"psi": 0, "psi_dot": (white + stale) / rig["J_A"] ** 2}

    def measurement(
        self, x: Parts, M_z: Expression, now: Parts, rig: Parts, tuning: Parts
    ) -> Measurement:
        """The angle [rad]."""
        del M_z, rig
        travel = now["dt"] * ca.fmax(MIN_YAW_RATE, ca.fabs(x["psi_dot"]))
        return Measurement(
            expected=x["psi"],
            measured=now["psi"],
            precision=ca.if_else(now["dt"] > 0, 1 / tuning["psi_noise"] ** 2, 0),
            huber_scale=ca.inf,
            independent=independent_sample_share(travel, tuning["error_travel"]),
        )
