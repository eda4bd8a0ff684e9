"""Prior, noises and limits of an observer, and what a rig's tolerances and its sensor's range add.

Full slide measures mu times load and lever, so that an error of either is one of mu which no measurement
lowers: a parameter that is considered, not estimated, [Schmidt 1966]. An error of half-length or caster
also makes the patch stiffer or softer, as one of k does. A sensor that ends looks like full slide: what
is near the end is left out.
"""

import re
from dataclasses import dataclass, fields, replace
from inspect import cleandoc
from math import hypot, isfinite

import numpy as np

from symbolic import InvalidInputError, Rig
from symbolic.float_array_type import Array
from symbolic.patch_moment_by_zones import full_slide_arm, unit_corner_moment
from symbolic.rig_and_tyre import EVEN, USUAL, relative_std_by_lengths

STATES = ("log_mu", "M_0", "stiffness", "psi", "psi_dot", "gear", "log_mu_other")
"""Order of the states, of which an observer takes those it needs: natural logarithm of mu, zero of the
torque channel [N m], k over its nominal value [1], yaw angle [rad], yaw rate [rad/s], dry friction
of a car's steering gear over the declared one [1], ln mu of the direction that does not slide."""
REFERENCE_STEP = 0.01
"""Time between samples for which `Tuning.noise` holds [s]."""
NO_LIMIT = 1e9
"""Values of this size are missing in any case [SI units]."""
INFORMED = 0.5
"""Share of the prior's relative standard deviation below which an estimate is its own [1]."""

PLAUSIBLE = ("psi_limit", "psi_rate_limit", "F_N_limit", "torque_limit", "rezero_time")
"""Limits of what a sensor may give, see `observers.quality.sample_screening`."""
LIMIT_FIELDS = (
    *("mu", "least", "greatest", "zero_time", "error", "gate", "reset_after", "alarm", "explained"),
    *PLAUSIBLE,
)
"""Fields that are no standard deviation: checked against each other, or inf means no limit."""
POSITIVE = (
    *("mu_std", "least", "zero_time", "noise", "psi_noise", "psi_dot_std", "gate"),
    *("error", "alarm", "explained"),
    *PLAUSIBLE,
)
"""Fields that must be greater than 0."""
NON_NEGATIVE_FIELDS = (
    *("stiffness_std", "mu_walk", "mu_floor", "error_travel", "zero_std", "zero_walk", "stiffness_walk"),
)
"""Fields that may be 0."""
_DESCRIBED = re.compile(r"^    ([A-Za-z_, ]+): (.+?)(?=^    \w|\Z)", re.MULTILINE | re.DOTALL)
_SENTENCE, _UNIT = re.compile(r"(?<=[^.])[.;] |: "), re.compile(r" \[[^]]*\]")
TUNING_UNITS = {
    **dict.fromkeys(("mu_walk", "zero_walk", "stiffness_walk"), "1/sqrt(s)"),
    **dict.fromkeys(("zero_time", "rezero_time"), "s"),
    **dict.fromkeys(("error_travel", "psi_noise", "psi_limit"), "rad"),
    **dict.fromkeys(("psi_dot_std", "psi_rate_limit"), "rad/s"),
    "F_N_limit": "N",
    "torque_limit": "N m",
}
"""Units of the fields that have one."""
OF_LENGTHS = "tolerances of half-length and caster"
OF_LOAD = "tolerance of the load"
OF_SCALE = "scale of the torque, by what is declared beside the load or found"
OF_TUNING = "mu_floor of the tuning"
"""Causes of a floor of mu."""
LEAST_STIFFNESS = 1.5
"""Least deviation of the stiffness over the model's error [1], that of an undeclared k at most: a torque
that is off by that error tells k no closer, and a k that is declared closer would never be confirmed."""


def require_positive_ints(**counts: object) -> None:
    """Refuses what is no whole number of at least 1."""
    for name, value in counts.items():
        if not (isinstance(value, int) and value >= 1):
            raise InvalidInputError(f"{name} must be a whole number of at least 1, got {value}")


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """Prior, noises and limits; torques are shares of 3/8 F_N a, the full-slide torque at mu = 1.

    Attributes:
        mu: prior friction coefficient [1].
        mu_std: standard deviation of the prior of mu [1].
        mu_walk: random walk of mu as a share of itself [1/sqrt(s)].
        least, greatest: bounds that mu is clipped to [1].
        zero_std: prior standard deviation of the torque zero as a share of 3/8 F_N a [1].
        zero_walk: random walk of the torque zero as a share of 3/8 F_N a [1/sqrt(s)].
        zero_time: time constant with which the torque zero decays [s]; inf for a constant zero. A finite
            one absorbs model error that lasts.
        stiffness_std: prior standard deviation of k over its nominal value [1], where k is a state.
        stiffness_walk: random walk of k over its nominal value [1/sqrt(s)].
        mu_floor: relative standard deviation of mu that no measurement lowers [1], as half-length and
            load are known to so much only: full slide measures mu times both. It is added to what is
            reported, in quadrature, and does not enter the filter: a parameter that is considered, not
            estimated, [Schmidt 1966].
        noise: torque noise as a share of 3/8 F_N a, the standard deviation of a white error of one
            sample in 10 ms [1]. It counts by time, not by samples.
        error: standard deviation of the torque error of the model as a share of the torque that there
            is, of full slide at the present mu [1]; Huber's loss is quadratic up to it. Model error is
            intermittent, at reversals above all; Huber's loss limits its influence on mu. inf for least
            squares, and no model error.
        error_travel: turn in which the model's error is worth one independent sample [rad]. It follows
            the history of the angle, so that it does not average out while the wheel stands. 0 where the
            error is that of `noise` alone.
        psi_noise: standard deviation of a measured angle [rad], where the angle is what is measured; the
            default is half a step of a 14-bit encoder.
        psi_dot_std: prior standard deviation of the yaw rate, where the angle is what is measured
            [rad/s].
        gate: an innovation beyond so many times its usual size is rejected [1]; the usual size is that
            of `error` (of `noise` if that is less) and of the prior covariance; inf accepts everything.
        reset_after: after so many innovations in a row beyond the gate, all to one side, the ground has
            changed: twice the variance of the prior is added to that of ln mu.
        alarm: log-likelihood ratio at which innovations within the gate say that the ground has changed
            [1]; see `observers.quality.slow_change_and_misfit_alarms`, inf for never.
        explained: mean square of the innovations over their variance beyond which the model and its
            stated error do not explain the torque [1]; `Status.INCONSISTENT`, inf for never.
        psi_limit: an angle of this size is implausible and left out [rad]; `Status.IMPLAUSIBLE`, inf for
            none, as for the limits that follow.
        psi_rate_limit: an angle that a wheel as fast as this does not reach is left out, and such a rate
            [rad/s]. The fastest recording at hand turns at 3.8 rad/s; a spike in one of 100 samples a
            second is seen from 0.09 rad on.
        F_N_limit: a load of this size is left out [N].
        torque_limit: a torque of this size is left out [N m].
        rezero_time: an angle that has jumped and stays for so long is that of a sensor whose zero has
            moved; the jump is taken off [s].
    """

    mu: float = 1.0
    mu_std: float = 0.5
    mu_walk: float = 0.01
    mu_floor: float = 0.02
    least: float = 0.02
    greatest: float = 4.0
    zero_std: float = 0.03
    zero_walk: float = 0.001
    zero_time: float = float("inf")
    stiffness_std: float = 0.0
    stiffness_walk: float = 0.0
    noise: float = 0.02
    error: float = 0.05
    error_travel: float = 0.2
    psi_noise: float = 2e-4
    psi_dot_std: float = 0.1
    gate: float = 12.0
    reset_after: int = 5
    alarm: float = 5.0
    explained: float = 1.0
    psi_limit: float = 6.3
    psi_rate_limit: float = 8.0
    F_N_limit: float = 1e5
    torque_limit: float = 1e4
    rezero_time: float = 0.1

    def __post_init__(self) -> None:
        """Check signs and order."""
        for name in POSITIVE:
            if not getattr(self, name) > 0:
                raise InvalidInputError(f"{name} must be greater than 0, got {getattr(self, name)}")
        for name in NON_NEGATIVE_FIELDS:
            if not getattr(self, name) >= 0:
                raise InvalidInputError(f"{name} must be at least 0, got {getattr(self, name)}")
        for name in TUNING_FIELDS:
            if name not in LIMIT_FIELDS and not isfinite(getattr(self, name)):
                raise InvalidInputError(f"{name} must be finite, got {getattr(self, name)}")
        if not self.least < self.mu < self.greatest:
            raise InvalidInputError(
                f"mu must lie between least and greatest, {self.least} and {self.greatest},"
                f" got {self.mu}"
            )
        require_positive_ints(reset_after=self.reset_after)

    @property
    def prior_log_mu_std(self) -> float:
        """Prior standard deviation of ln mu [1]."""
        return self.mu_std / self.mu

    @property
    def informed_below(self) -> float:
        """Relative standard deviation of mu below which an estimate is informed [1]."""
        return INFORMED * self.prior_log_mu_std

    @property
    def sensor_limits(self) -> tuple[float, ...]:
        """Limits of what a sensor may give in the order of `PLAUSIBLE`, none above `NO_LIMIT`."""
        return tuple(min(float(getattr(self, name)), NO_LIMIT) for name in PLAUSIBLE)

    @property
    def vector(self) -> Array:
        """All fields as numbers, in the order of `TUNING_FIELDS`."""
        return np.array([float(getattr(self, name)) for name in TUNING_FIELDS])


TUNING_FIELDS = tuple(field.name for field in fields(Tuning))
"""Order of `Tuning.vector`."""


def field_meanings() -> dict[str, str]:
    """Meaning of each field of `Tuning`: the first sentence of its description, without the unit."""
    found = {}
    described = cleandoc(Tuning.__doc__ or "").partition("Attributes:")[2]
    for names, text in _DESCRIBED.findall(described):
        first = _SENTENCE.split(" ".join(text.split()), maxsplit=1)[0]
        for name in names.split(", "):
            found[name] = _UNIT.sub("", first).rstrip(".")
    return found


def tuning_with_tolerances(tuning: Tuning, rig: Rig, stiffness: float) -> Tuning:
    """The tuning with the floor of mu and the deviation of the stiffness that tolerances make.

    They add to its own in quadrature; where no tolerance is declared, `symbolic.rig_and_tyre.USUAL`
    counts. Its limit of the torque is within the range of the sensor. stiffness is the rig's k [N/m^2].
    """
    tolerance = USUAL["k"] if rig.tolerances.k is None else rig.tolerances.k / stiffness
    patch = relative_std_by_lengths(lambda a, e: unit_corner_moment(0.0, a, e), rig)
    least = min(LEAST_STIFFNESS * tuning.error, EVEN * USUAL["k"])
    return replace(
        tuning,
        torque_limit=min(tuning.torque_limit, rig.sensor_torque_limit),
        mu_floor=hypot(*mu_std_floor_by_cause(tuning, rig).values()),
        stiffness_std=max(hypot(tuning.stiffness_std, EVEN * tolerance, patch), least),
    )


def mu_std_floor_by_cause(tuning: Tuning, rig: Rig) -> dict[str, float]:
    """Deviations that no measurement lowers, by cause, as shares of mu [1]; they add in quadrature."""
    load = USUAL["load"] if rig.tolerances.load is None else rig.tolerances.load
    return {
        OF_LENGTHS: relative_std_by_lengths(full_slide_arm, rig),
        OF_LOAD: EVEN * load,
        OF_SCALE: EVEN * rig.tolerances.scale,
        OF_TUNING: tuning.mu_floor,
    }
