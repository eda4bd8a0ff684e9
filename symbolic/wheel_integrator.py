"""The steps of a wheel under a steering torque, each on one branch of the patch.

Between turning points the patch is a smooth function of the angle (`symbolic.masing`), so an adaptive
Runge-Kutta step of fifth order (Dormand and Prince) is exact to its tolerance. A step ends where the
steering torque has a corner, where the wheel turns back and where a loop closes: there the next branch
begins.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from itertools import pairwise
from math import copysign, pi, sqrt
from typing import NamedTuple

import casadi as ca
import numpy as np

from symbolic.compilation.compiled_function_cache import compiled
from symbolic.exact_zone_patch import MIN_ZONE_TURN
from symbolic.float_array_type import Array
from symbolic.masing import TurningPoints, branch_torque
from symbolic.named_and_buffered_functions import BufferedCall, named_function
from symbolic.patch_moment_by_zones import full_slide_torque, unit_corner_moment

MAX_STEP_PERIODS = 0.5
"""Longest step in periods of the sticking wheel [1]; no full swing passes within one step."""
ROUNDING = 1e-12
"""Resolution of the times of events, in shares of the longest step [1]."""
CONSTANTS = ("F_N", "mu", "k", "a", "e", "J_A", "b_t")
"""Order of the constants of a motion."""


class WheelState(NamedTuple):
    """The wheel between two steps: time, angle, rate and acceleration, memory and direction of turning.

    `sure` is False right after the direction was corrected, so that rounding at rest cannot turn it
    for ever.
    """

    t: float
    psi: float
    psi_dot: float
    acceleration: float
    memory: TurningPoints
    direction: float
    sure: bool = True


class WheelStepper:
    """The compiled step on buffers of its own, and the scales of its error."""

    def __init__(self, constants: Mapping[str, float], tolerance: float) -> None:
        """Take the constants in the order of `CONSTANTS`, and the error that one step may have [1]."""
        a, e, J_A = (constants[name] for name in ("a", "e", "J_A"))
        stiffness = constants["k"] * float(unit_corner_moment(0.0, a, e))
        slide = constants["mu"] * float(full_slide_torque(constants["F_N"], a)) / stiffness
        omega = sqrt(stiffness / J_A)
        self.longest = MAX_STEP_PERIODS * 2 * pi / omega
        scales = [tolerance * slide, tolerance * slide * omega]
        self.patch = np.array(list(constants.values())[:5])
        self._step = BufferedCall(_runge_kutta_step_function())
        self._step.inputs[1][:] = [*constants.values(), *scales]
        # Views take single numbers in a third of an array's time.
        self._inputs, self._outputs = (
            memoryview(array.data).cast("B").cast("d")
            for array in (self._step.inputs[0], self._step.outputs[0])
        )

    def set_state_and_torque(self, state: WheelState, M: float, M_dot: float) -> None:
        """Set the state, the branch and the steering torque [N m] with its slope [N m/s]."""
        inputs = self._inputs
        inputs[0], inputs[1], inputs[5], inputs[6] = state.psi, state.psi_dot, M, M_dot
        inputs[2], inputs[3], inputs[4] = state.memory.branch

    def evaluate_step(self, h: float) -> list[float]:
        """psi, psi_dot, acceleration and M_z a time h [s] later, and the error over the tolerance."""
        self._inputs[7] = h
        self._step.call()
        return list(self._outputs)


@cache
def _runge_kutta_step_function() -> ca.Function:
    # Here, not above: scipy takes as long to load as all the rest, and few who load this move a wheel.
    from scipy.integrate import RK45

    inputs, constants = ca.SX.sym("inputs", 8), ca.SX.sym("constants", len(CONSTANTS) + 2)
    state, branch, M, M_dot, h = inputs[:2], inputs[2:5], inputs[5], inputs[6], inputs[7]
    *patch, J_A, b_t, psi_scale, rate_scale = ca.vertsplit(constants)

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
    outputs = ca.vertcat(end, last[1], M_z, over)
    given = {"inputs": inputs, "constants": constants}
    return compiled(named_function("motion_step", given, {"outputs": outputs}))


def integrate_wheel(
    stepper: WheelStepper, torque_at: Callable[[Array], Array], breakpoints: Array
) -> Iterator[WheelState]:
    """The states at the ends of all steps, the first at time 0."""
    # As plain numbers: NumPy's would double the time of a step.
    times, torques = breakpoints.tolist(), torque_at(breakpoints).tolist()
    state = _initial_wheel_state(stepper, torques)
    yield state
    h = 1e-2 * stepper.longest
    for (begin, end), (M_begin, M_end) in zip(pairwise(times), pairwise(torques), strict=True):
        M_dot = (M_end - M_begin) / (end - begin)
        while state.t < end:
            stepper.set_state_and_torque(state, M_begin + M_dot * (state.t - begin), M_dot)
            h = min(h, stepper.longest)
            ends = h >= end - state.t
            tried = end - state.t if ends else h
            ending = stepper.evaluate_step(tried)
            over = ending[4]
            # The fifth root, with some room, and no more than a factor of five at a time.
            h = tried * min(5.0, max(0.2, 0.9 * max(over, 1e-9) ** -0.2))
            if over > 1:
                continue
            length, after = _step_to_event(stepper, state, tried, ending)
            at = end if ends and length == tried else state.t + length
            state = after._replace(t=at)
            yield state


def _initial_wheel_state(stepper: WheelStepper, torques: list[float]) -> WheelState:
    """The wheel at rest on a virgin patch, about to turn in the direction of the torque."""
    pull = next((M for M in torques if M), 1.0)
    state = WheelState(
        t=0.0, psi=0.0, psi_dot=0.0, acceleration=0.0, memory=TurningPoints(),
        direction=copysign(1.0, pull),
    )  # fmt: skip
    stepper.set_state_and_torque(state, torques[0], 0.0)
    return state._replace(acceleration=stepper.evaluate_step(0.0)[2])


def _step_to_event(
    stepper: WheelStepper, state: WheelState, h: float, end: list[float]
) -> tuple[float, WheelState]:
    """The step up to h [s], or up to the first turn back or closing loop before; its length and end."""
    direction, memory = state.direction, state.memory
    turns = _reversal_time(stepper, state, end, h) if state.sure else None
    if turns == 0:
        # The last turn back came to nothing: the wheel goes on as before it.
        return 0.0, state._replace(memory=memory.without_last_point(), direction=-direction, sure=False)
    if turns:
        h, end = turns, stepper.evaluate_step(turns)
    closes = direction * (end[0] - memory.loop_closing_angle) > 0
    if closes:
        h = _loop_closure_time(stepper, state, h)
        end = stepper.evaluate_step(h)
    psi, psi_dot, acceleration, M_z, _ = end
    if closes:
        memory = memory.without_closed_loop()
    elif turns:
        has_turned = abs(psi - memory.psi[-1]) > MIN_ZONE_TURN
        psi_dot, direction = 0.0, -direction
        memory = memory.with_new_point(psi, M_z) if has_turned else memory.without_last_point()
    return h, WheelState(state.t, psi, psi_dot, acceleration, memory, direction)


def _reversal_time(stepper: WheelStepper, state: WheelState, end: list[float], h: float) -> float | None:
    """Time of a turn back within a step [s]; None for none, 0 where the wheel has not moved off."""
    from scipy.optimize import brentq

    direction, late = state.direction, h
    if direction * end[1] >= 0:
        if direction * end[2] <= 0 or direction * stepper.evaluate_step(0.0)[2] >= 0:
            return None
        # The rate has a least value inside; the wheel may have turned to and fro.
        late = brentq(lambda s: stepper.evaluate_step(s)[2], 0.0, h)
        if direction * stepper.evaluate_step(late)[1] >= 0:
            return None
    early = 0.0
    if direction * state.psi_dot <= 0:
        early = 0.5 * late
        while direction * stepper.evaluate_step(early)[1] <= 0:
            early *= 0.5
            if early < ROUNDING * stepper.longest:
                return 0.0
    return _crossing_time(stepper, 1, 0.0, early, late)


def _loop_closure_time(stepper: WheelStepper, state: WheelState, h: float) -> float:
    """Time within a step at which the present loop closes [s]."""
    goal = state.memory.loop_closing_angle
    if state.direction * (goal - state.psi) <= 0:
        return 0.0
    return _crossing_time(stepper, 0, goal, 0.0, h)


def _crossing_time(stepper: WheelStepper, i: int, goal: float, low: float, high: float) -> float:
    """Time at which psi (i = 0) or psi_dot (i = 1) passes a goal, by bracketed Newton steps [s]."""
    # The slope is the next entry of what a step makes, so this takes a third of Brent's calls.
    h, side = high, stepper.evaluate_step(high)[i] - goal
    while True:
        outputs = stepper.evaluate_step(h)
        off, slope = outputs[i] - goal, outputs[i + 1]
        if abs(off) <= ROUNDING * stepper.longest * abs(slope) or high - low <= ROUNDING * high:
            return h
        low, high = (low, h) if off * side > 0 else (h, high)
        newton = h - off / slope if slope else low
        h = newton if low < newton < high else 0.5 * (low + high)


def branch_torques(psi: Array, branches: Array, patch: Array) -> Array:
    """M_z at angles (n,) on their branches (n, 3), for the constants of the patch (5,)."""
    angle, branch = ca.SX.sym("angle"), ca.SX.sym("branch", 3)
    M_z = branch_torque(angle, branch, *patch.tolist())
    torques = ca.Function("branch_torque", [angle, branch], [M_z]).map(len(psi))
    return np.asarray(torques(psi.reshape(1, -1), branches.T)).ravel()
