"""Interface of every observer of the friction coefficient: pure functions, the state is passed."""

import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntFlag
from math import isfinite
from operator import attrgetter
from typing import Any, Protocol

import casadi as ca
import numpy as np

from observers.layout import Layout
from symbolic import InvalidInputError, Model, Rig
from symbolic.float_array_type import Array

MAX_SAMPLE_PERIOD = 3600.0
"""A pause longer than this is the end of a measurement [s]."""
SAMPLE = ("psi", "psi_dot", "F_N", "dt", "M_z", "M")
"""Order of a sample's numbers."""
_NUMBERS = attrgetter(*SAMPLE)
OUTPUT = ("mu", "mu_std", "M_z_predicted", "mu_eff", "mu_eff_std", "M_slide", "nis", "status")
"""Order of the output of an observer's step Function."""
ESTIMATE = (*OUTPUT[:3], "informed", "usable", *OUTPUT[3:])
"""Order of an estimate's numbers; `informed` and `usable` are 0 or 1, `status` that of a `Status`."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Sample:
    """One sample of the sensors; NaN where a value is missing, which is predicted through.

    Attributes:
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s]; a missing one counts as 0, `run` and `Loop` take it from psi.
        F_N: vertical load [N]; where it is missing, the last one stands. One below a twentieth of the
            first load, zero or negative too, is missing, and M_z with it.
        dt: time since the last sample, at most an hour [s].
        M_z: aligning torque, moment of the ground on the wheel [N m], where that is measured.
        M: steering torque, of the hand or motor on the wheel [N m], where that is measured.

    Raises:
        InvalidInputError: dt is not greater than 0 and at most an hour, or a value is no number.
    """

    psi: float
    psi_dot: float
    F_N: float
    dt: float
    M_z: float = float("nan")
    M: float = float("nan")

    def __post_init__(self) -> None:
        """Check that all are numbers, and the one that must be there."""
        for name in SAMPLE:
            # Of other types some become a number here; a control loop gives floats.
            if type(value := getattr(self, name)) is not float:
                object.__setattr__(self, name, _number(name, value))
        if not 0 < self.dt <= MAX_SAMPLE_PERIOD:
            raise InvalidInputError(
                f"a sample needs dt > 0 s and at most {MAX_SAMPLE_PERIOD:g} s, got dt = {self.dt}"
            )

    @property
    def numbers(self) -> tuple[float, ...]:
        """All numbers in the order of `SAMPLE`."""
        return _NUMBERS(self)


def _number(name: str, value: Any) -> float:
    """A value of another type as a float; a truth value, too, and an array without dimension."""
    try:
        if isinstance(value, str | bytes) or np.ndim(value) or np.iscomplexobj(value):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(
            f"a sample needs one number for {name}, NaN where it is missing, got"
            f" {type(value).__name__} {reprlib.repr(value)}"
        ) from None


class Status(IntFlag):
    """How a sample was treated; `remedy` tells what to do about it."""

    USED = 0
    MISSING = 1
    HELD = 2
    REJECTED = 4
    RESET = 8
    BOUND = 16
    UNSETTLED = 32
    NO_ROOT = 64
    INCONSISTENT = 256
    IMPLAUSIBLE = 512
    ACQUIRING = 1024
    SUSPECT = 2048

    @property
    def remedy(self) -> str:
        """Meaning and remedy, one clause per flag; of `BOUND` once mu is acquired, of `USED` none."""
        told = self & ~Status.BOUND if Status.ACQUIRING in self else self
        return "; ".join(text for flag, text in _REMEDIES.items() if flag in told)


UNINFORMED = int(Status.ACQUIRING | Status.SUSPECT)
"""Flags with which no estimate is informed."""
_REMEDIES = {
    Status.MISSING: "no measurement, predicted through: check the sensor if it lasts",
    Status.HELD: "angle, load or steering torque missing, or the car rolls, the last one used: check"
    " the sensor if it lasts",
    Status.REJECTED: "measurement beyond the gate, rejected: if it lasts without a reset,"
    " raise gate or noise of the tuning",
    Status.RESET: "the ground has changed, mu is being learnt anew: wait until informed",
    Status.BOUND: "mu is on its bound: check k, a, F_N and the sign of the torque, or widen the bounds",
    Status.UNSETTLED: "the last Gauss-Newton step moved mu by more than its standard deviation: raise"
    " iterations",
    Status.NO_ROOT: "no mu explains the torque, the nearest was taken: check k and a, or use Ekf or Mhe",
    Status.INCONSISTENT: "model and stated error do not explain the torque, mu_std is too small: the"
    " ground may just have changed, which is then learnt anew by itself, and where it lasts, find what"
    " the model lacks (brushgrip diagnose), check units, a, F_N and k, declare the torque's noise"
    " ([sensor] noise), try --by-direction, or raise error of the tuning to 0.1: with more, friction is"
    " hardly acquired",
    Status.IMPLAUSIBLE: "a value is beyond its limit or psi jumps, and is left out: check the sensor and"
    " its declared range, or raise the limits of the tuning",
    Status.ACQUIRING: "friction is being acquired: turn on, or turn back once, and where that does not"
    " help, check the torque's unit and gear, then k",
    Status.SUSPECT: "an input looks wrong by its unit, its sign, its gear or its sensor, or k, a and F_N"
    " do not belong to this tyre: correct it, and declare a k with its tolerance only if other means"
    " than this torque measured it",
}


UNCHECKED = (
    "the observer states no deviation and checks nothing, so that friction is for comparison only: use"
    " ekf or mhe"
)
"""Meaning and remedy of an informed estimate without a deviation."""


def uninformed_remedy(relative_std: float) -> str:
    """Meaning and remedy of an estimate that is not informed and has no flag; NaN for no deviation."""
    if not isfinite(relative_std):
        return "the patch has not slid far enough to tell friction: turn further"
    return (
        f"the deviation of mu is {100 * relative_std:.0f} % of mu, too much to act on: turn further,"
        " and where that does not help, correct k or narrow its tolerance"
        " (brushgrip identify), or find what the model lacks (brushgrip diagnose)"
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Estimate:
    """Estimate of an observer at one sample.

    Attributes:
        mu: friction coefficient [1].
        mu_std: its standard deviation [1].
        M_z_predicted: aligning torque expected before its measurement was seen [N m]; where the angle is
            what is measured, the model's torque at the corrected angle.
        informed: False while the estimate rests on the prior, as in full stick, while friction is being
            acquired, and where an input is suspect.
        mu_eff: effective friction [1], which compares between models: the torque of steady full slide at
            `Rig.slide_rate` and the present load over that of the declared patch with mu = 1; mu itself
            on the declared model. NaN before the first load, and where an observer does not state it.
        mu_eff_std: its standard deviation, from that of mu [1].
        M_slide: the torque of that full slide [N m], as mu_eff the mean of both directions.
        nis: normalised innovation squared, the square of measured minus predicted over its variance; 1
            on average where model and tuning are right [1]. NaN without a measurement.
        status: how the sample was treated.
    """

    mu: float
    mu_std: float
    M_z_predicted: float
    informed: bool
    mu_eff: float = float("nan")
    mu_eff_std: float = float("nan")
    M_slide: float = float("nan")
    nis: float = float("nan")
    status: Status = Status.USED

    @property
    def usable(self) -> bool:
        """True where a controller may act on mu_eff: informed, without a flag, with a deviation."""
        return self.informed and self.status == Status.USED and isfinite(self.mu_std)

    @property
    def remedy(self) -> str:
        """Why it is not usable and what to do, that of `status` or of the deviation; empty if usable."""
        if self.status or self.usable:
            return self.status.remedy
        if self.informed:
            return UNCHECKED
        return uninformed_remedy(self.mu_std / self.mu)

    @property
    def numbers(self) -> list[float]:
        """All numbers in the order of `ESTIMATE`."""
        return [float(getattr(self, name)) for name in ESTIMATE]


class Observer(Protocol):
    """An observer: its settings are its fields, its state is passed."""

    @property
    def channel(self) -> str:
        """The torque that it uses: `M_z`, the aligning torque, or `M`, the steering torque."""

    def init(self, first: Sample) -> Any:
        """The state before the first sample, at whose angle the patch is at rest."""

    def step(self, state: Any, sample: Sample) -> Any:
        """The state after one more sample."""

    def estimate(self, state: Any) -> Estimate:
        """The estimate of a state."""


class BatchObserver(Observer, Protocol):
    """An observer that takes a whole recording at once, with the same result sample by sample."""

    def run_samples(self, samples: Array) -> Array:
        """Rows as in `ESTIMATE` of every sample, one column each.

        Args:
            samples: one sample a column, rows in the order of `SAMPLE`, shape (6, n); the first one
                also starts the state.
        """


class FunctionObserver(Observer, Protocol):
    """An observer made of two casadi Functions, of which C can be generated.

    `observers.CasadiObserver` implements all of it from `layout`, `initial_function` and
    `step_function`.
    """

    @property
    def model(self) -> Model:
        """The model, on which test samples for generated code are simulated."""

    @property
    def values(self) -> Mapping[str, float]:
        """Every parameter of the model but mu, by name."""

    @property
    def rig(self) -> Rig:
        """Geometry of the rig."""

    @property
    def name(self) -> str:
        """Name for files and reports, small letters."""

    @property
    def title(self) -> str:
        """One line about the observer, for the head of generated code."""

    @property
    def layout(self) -> Layout:
        """Parts of the state, of which `output` is in the order of `OUTPUT`."""

    @property
    def initial_function(self) -> ca.Function:
        """(sample, constants) -> state: the state before a first sample with valid psi and F_N."""

    @property
    def step_function(self) -> ca.Function:
        """(state, sample, constants) -> (state_next, output), the output in the order of `OUTPUT`.

        `CasadiObserver.output` completes one from mu, mu_std and M_z_predicted.
        """

    @property
    def constants(self) -> Array:
        """Numbers that both Functions take, shape (c,)."""

    @property
    def constant_labels(self) -> tuple[str, ...]:
        """Name and unit of every constant."""

    @property
    def informed_below(self) -> float:
        """Relative standard deviation of mu below which an estimate is informed [1]."""

    @property
    def prior(self) -> Estimate:
        """The estimate before any sample."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """Further settings as JSON values, for the parameter file of generated code."""


def prior_estimate(observer: Observer, dt: float = 0.01) -> Estimate:
    """The estimate before any sample; dt is that of the samples [s]."""
    estimate = observer.estimate(observer.init(Sample(psi=0.0, psi_dot=0.0, F_N=1.0, dt=dt)))
    return replace(estimate, status=Status.MISSING)
