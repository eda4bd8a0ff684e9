"""The two ways in which friction is heard: which states, which motion, which measurement.

The friction state is the logarithm of mu: long before full slide the torque says that mu is at least so
much, and how much more is open; that is far less skewed in ln mu than in mu, and mu stays positive.

Aligning torque measured, as on the rig: the angle is known, M_z = h(history of the angle, mu) + M_0 is
the measurement, and the states only walk.

Steering torque measured, as in electric power steering: M drives the wheel,

    J_A psi'' = -b_t psi' + M_z + M + M_0,

source (2.13) with the sign of M_z that its own (2.3) needs, and the angle is the measurement: what the
wheel does under a known torque tells M_z. The motion is integrated by Stoermer and Verlet's leapfrog,
damping implicit: psi' is the rate in the middle between two samples, so M_z is needed at samples only.

Source of the leapfrog: Verlet, Phys. Rev. 159 (1967) 98.
"""

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca

from observers.protocol import SAMPLE, Sample
from observers.tuning import REFERENCE_STEP, STATES, Tuning
from symbolic import Rig, full_slide_torque

Expression = Any
Parts = Mapping[str, Expression]
RIG = ("a", "e", "J_A", "b_t")
"""Order of the rig's numbers."""
LONGEST = 0.05
"""A sample speaks for no longer than this, however long the gap before it [s]."""
SENSIBLE = 1e9
"""No sensor means a number this large, in SI units; single precision could not even square 1e20."""
CLEAN = (*SAMPLE, "lost")
"""Order of a cleaned sample: last known values where a sensor gave none; for how long M was held [s]."""


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """What a sample measures.

    Attributes:
        expected: by the state.
        measured: by the sensor, NaN for nothing.
        precision: inverse variance of the error, taken as white; 0 in an empty place of a window.
        ordinary: square of what counts as an error of ordinary size.
    """

    expected: Expression
    measured: Expression
    precision: Expression
    ordinary: Expression


class MeasurementModel(Hashable, Protocol):
    """A way of hearing friction; written for casadi expressions throughout."""

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, log_mu first, in the order of `STATES`."""

    @property
    def turns(self) -> bool:
        """True where the angle is a state, so that the patch follows the estimate."""

    def check(self, rig: Rig) -> None:
        """Raise InvalidInputError where the rig lacks what is needed."""

    def prior(self, tuning: Tuning, first: Sample, slide: float) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation of every state; `slide` is 3/8 F_N a [N m]."""

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """The sample with values held where a sensor gave none, and whether one is."""

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, beliefs: Parts
    ) -> tuple[Parts, Parts]:
        """The states at the sample `now`, and the variances of what disturbs them on the way."""

    def reading(self, x: Parts, M_z: Expression, now: Parts, rig: Parts, beliefs: Parts) -> Measurement:
        """What the sample `now` measures."""


def is_known(value: Expression) -> Expression:
    """False for NaN, infinity and nonsense: casadi takes x == x for true, but no comparison with NaN."""
    return ca.fabs(value) < SENSIBLE


def clean_load(sample: Parts, last: Parts) -> tuple[Expression, Expression]:
    """The load, held where it is missing or not positive, and whether it is [N]."""
    known = ca.logic_and(is_known(sample["F_N"]), sample["F_N"] > 0)
    return ca.if_else(known, sample["F_N"], last["F_N"]), ca.logic_not(known)


def walk(x: Parts, slide: Expression, dt: Expression, beliefs: Parts) -> tuple[dict[str, Any], Any]:
    """The states that only walk, after dt, and the variances of their walks."""
    fade = ca.exp(-dt / beliefs["zero_time"])
    after, variance = {"log_mu": x["log_mu"]}, {"log_mu": dt * beliefs["mu_walk"] ** 2}
    if "M_0" in x:
        after["M_0"] = fade * x["M_0"]
        variance["M_0"] = dt * fade * (beliefs["zero_walk"] * slide) ** 2
    if "stiffness" in x:
        after["stiffness"] = x["stiffness"]
        variance["stiffness"] = dt * beliefs["stiffness_walk"] ** 2
    return after, variance


def walking_prior(tuning: Tuning, states: tuple[str, ...], slide: float) -> dict[str, Any]:
    """Mean and standard deviation of the states that only walk."""
    prior = {
        "log_mu": (math.log(tuning.mu), tuning.log_std),
        "M_0": (0.0, tuning.zero_std * slide),
        "stiffness": (1.0, tuning.stiffness_std),
    }
    return {name: prior[name] for name in states if name in prior}


def chosen(**wanted: bool) -> tuple[str, ...]:
    """Names of the states wanted, in their order."""
    return tuple(name for name in STATES if wanted.get(name, False))


@dataclass(frozen=True, kw_only=True)
class AligningTorque:
    """The aligning torque is measured, the angle known; states mu and as chosen.

    Attributes:
        zero: the zero M_0 of the torque channel is a state [N m].
        stiffness: k over its nominal value is a state [1].
    """

    zero: bool = True
    stiffness: bool = False

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return chosen(log_mu=True, M_0=self.zero, stiffness=self.stiffness)

    @property
    def turns(self) -> bool:
        """The angle is no state."""
        return False

    def check(self, rig: Rig) -> None:
        """Nothing beyond a and e is needed."""

    def prior(self, tuning: Tuning, first: Sample, slide: float) -> dict[str, tuple[float, float]]:
        """Mean and standard deviation of every state."""
        del first
        return walking_prior(tuning, self.states, slide)

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """Without an angle the patch stays and the torque says nothing."""
        known = is_known(sample["psi"])
        F_N, load_held = clean_load(sample, last)
        turning = ca.logic_and(known, is_known(sample["psi_dot"]))
        made = {
            "psi": ca.if_else(known, sample["psi"], last["psi"]),
            "psi_dot": ca.if_else(turning, sample["psi_dot"], 0),
            "F_N": F_N,
            "dt": sample["dt"],
            "M_z": ca.if_else(known, sample["M_z"], float("nan")),
            "M": 0,
            "lost": 0,
        }
        return made, ca.logic_or(load_held, ca.logic_not(known))

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, beliefs: Parts
    ) -> tuple[Parts, Parts]:
        """All states only walk."""
        del M_z, last
        return walk(x, full_slide_torque(now["F_N"], rig["a"]), now["dt"], beliefs)

    def reading(self, x: Parts, M_z: Expression, now: Parts, rig: Parts, beliefs: Parts) -> Measurement:
        """The aligning torque with the zero of its channel [N m]."""
        slide = full_slide_torque(now["F_N"], rig["a"])
        return Measurement(
            expected=M_z + x.get("M_0", 0),
            measured=now["M_z"],
            precision=ca.fmin(now["dt"], LONGEST) / (REFERENCE_STEP * (beliefs["noise"] * slide) ** 2),
            ordinary=(beliefs["error"] * slide) ** 2,
        )
