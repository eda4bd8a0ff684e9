"""Measurement models: states, motion, and measurement, and that of the aligning torque as on the rig.

The friction state is ln mu. Before full slide the torque bounds mu from below alone; the distribution of
ln mu is far less skewed than that of mu, and mu stays positive.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import casadi as ca

from observers.layout import Expression, Parts, named
from observers.measurement.torque_error import (
    NOISE,
    SENSOR,
    declared_sensor_variance,
    huber_scale_squared,
    independent_sample_share,
    is_known,
    model_error_variance,
    relative_sensor_noise_variance,
    update_sensor_noise_estimate,
)
from observers.protocol import SAMPLE
from observers.tuning import REFERENCE_STEP, STATES, TUNING_FIELDS
from symbolic import Model, Rig, full_slide_torque

Moments = tuple[Expression, Expression]
RIG = ("a", "e", "J_A", "b_t", "slide_rate", "noise", "dry_friction", "zero_std")
"""Order of the rig's numbers; one that is unknown is NaN."""
MAX_WEIGHTED_STEP = 0.05
"""Longest time step up to which the weight of a sample grows [s]."""
GAIN_SHARE = 0.5
"""Share of the stiffness that may be an error of the torque's scale, where nothing else is known [1]."""
MIN_FIRST_LOAD = 1e-3
"""Least load of a first sample [N]."""
MIN_LOAD_SHARE = 0.05
"""Share of the first load below which a load is missing [1]: a torque weighs with 1 / F_N^2."""
CLEAN = (*SAMPLE, "M_age", "F_N_first", "interval", "travel", "gear_angle", "slip", "dry", "dry_std")
"""Order of a cleaned sample: last valid values in place of missing ones; time since M was valid [s];
load of the first sample [N]; time that a torque stands for, since the one before, at most
`REFERENCE_STEP` if that is longer than dt [s]; turn since the last torque without its sign [rad];
angle that a steering gear has followed [rad], its presliding, -1 to 1, and the torque of its declared
dry friction with the standard deviation that presliding leaves to it [N m]."""
MAX_ZERO_DEVIATIONS = 3.0
"""Limit of the torque's zero in its standard deviations before the first sample [1]."""
ROWS = (*CLEAN, "accepted", "jump")
"""Rows of a window's samples: a cleaned sample, whether it is accepted, and what a change of the
ground adds to the variance of ln mu before it."""


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """The measurement of one sample."""

    expected: Expression  # Value that the states predict.
    measured: Expression  # Value of the sensor, NaN where it is missing.
    # Inverse variance of the white measurement error; 0 in an empty place of a window.
    precision: Expression
    huber_scale: Expression  # Square of the error up to which Huber's loss is quadratic.
    # Share of an independent sample that it is worth [1], less than 1 where the model's error lasts.
    independent: Expression = 1


class MeasurementModel(Hashable, Protocol):
    """States, motion and measurement of an observer; all methods but `check` take casadi expressions."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states in the order of `STATES`; the patch follows the angle where it is one."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Fields of `Sample` that are used; the torque among them is M_z or M."""

    @property
    def is_linear(self) -> bool:
        """True where the measurement is linear in the states, so that iterating it changes nothing."""

    @property
    def scaled(self) -> str:
        """Field of `Sample` that the stiffness scales; empty where inertia takes part of the torque."""

    @property
    def torque_state(self) -> tuple[str, ...]:
        """Names of the numbers that `observed_torque` keeps."""

    @property
    def gear_spread(self) -> float:
        """Standard deviation of a steering gear's dry friction over the declared one [1]; 0 without."""

    @property
    def gain_share(self) -> float:
        """Share of a stiffness other than k's that may be an error of the torque's scale [1]."""

    def observed_torque(
        self, before: Parts, sample: Parts, rig: Expression, tuning: Expression
    ) -> tuple[Parts, Expression, Expression, Expression]:
        """The aligning torque without a model of it: state after, its angle, M_z and its variance.

        rig is in the order of `RIG`, tuning in that of `TUNING_FIELDS`; M_z [N m] is NaN where the
        sample brings none, the variance [N^2 m^2] is that of its white noise.
        """

    def check(self, rig: Rig, model: Model) -> None:
        """Raise InvalidInputError where the rig lacks a value or the model an effect too many."""

    def prior(self, tuning: Parts, first: Parts, slide_torque: Expression) -> dict[str, Moments]:
        """Mean and variance of every state before the sample `first`; slide_torque: 3/8 F_N a [N m]."""

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """The sample with missing values imputed from the `last` one, and whether one was."""

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """The states at the sample `now`, and the variances of their disturbances since `last`."""

    def measurement(
        self, x: Parts, M_z: Expression, now: Parts, rig: Parts, tuning: Parts
    ) -> Measurement:
        """The measurement of the sample `now`."""


def impute_load(sample: Parts, last: Parts) -> tuple[Expression, Expression, Expression]:
    """Load [N], the last valid one where it is missing, and two flags: is missing, is too small.

    A load below `MIN_LOAD_SHARE` of the first one, zero or negative too, is missing as NaN is.
    """
    given = is_known(sample["F_N"])
    too_small = ca.logic_and(given, sample["F_N"] < MIN_LOAD_SHARE * last["F_N_first"])
    missing = ca.logic_or(ca.logic_not(given), too_small)
    return ca.if_else(missing, last["F_N"], sample["F_N"]), missing, too_small


def predict_random_walk(
    x: Parts, slide_torque: Expression, dt: Expression, tuning: Parts
) -> tuple[dict[str, Any], Any]:
    """The states that are random walks, after dt, and the variances of their increments."""
    fade = ca.exp(-dt / tuning["zero_time"])
    after, variance = {"log_mu": x["log_mu"]}, {"log_mu": dt * tuning["mu_walk"] ** 2}
    if "M_0" in x:
        after["M_0"] = fade * x["M_0"]
        variance["M_0"] = dt * fade * (tuning["zero_walk"] * slide_torque) ** 2
    if "stiffness" in x:
        after["stiffness"] = x["stiffness"]
        variance["stiffness"] = dt * tuning["stiffness_walk"] ** 2
    return after, variance


def random_walk_prior(
    tuning: Parts, states: tuple[str, ...], slide_torque: Expression
) -> dict[str, Moments]:
    """Mean and variance of the states that are random walks."""
    prior = {
        "log_mu": (ca.log(tuning["mu"]), log_mu_prior_variance(tuning)),
        "M_0": (0, (tuning["zero_std"] * slide_torque) ** 2),
        "stiffness": (1, tuning["stiffness_std"] ** 2),
    }
    return {name: prior[name] for name in states if name in prior}


def log_mu_prior_variance(tuning: Parts) -> Expression:
    """Variance of ln mu on an unknown ground [1]."""
    return (tuning["mu_std"] / tuning["mu"]) ** 2


def select_states(**selected: bool) -> tuple[str, ...]:
    """Names of the selected states in the order of `STATES`."""
    return tuple(name for name in STATES if selected.get(name, False))


def has_gear_friction(measurement_model: MeasurementModel) -> bool:
    """Whether the dry friction of a steering gear is a state."""
    return "gear" in measurement_model.states


@dataclass(frozen=True, kw_only=True)
class AligningTorque:
    """M_z = h(history of the angle, mu) + M_0 is measured, the angle known; states mu and as chosen.

    Attributes:
        zero: the zero M_0 of the torque channel is a state [N m].
        stiffness: k over its nominal value is a state [1].
    """

    zero: bool = True
    stiffness: bool = False
    channels: ClassVar[tuple[str, ...]] = ("psi", "psi_dot", "F_N", "M_z")
    # M_z is no linear function of mu.
    is_linear: ClassVar[bool] = False
    scaled: ClassVar[str] = "M_z"
    torque_state: ClassVar[tuple[str, ...]] = NOISE
    gain_share: ClassVar[float] = GAIN_SHARE

    @property
    def gear_spread(self) -> float:
        """No gear stands between the sensor and the wheel."""
        return 0.0

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return select_states(log_mu=True, M_0=self.zero, stiffness=self.stiffness)

    def observed_torque(
        self, before: Parts, sample: Parts, rig: Expression, tuning: Expression
    ) -> tuple[Parts, Expression, Expression, Expression]:
        """The measured torque at the measured angle, its noise as declared or, if more, as seen."""
        values, M_z = named(RIG, rig), sample["M_z"]
        declared = declared_sensor_variance(values)
        if not self.torque_state:
            return before, sample["psi"], M_z, declared
        slide_torque = full_slide_torque(
            ca.if_else(is_known(sample["F_N"]), sample["F_N"], 0), values["a"]
        )
        stated = (named(TUNING_FIELDS, tuning)["noise"] * slide_torque) ** 2
        initial = ca.if_else(is_known(values["noise"]), declared, stated)
        after = update_sensor_noise_estimate(
            before, M_z, sample["dt"], initial, (SENSOR * slide_torque) ** 2
        )
        # That of one sample, from that of `REFERENCE_STEP`.
        interval = before["waited"] + sample["dt"]
        seen = after["variance"] * ca.fmax(1, REFERENCE_STEP / interval)
        return after, sample["psi"], M_z, ca.fmax(declared, seen)

    def check(self, rig: Rig, model: Model) -> None:
        """Any rig and any model will do."""

    def prior(self, tuning: Parts, first: Parts, slide_torque: Expression) -> dict[str, Moments]:
        """Mean and variance of every state."""
        del first
        return random_walk_prior(tuning, self.states, slide_torque)

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """Where the angle is missing, the patch does not turn; there the torque is ignored.

        It is also ignored where the load is given, but too small: a wheel that is lifted says nothing.
        """
        known = is_known(sample["psi"])
        F_N, load_imputed, too_small = impute_load(sample, last)
        usable = ca.logic_and(known, ca.logic_not(too_small))
        turning = ca.logic_and(known, is_known(sample["psi_dot"]))
        psi = ca.if_else(known, sample["psi"], last["psi"])
        psi_dot = ca.if_else(turning, sample["psi_dot"], 0)
        # The rate tells noise of the angle from a turn; a rate of 0 may stand for no sensor at all.
        travel = ca.fabs(ca.if_else(psi_dot == 0, psi - last["psi"], psi_dot * sample["dt"]))
        waited, dt = ca.logic_not(is_known(last["M_z"])), sample["dt"]
        now = dict.fromkeys(CLEAN, 0) | {
            "psi": psi, "psi_dot": psi_dot, "F_N": F_N, "F_N_first": last["F_N_first"],
            "dt": dt, "M_z": ca.if_else(usable, sample["M_z"], float("nan")),
            "interval": ca.fmax(dt, ca.fmin(REFERENCE_STEP, dt + waited * last["interval"])),
            "travel": travel + waited * last["travel"],
        }  # fmt: skip
        return now, ca.logic_or(load_imputed, ca.logic_not(known))

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """All states are random walks."""
        del M_z, last
        return predict_random_walk(x, self._unit_slide_torque(now, rig), now["dt"], tuning)

    def measurement(
        self, x: Parts, M_z: Expression, now: Parts, rig: Parts, tuning: Parts
    ) -> Measurement:
        """The aligning torque with the zero of its channel [N m]."""
        return self._torque_measurement(M_z + x.get("M_0", 0), x, now, rig, tuning)

    def _unit_slide_torque(self, now: Parts, rig: Parts) -> Expression:
        """Torque of full slide at mu = 1 [N m]."""
        return full_slide_torque(now["F_N"], rig["a"])

    def _torque_measurement(
        self, expected: Expression, x: Parts, now: Parts, rig: Parts, tuning: Parts,
        unsure: Expression = 0,
    ) -> Measurement:  # fmt: skip
        """The measurement of a torque; unsure is a deviation of what is expected that lasts [N m]."""
        slide_torque, dt = self._unit_slide_torque(now, rig), ca.fmin(now["interval"], MAX_WEIGHTED_STEP)
        independent = independent_sample_share(now["travel"], tuning["error_travel"])
        noise, error = (
            relative_sensor_noise_variance(rig, tuning, slide_torque),
            model_error_variance(x, tuning),
        )
        lasting = error + (unsure / slide_torque) ** 2
        variance = lasting * dt + REFERENCE_STEP * noise * independent
        return Measurement(
            expected=expected,
            measured=now["M_z"],
            precision=dt * independent / (variance * slide_torque**2),
            huber_scale=huber_scale_squared(x, tuning, noise) * slide_torque**2 + unsure**2,
            independent=independent,
        )
