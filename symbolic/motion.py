"""The wheel with its inertia under a steering torque: J_A psi'' = -b_t psi' + M_z + M.

Source (2.14) with the sign that its (2.3) gives M_z. Between turning points the patch is a smooth
function of the angle (`symbolic.turning`), so an adaptive Runge-Kutta step of fifth order is exact to
its tolerance. A step ends where the torque has a corner, where the wheel turns back, and where a loop
closes: there the next branch begins.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import inf, sqrt

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK45
from scipy.optimize import brentq

from symbolic.compiled import compiled
from symbolic.deformation import full_slide_torque, unit_moment
from symbolic.errors import InvalidInputError
from symbolic.parameters import Rig, Tyre
from symbolic.turning import TurningPoints, branch_torque, declared_friction
from symbolic.zones import REST

Array = NDArray[np.float64]
LONGEST = 0.5
"""Longest step in periods of the sticking wheel [1]; a shorter swing cannot hide in it."""
ROUNDING = 1e-12
"""Share of the longest step that two events may lie apart without being told apart [1]."""
CONSTANTS = ("F_N", "mu", "k", "a", "e", "J_A", "b_t")
"""Order of the constants of a motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueProfile:
    """A steering torque that is linear between its corners and constant after the last.

    Attributes:
        t: times of the corners, increasing from 0, shape (n,) [s].
        M: steering torque at the corners, shape (n,) [N m].

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

    def at(self, t: Array) -> Array:
        """Steering torque at times [s], same shape [N m]."""
        return np.interp(t, self.t, self.M)


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """What the wheel did; arrays of shape (n,).

    Attributes:
        t: time [s].
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s].
        M_z: moment of the ground on the wheel [N m], negative for a positive turn from rest.
        M: steering torque [N m].
        memory: what the patch remembered at each of them.
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
    def zones(self) -> NDArray[np.int64]:
        """Number of zones of the deformation, shape (n,): 1 until the wheel has turned."""
        count = np.array([memory.zones for memory in self.memory])
        return np.where((count == 3) & (self.psi == 0), 1, count)


@dataclass(frozen=True, kw_only=True, slots=True)
class _State:
    """The wheel between two steps: time, angle, rate and acceleration, memory and way of turning.

    `sure` is False right after the way was found to be wrong, so that rounding at rest cannot turn it
    for ever.
    """

    t: float
    psi: float
    psi_dot: float
    acceleration: float
    memory: TurningPoints
    way: float
    sure: bool = True


def simulate_motion(
    rig: Rig,
    tyre: Tyre,
    profile: TorqueProfile,
    load: float,
    *,
    duration: float | None = None,
    rate: float = 1000.0,
    tolerance: float = 1e-7,
) -> Motion:
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
    constants = _constants(rig, tyre, load)
    for name, value in (("duration", duration), ("rate", rate), ("tolerance", tolerance)):
        if not 0 < value < inf:
            raise InvalidInputError(f"{name} must be a finite number greater than 0, got {value:g}")
    stepper = _Stepper(constants, tolerance)
    states = list(_integrate(stepper, profile, duration))
    t = np.arange(int(duration * rate * (1 + 1e-12)) + 1) / rate
    return _sampled(states, np.minimum(t, duration), profile, stepper)


def _constants(rig: Rig, tyre: Tyre, load: float) -> dict[str, float]:
    if not 0 < load < inf:
        raise InvalidInputError(f"the load must be a finite number greater than 0 N, got {load:g}")
    if rig.J_A is None or rig.b_t is None:
        raise InvalidInputError("a motion needs the rig's J_A and b_t, got none")
    values = (load, declared_friction(tyre), tyre.k, rig.a, rig.e, rig.J_A, rig.b_t)
    return dict(zip(CONSTANTS, values, strict=True))


class _Stepper:
    """The compiled step on buffers of its own, and the scales that its error is held against."""

    def __init__(self, constants: dict[str, float], tolerance: float) -> None:
        a, e, J_A = (constants[name] for name in ("a", "e", "J_A"))
        stiffness = constants["k"] * float(unit_moment(0.0, a, e))
        slide = constants["mu"] * float(full_slide_torque(constants["F_N"], a)) / stiffness
        omega = sqrt(stiffness / J_A)
        self.longest = LONGEST / omega * 2 * np.pi
        scales = [tolerance * slide, tolerance * slide * omega]
        self.given, self.made = np.zeros(8), np.zeros(5)
        self.patch = np.array(list(constants.values())[:5])
        self._held = np.array([*constants.values(), *scales])
        self._buffer, self._call = _step_function().buffer()
        for i, array in enumerate((self.given, self._held)):
            self._buffer.set_arg(i, memoryview(array.data))  # type: ignore[call-arg]
        self._buffer.set_res(0, memoryview(self.made.data))  # type: ignore[call-arg]

    def begin(self, state: _State, M: float, M_dot: float) -> None:
        """Set the state, the branch and the steering torque [N m] with its slope [N m/s]."""
        self.given[:7] = (state.psi, state.psi_dot, *state.memory.branch, M, M_dot)

    def take(self, h: float) -> list[float]:
        """psi, psi_dot, acceleration and M_z a time h [s] later, and the error over the tolerance."""
        self.given[7] = h
        self._call()
        made: list[float] = self.made.tolist()
        return made


@cache
def _step_function() -> ca.Function:
    """One step of Dormand and Prince as a compiled Function."""
    given, held = ca.SX.sym("given", 8), ca.SX.sym("held", len(CONSTANTS) + 2)
    state, branch, M, M_dot, h = given[:2], given[2:5], given[5], given[6], given[7]
    *patch, J_A, b_t, psi_scale, rate_scale = ca.vertsplit(held)

    def slope(x: ca.SX, after: ca.SX) -> tuple[ca.SX, ca.SX]:
        M_z = branch_torque(x[0], branch, *patch)
        return ca.vertcat(x[1], (M + M_dot * after + M_z - b_t * x[1]) / J_A), M_z

    stages = [slope(state, ca.SX(0))[0]]
    for node, row in zip(RK45.C[1:], RK45.A[1:], strict=True):
        increment = sum(float(weight) * k for weight, k in zip(row, stages, strict=False))
        stages.append(slope(state + h * increment, node * h)[0])
    end = state + h * sum(float(weight) * k for weight, k in zip(RK45.B, stages, strict=True))
    last, M_z = slope(end, h)
    error = h * sum(float(weight) * k for weight, k in zip(RK45.E, [*stages, last], strict=True))
    over = ca.fmax(ca.fabs(error[0]) / psi_scale, ca.fabs(error[1]) / rate_scale)
    made = ca.vertcat(end, last[1], M_z, over)
    return compiled(ca.Function("motion_step", [given, held], [made], ["given", "held"], ["made"]))


def _integrate(stepper: _Stepper, profile: TorqueProfile, duration: float) -> Iterator[_State]:
    """The states at the ends of all steps, the first at time 0."""
    corners = np.union1d([t for t in profile.t if t < duration], [duration])
    torques = profile.at(corners)
    state = _at_rest(stepper, torques)
    yield state
    h = 1e-2 * stepper.longest
    for (begin, end), (M_begin, M_end) in zip(pairwise(corners), pairwise(torques), strict=True):
        M_dot = (M_end - M_begin) / (end - begin)
        while state.t < end:
            stepper.begin(state, M_begin + M_dot * (state.t - begin), M_dot)
            h = min(h, stepper.longest)
            ends = h >= end - state.t
            tried = end - state.t if ends else h
            over = stepper.take(tried)[4]
            # The fifth root, with some room, and no more than a factor of five at a time.
            h = tried * min(5.0, max(0.2, 0.9 * max(over, 1e-9) ** -0.2))
            if over > 1:
                continue
            length, after = _until_event(stepper, state, tried)
            at = end if ends and length == tried else state.t + length
            state = replace(after, t=at)
            yield state


def _at_rest(stepper: _Stepper, torques: Array) -> _State:
    """The wheel at rest on a virgin patch, about to go the way that the torque pulls."""
    pull = next((M for M in torques if M), 1.0)
    state = _State(
        t=0.0, psi=0.0, psi_dot=0.0, acceleration=0.0, memory=TurningPoints(), way=float(np.sign(pull))
    )
    stepper.begin(state, torques[0], 0.0)
    return replace(state, acceleration=stepper.take(0.0)[2])


def _until_event(stepper: _Stepper, state: _State, h: float) -> tuple[float, _State]:
    """The step up to h [s], or up to the first turn back or closing loop before; its length and end."""
    way, memory = state.way, state.memory
    end = stepper.take(h)
    turns = _turning_time(stepper, state, end, h) if state.sure else None
    if turns == 0:
        # The last turn back came to nothing: the wheel goes on as before it.
        return 0.0, replace(state, memory=memory.undone(), way=-way, sure=False)
    if turns:
        h, end = turns, stepper.take(turns)
    closes = way * (end[0] - memory.closes_at) > 0
    if closes:
        h = _closing_time(stepper, state, h)
        end = stepper.take(h)
    psi, psi_dot, acceleration, M_z, _ = end
    if closes:
        memory = memory.closed()
    elif turns:
        moved = abs(psi - memory.psi[-1]) > REST
        psi_dot, way = 0.0, -way
        memory = memory.turned_back(psi, M_z) if moved else memory.undone()
    after = replace(
        state, psi=psi, psi_dot=psi_dot, acceleration=acceleration, memory=memory, way=way, sure=True
    )
    return h, after


def _turning_time(stepper: _Stepper, state: _State, end: list[float], h: float) -> float | None:
    """When the wheel turns back within a step [s]; None where it does not, 0 where it never set out."""
    way, late = state.way, h
    if way * end[1] >= 0:
        if not way * state.acceleration < 0 < way * end[2]:
            return None
        # The rate has a least value inside; the wheel may have turned to and fro.
        late = brentq(lambda s: stepper.take(s)[2], 0.0, h)
        if way * stepper.take(late)[1] >= 0:
            return None
    early = 0.0
    if way * state.psi_dot <= 0:
        early = 0.5 * late
        while way * stepper.take(early)[1] <= 0:
            early *= 0.5
            if early < ROUNDING * stepper.longest:
                return 0.0
    return float(brentq(lambda s: stepper.take(s)[1], early, late, xtol=ROUNDING * stepper.longest))


def _closing_time(stepper: _Stepper, state: _State, h: float) -> float:
    """When the present loop closes within a step [s]."""
    goal = state.memory.closes_at
    if state.way * (goal - state.psi) <= 0:
        return 0.0
    return float(brentq(lambda s: stepper.take(s)[0] - goal, 0.0, h, xtol=ROUNDING * stepper.longest))


def _sampled(states: list[_State], t: Array, profile: TorqueProfile, stepper: _Stepper) -> Motion:
    """The motion at times [s]: quintic between the steps, and the patch exact at that angle."""
    ends = np.array([(state.t, state.psi, state.psi_dot, state.acceleration) for state in states])
    i = np.clip(np.searchsorted(ends[:, 0], t, side="right") - 1, 0, len(states) - 2)
    psi, psi_dot = _quintic(ends[i], ends[i + 1], t)
    branches = np.array([state.memory.branch for state in states]).T
    M_z = np.asarray(_sample_function()(psi[None, :], branches[:, i], stepper.patch)).ravel()
    return Motion(
        t=t,
        psi=psi,
        psi_dot=psi_dot,
        M_z=M_z,
        M=profile.at(t),
        memory=tuple(states[j].memory for j in i),
        steps=len(states) - 1,
    )


def _quintic(begin: Array, end: Array, t: Array) -> tuple[Array, Array]:
    """Angle and rate of the quintic through t, psi, psi_dot and psi'' at both ends, shape (n, 4) each."""
    h = end[:, 0] - begin[:, 0]
    s = (t - begin[:, 0]) / h
    psi, v, w = begin[:, 1], begin[:, 2] * h, 0.5 * begin[:, 3] * h * h
    rest = end[:, 1] - psi - v - w
    rest_v = end[:, 2] * h - v - 2 * w
    rest_w = 0.5 * end[:, 3] * h * h - w
    c3 = 10 * rest - 4 * rest_v + rest_w
    c4 = -15 * rest + 7 * rest_v - 2 * rest_w
    c5 = 6 * rest - 3 * rest_v + rest_w
    angle = psi + s * (v + s * (w + s * (c3 + s * (c4 + s * c5))))
    rate = (v + s * (2 * w + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h
    return angle, rate


@cache
def _sample_function() -> ca.Function:
    psi, branch, patch = ca.SX.sym("psi"), ca.SX.sym("branch", 3), ca.SX.sym("patch", 5)
    M_z = branch_torque(psi, branch, *ca.vertsplit(patch))
    return ca.Function("sample", [psi, branch, patch], [M_z], ["psi", "branch", "patch"], ["M_z"])
