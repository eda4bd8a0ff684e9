"""What every observer of the friction coefficient offers: pure functions, state passed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Sample:
    """One sample of the sensors.

    Attributes:
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s].
        F_N: vertical load [N].
        dt: time since the last sample [s].
        M_z: aligning torque, moment of the ground on the wheel [N m]; NaN where the sample is missing.
    """

    psi: float
    psi_dot: float
    F_N: float
    dt: float
    M_z: float = float("nan")

    def __post_init__(self) -> None:
        """Check that what the model needs is there."""
        inputs = [self.psi, self.psi_dot, self.F_N, self.dt]
        if not self.F_N > 0 or not self.dt > 0 or not np.isfinite(inputs).all():
            raise InvalidInputError(
                "a sample needs finite psi and psi_dot, F_N > 0 N and dt > 0 s; only M_z may be missing,"
                f" got {self}"
            )


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What an observer says at one sample.

    Attributes:
        mu: friction coefficient [1].
        mu_std: its standard deviation [1].
        M_z_predicted: aligning torque expected before the measurement was seen [N m].
        informed: False while the estimate rests on the prior, as in full stick.
    """

    mu: float
    mu_std: float
    M_z_predicted: float
    informed: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates:
    """What an observer says over a recording; arrays of shape (n,), meanings as in `Estimate`.

    Attributes:
        t: time [s].
        mu: friction coefficient [1].
        mu_std: its standard deviation [1].
        M_z_predicted: aligning torque expected before each measurement [N m].
        informed: False while the estimate rests on the prior.
    """

    t: Array
    mu: Array
    mu_std: Array
    M_z_predicted: Array
    informed: NDArray[np.bool_]


class Observer(Protocol):
    """An observer: immutable settings, pure functions, state passed from sample to sample."""

    def init(self, first: Sample) -> Any:
        """The state before the first sample."""

    def step(self, state: Any, sample: Sample) -> Any:
        """The state after one sample."""

    def estimate(self, state: Any) -> Estimate:
        """What the state says."""

    def run_samples(self, samples: Array) -> Sequence[Array]:
        """mu, mu_std, M_z_predicted and informed over rows psi, psi_dot, F_N, dt, M_z."""
