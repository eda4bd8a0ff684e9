"""What every observer of the friction coefficient offers: pure functions, state passed."""

from dataclasses import dataclass
from enum import IntFlag
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError

Array = NDArray[np.float64]
LONGEST_STEP = 3600.0
"""A pause longer than this is the end of a measurement [s]."""
SAMPLE = ("psi", "psi_dot", "F_N", "dt", "M_z", "M")
"""Order of a sample's numbers."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Sample:
    """One sample of the sensors; NaN where a sensor gave none, which is predicted through.

    Attributes:
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s]; a missing one counts as 0, `run` and `Loop` take it from psi.
        F_N: vertical load [N]; a missing or non-positive one counts as unchanged.
        dt: time since the last sample, at most an hour [s].
        M_z: aligning torque, moment of the ground on the wheel [N m], where that is measured.
        M: steering torque, of the hand or motor on the wheel [N m], where that is measured.

    Raises:
        InvalidInputError: dt is not greater than 0 and at most an hour.
    """

    psi: float
    psi_dot: float
    F_N: float
    dt: float
    M_z: float = float("nan")
    M: float = float("nan")

    def __post_init__(self) -> None:
        """Check the one number that may not be missing."""
        if not 0 < self.dt <= LONGEST_STEP:
            raise InvalidInputError(
                f"a sample needs dt > 0 s and at most {LONGEST_STEP:g} s, got dt = {self.dt}"
            )


class Status(IntFlag):
    """What became of a sample; `remedy` says what to do about it."""

    USED = 0
    MISSING = 1
    HELD = 2
    REJECTED = 4
    RESET = 8
    BOUND = 16
    UNSETTLED = 32
    NO_ROOT = 64

    @property
    def remedy(self) -> str:
        """What it means and what helps, a clause a flag; empty where all went well."""
        return "; ".join(text for flag, text in _REMEDIES.items() if flag in self)


_REMEDIES = {
    Status.MISSING: "no measurement, predicted through: check the sensor if it lasts",
    Status.HELD: "angle, load or steering torque missing, the last one held: check the sensor if it"
    " lasts",
    Status.REJECTED: "measurement beyond the gate, not believed: if it lasts without a reset,"
    " raise Tuning.gate or Tuning.noise",
    Status.RESET: "the ground has changed, mu is being learnt anew: wait until informed",
    Status.BOUND: "mu is on its bound: check k, a, F_N and the sign of the torque, or widen the bounds",
    Status.UNSETTLED: "the last Gauss-Newton step moved mu by more than its standard deviation: raise"
    " Mhe.iterations",
    Status.NO_ROOT: "no mu explains the torque, the nearest was taken: check k and a, or use Ekf or Mhe",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Estimate:
    """What an observer says at one sample.

    Attributes:
        mu: friction coefficient [1].
        mu_std: its standard deviation [1].
        M_z_predicted: aligning torque expected before its measurement was seen [N m]; where the angle is
            what is measured, the model's torque at the corrected angle.
        informed: False while the estimate rests on the prior, as in full stick.
        status: what became of the sample.
    """

    mu: float
    mu_std: float
    M_z_predicted: float
    informed: bool
    status: Status = Status.USED


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates:
    """What an observer says of a recording, causally; arrays of shape (n,), fields as in `Estimate`."""

    t: Array
    mu: Array
    mu_std: Array
    M_z_predicted: Array
    informed: NDArray[np.bool_]
    status: NDArray[np.int64]


class Observer(Protocol):
    """An observer: its settings are its fields, its state is passed."""

    def init(self, first: Sample) -> Any:
        """The state before the first sample, whose angle says where the patch stands at rest."""

    def step(self, state: Any, sample: Sample) -> Any:
        """The state after one more sample."""

    def estimate(self, state: Any) -> Estimate:
        """What the state says."""


class BatchObserver(Observer, Protocol):
    """An observer that takes a whole recording at once, with the same result sample by sample."""

    def run_samples(self, samples: Array) -> Array:
        """Rows mu, mu_std, M_z_predicted, informed, status of every sample, shape (5, n).

        Args:
            samples: one sample a column, rows in the order of `SAMPLE`, shape (6, n); the first one
                also starts the state.
        """
