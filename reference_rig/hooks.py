"""Hooks of an effect of the rig, and the records that pass between rig and effect."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RigDrive:
    """Time [s], imposed yaw angle [rad] with its rate [rad/s], and load [N]; arrays of shape (n,).

    `psi_virgin` is the angle at which the patch was free of deformation before the first sample.
    """

    t: Array
    psi: Array
    psi_dot: Array
    F_N: Array
    psi_virgin: float

    def every(self, step: int) -> "RigDrive":
        """The drive with one of so many samples."""
        return self._of(self.t[::step], lambda values: values[::step])

    def at(self, times: Array) -> "RigDrive":
        """The drive at other times [s], linear between its samples."""
        return self._of(times, lambda values: np.interp(times, self.t, values))

    def _of(self, t: Array, change: Callable[[Array], Array]) -> "RigDrive":
        psi, psi_dot, F_N = (change(values) for values in (self.psi, self.psi_dot, self.F_N))
        return replace(self, t=t, psi=psi, psi_dot=psi_dot, F_N=F_N)


@dataclass(frozen=True, kw_only=True, eq=False)
class BristleStep:
    """One step of the drive as a bristle sees it."""

    psi_dot: float  # Yaw rate [rad/s].
    F_N: float  # Vertical load [N].
    travel: float  # Angle turned since the first sample, counted both ways [rad].
    lever: Array  # Distance of each bristle from the kingpin [m], shape (bristles,).
    age: float = 0.0  # How old the contact is [s], see `contact_age`.

    @cached_property
    def speed(self) -> Array:
        """Speed at which the wheel drives each bristle [m/s], shape (bristles,)."""
        return self.lever * abs(self.psi_dot)


@dataclass(frozen=True, kw_only=True, eq=False)
class RigHistory:
    """Response of the rig; all arrays of shape (n,)."""

    drive: RigDrive  # The drive at the sensor, before any effect changed it on its way to the patch.
    psi_patch: Array  # Angle of the patch [rad].
    M_z: Array  # Moment of the ground on the wheel about the kingpin [N m].
    sliding: Array  # Share of the bristles that slid during the step [1].


@dataclass(frozen=True, kw_only=True)
class MaxwellBranch:
    """Maxwell branch beside each bristle spring: stiffness gain k, relaxation time [s]."""

    gain: float = 0.0
    time: float = 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantedEffect:
    """Points where an effect acts on the rig; those left out change nothing."""

    half_width: float = 0.0  # Half-width of the patch [m]; zero is a line of bristles.
    span: float = 1.0  # Half-lengths over which there are bristles [1].
    # (load [N], declared half-length [m]) -> half-length of the patch over the declared one [1].
    growth: Callable[[float, float], float] = lambda _F_N, _a: 1.0
    # Factor on the parabolic pressure at xi = x/a [1].
    pressure: Callable[[Array], Array | float] = lambda _xi: 1.0
    relaxation: MaxwellBranch = MaxwellBranch()  # Branch beside each bristle spring.
    compliance: float = 0.0  # Torsional compliance in series with the patch [rad/(N m)].
    lost_motion: float = 0.0  # Play in series with the patch, from flank to flank [rad].
    # Factor on the friction limit during one step [1].
    friction: Callable[[BristleStep], Array | float] = lambda _step: 1.0
    # Growth c >= 0 of the friction limit with the logarithm of a bristle's own speed [1].
    rate: float = 0.0
    # The drive that reaches the tyre, from the one at the sensor.
    drive: Callable[[RigDrive], RigDrive] = lambda drive: drive
    torque: Callable[[RigHistory], Array] = lambda history: history.M_z  # The torque channel [N m].
    # Whether `torque` is the sensor's, which sees what all others make of it, so that it comes last.
    in_sensor: bool = False


def by_name(*effects: Callable[..., PlantedEffect]) -> dict[str, Callable[..., PlantedEffect]]:
    """Effects by the names of their functions."""
    return {effect.__name__: effect for effect in effects}
