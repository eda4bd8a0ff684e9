"""The wheel with its inertia under a steering torque: J_A psi'' = -b_t psi' + M_z + M.

[Györök 2022], (2.14), with the sign of M_z of its (2.3). The patch is exact, and so are the instants at
which the wheel turns back (`symbolic.wheel_integrator`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbolic.errors import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.masing import TurningPoints, require_mu
from symbolic.rig_and_tyre import Rig, Tyre, require_positive
from symbolic.wheel_integrator import (
    CONSTANTS,
    WheelState,
    WheelStepper,
    branch_torques,
    integrate_wheel,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueProfile:
    """A steering torque that is linear between its breakpoints and constant after the last.

    Attributes:
        t: times of the breakpoints, increasing from 0, shape (n,) [s].
        M: steering torque at the breakpoints, shape (n,) [N m].

    Raises:
        InvalidInputError: shapes differ, a number is not finite, or the times do not increase from 0.
    """

    t: tuple[float, ...]
    M: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check shapes and order."""
        if len(self.t) != len(self.M) or not self.t:
            raise InvalidInputError(
                f"a torque profile needs as many torques as times, got {len(self.M)} and {len(self.t)}"
            )
        if not np.all(np.isfinite([*self.t, *self.M])):
            raise InvalidInputError("times and torques of a profile must be finite")
        if self.t[0] != 0 or np.any(np.diff(self.t) <= 0):
            raise InvalidInputError(f"times of a torque profile must increase from 0 s, got {self.t}")

    def torque_at(self, t: Array) -> Array:
        """Steering torque at times [s], same shape [N m]."""
        return np.interp(t, self.t, self.M)

    def breakpoints(self, duration: float) -> Array:
        """Times of the breakpoints before the end of a motion, and that end [s]."""
        return np.array([*(t for t in self.t if t < duration), duration])


@dataclass(frozen=True, kw_only=True, eq=False)
class WheelMotion:
    """Motion of the wheel; arrays of shape (n,).

    Attributes:
        t: time [s].
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s].
        M_z: moment of the ground on the wheel [N m], negative for a positive turn from rest.
        M: steering torque [N m].
        memory: turning points of the patch at each sample.
        steps: accepted steps of the integration.
    """

    t: Array
    psi: Array
    psi_dot: Array
    M_z: Array
    M: Array
    memory: tuple[TurningPoints, ...]
    steps: int

    @property
    def zone_count(self) -> NDArray[np.int64]:
        """Number of zones of the deformation, shape (n,): 1 until the wheel has turned."""
        count = np.array([memory.zone_count for memory in self.memory])
        return np.where((count == 3) & (self.psi == 0), 1, count)


def simulate_motion(
    rig: Rig,
    tyre: Tyre,
    profile: TorqueProfile,
    load: float,
    *,
    duration: float | None = None,
    rate: float = 1000.0,
    tolerance: float = 1e-7,
) -> WheelMotion:
    """Turn a wheel that stands on a virgin patch by a steering torque.

    Args:
        rig: a, e, J_A and b_t.
        tyre: k and mu.
        profile: the steering torque.
        load: vertical load [N], constant.
        duration: length [s]; None for the profile's.
        rate: samples a second of the result [Hz]; the steps do not depend on it.
        tolerance: error of one step over the angle and the rate at which the patch slides [1].

    Raises:
        InvalidInputError: a parameter is missing or a number is out of range.
    """
    duration = profile.t[-1] if duration is None else duration
    constants = _motion_constants(rig, tyre, load)
    for name, value in (("duration", duration), ("rate", rate), ("tolerance", tolerance)):
        require_positive(name, value)
    stepper = WheelStepper(constants, tolerance)
    states = list(integrate_wheel(stepper, profile.torque_at, profile.breakpoints(duration)))
    t = np.arange(int(duration * rate * (1 + 1e-12)) + 1) / rate
    return _sample_motion(states, np.minimum(t, duration), profile, stepper)


def _motion_constants(rig: Rig, tyre: Tyre, load: float) -> dict[str, float]:
    require_positive("the load", load, "N")
    if rig.J_A is None or rig.b_t is None:
        raise InvalidInputError("a motion needs the rig's J_A and b_t, got none")
    values = (load, require_mu(tyre), tyre.k, rig.a, rig.e, rig.J_A, rig.b_t)
    return dict(zip(CONSTANTS, values, strict=True))


def _sample_motion(
    states: list[WheelState], t: Array, profile: TorqueProfile, stepper: WheelStepper
) -> WheelMotion:
    """The motion at times [s]: quintic between the steps, and the patch exact at that angle."""
    ends = np.array([state[:4] for state in states])
    i = np.clip(np.searchsorted(ends[:, 0], t, side="right") - 1, 0, len(states) - 2)
    # A step of no length has its quintic too, but no time lies in it.
    c0, c1, c2, c3, c4, c5 = _quintic_coefficients(ends)[:, i]
    h = ends[i + 1, 0] - ends[i, 0]
    s = (t - ends[i, 0]) / h
    psi = c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    psi_dot = (c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h
    branches = np.array([state.memory.branch for state in states])
    return WheelMotion(
        t=t,
        psi=psi,
        psi_dot=psi_dot,
        M_z=branch_torques(psi, branches[i], stepper.patch),
        M=profile.torque_at(t),
        memory=tuple([states[j].memory for j in i.tolist()]),
        steps=len(states) - 1,
    )


def _quintic_coefficients(ends: Array) -> Array:
    """Coefficients over the share of each step, constant first, (6, steps), by t, psi, psi', psi''."""
    h = np.diff(ends[:, 0])
    psi, rate, bend = ends[:, 1], ends[:, 2], 0.5 * ends[:, 3]
    v, w = rate[:-1] * h, bend[:-1] * h * h
    # What the end lacks in angle, rate and half the acceleration after these three.
    lacks = np.diff(psi) - v - w
    lacks_v = rate[1:] * h - v - 2 * w
    lacks_w = bend[1:] * h * h - w
    c3 = 10 * lacks - 4 * lacks_v + lacks_w
    c4 = -15 * lacks + 7 * lacks_v - 2 * lacks_w
    c5 = 6 * lacks - 3 * lacks_v + lacks_w
    return np.array([psi[:-1], v, w, c3, c4, c5])
