"""Hooks of an effect of the rig, and the records that pass between rig and effect."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RigDrive:
    """Imposed angle and load of the tyre; all arrays of shape (n,).

    `psi_virgin` is the angle at which the patch was free of deformation before the first sample.
    """

    t: Array
    """Time [s]."""
    psi: Array
    """Yaw angle [rad]."""
    psi_dot: Array
    """Yaw rate [rad/s]."""
    F_N: Array
    """Vertical load [N]."""
    psi_virgin: float


@dataclass(frozen=True, kw_only=True, eq=False)
class BristleStep:
    """One step of the drive as a bristle sees it."""

    psi_dot: float
    """Yaw rate [rad/s]."""
    F_N: float
    """Vertical load [N]."""
    travel: float
    """Angle turned since the first sample, counted both ways [rad]."""
    lever: Array
    """Distance of each bristle from the kingpin [m], shape (bristles,)."""
    age: float = 0.0
    """How old the contact is [s], see `contact_age`."""

    @cached_property
    def speed(self) -> Array:
        """Speed at which the wheel drives each bristle [m/s], shape (bristles,)."""
        return self.lever * abs(self.psi_dot)


@dataclass(frozen=True, kw_only=True, eq=False)
class RigHistory:
    """Response of the rig; all arrays of shape (n,)."""

    drive: RigDrive
    """The drive at the sensor, before any effect changed it on its way to the patch."""
    psi_patch: Array
    """Angle of the patch [rad]."""
    M_z: Array
    """Moment of the ground on the wheel about the kingpin [N m]."""
    sliding: Array
    """Share of the bristles that slid during the step [1]."""


@dataclass(frozen=True, kw_only=True)
class MaxwellBranch:
    """Maxwell branch beside each bristle spring: stiffness gain k, relaxation time [s]."""

    gain: float = 0.0
    time: float = 1.0


@dataclass(frozen=True, kw_only=True)
class PlantedEffect:
    """An effect that changes nothing. Real ones override the one hook at which they act."""

    @property
    def rank(self) -> int:
        """Effects act on the finished torque in the order of their rank."""
        return 0

    def width(self) -> float:
        """Half-width of the patch [m]; zero is a line of bristles."""
        return 0.0

    def span(self) -> float:
        """Half-lengths over which there are bristles [1]."""
        return 1.0

    def growth(self, F_N: float, a: float) -> float:
        """Half-length of the patch under the load over the declared one, a [m] [1]."""
        del F_N, a
        return 1.0

    def pressure(self, xi: Array) -> Array | float:
        """Factor on the parabolic pressure at xi = x/a [1]."""
        del xi
        return 1.0

    def relaxation(self) -> MaxwellBranch:
        """Branch beside each bristle spring."""
        return MaxwellBranch()

    def compliance(self) -> float:
        """Torsional compliance in series with the patch [rad/(N m)]."""
        return 0.0

    def lost_motion(self) -> float:
        """Play in series with the patch, from flank to flank [rad]."""
        return 0.0

    def friction(self, sample: BristleStep) -> Array | float:
        """Factor on the friction limit during one step [1]."""
        del sample
        return 1.0

    def rate(self) -> float:
        """Growth c >= 0 of the friction limit with the logarithm of a bristle's own speed [1]."""
        return 0.0

    def drive(self, drive: RigDrive) -> RigDrive:
        """The drive that reaches the tyre, from the one at the sensor."""
        return drive

    def torque(self, history: RigHistory) -> Array:
        """The torque channel [N m]."""
        return history.M_z
