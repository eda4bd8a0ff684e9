"""Slip of bristles in one sample, also where friction rises with their own sliding speed.

Without such a law slip takes off what exceeds the limit: the elastoplastic stop, [Györök 2022], (2.16).
With it, s = v dt is the slip at which stress and friction balance,

    |stress| - (1 + g) s = limit (1 + c ln(max(v, v_0) / v_ref)),

with g the gain of a Maxwell branch (`branch_gain`). So a bristle that is no longer driven does not lose
its stress in an instant when the wheel stops; it creeps on, ever slower, until it comes to rest at v_0.
In w = ln v the balance is a convex, rising function, and Halley's method comes to its root from above:
from the lesser of two bounds, one without the logarithm and one without the slip.
"""

from collections.abc import Callable, Sequence
from functools import cache

import casadi as ca
import numpy as np

from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression

REFERENCE_SPEED = 1e-3
"""Sliding speed at which the factor on the limit is one [m/s]."""
REST_SPEED = 1e-4
"""Sliding speed below which the limit is constant, so that creep ends [m/s]."""
_MIN_LOG_SPEED, _REFERENCE_LOG_SPEED = float(np.log(REST_SPEED)), float(np.log(REFERENCE_SPEED))
_STEPS = 3
"""Halley's steps: with the one of Newton that is differentiated, the slip is right to rounding."""
_TINY = 1e-30
"""Keeps a bound finite where friction does not depend on speed [1]."""
BristleSlipSolver = Callable[..., Sequence[Expression]]
"""(size, limit, branch_gain, reach, c) -> results of `bristle_slip_solver`."""


def slip(
    stress: Expression,
    limit: Expression,
    branch_gain: Expression,
    slip_per_speed: Expression,
    log_speed_gain: Expression | None,
    solver: BristleSlipSolver | None = None,
) -> Expression:
    """Slip that brings every bristle back to the friction limit, in the unit of stress and limit, (n,).

    The limit is that at the reference speed where it grows by log_speed_gain, c >= 0 [1], with the log
    of the sliding speed; None is the plain stop. branch_gain is the stiffness of the Maxwell branch in
    shares of the spring's, slip_per_speed the slip of one sample at 1 m/s. `solver` takes the place of
    `bristle_slip_solver`. With c, first derivatives are exact and second derivatives are wrong.
    """
    if log_speed_gain is None:
        return (stress - clipped(stress, limit)) / (1 + branch_gain)
    size = ca.fabs(stress)
    c, solve = log_speed_gain, solver or bristle_slip_solver(int(stress.numel()))
    found = solve(size, limit, branch_gain, slip_per_speed, c)
    slipped, level, moving, yielding = found
    # The search is not differentiated. `beyond` is zero there; its derivative is the correction of the
    # implicit function theorem.
    log_speed = level - moving * ca.log(slip_per_speed)
    beyond = (1 + branch_gain) * slipped + limit * (1 + c * (log_speed - _REFERENCE_LOG_SPEED)) - size
    return ca.sign(stress) * (slipped - yielding * beyond)


def log_creep_factor(speed: Expression, c: Expression) -> Expression:
    """Factor on the limit of a bristle that slides at a steady speed [m/s], >= 0."""
    return 1 + c * (ca.log(ca.fmax(speed, REST_SPEED)) - _REFERENCE_LOG_SPEED)


def clipped(value: Expression, limit: Expression) -> Expression:
    """The elastoplastic stop, [Györök 2022], (2.16)."""
    return ca.fmax(-limit, ca.fmin(limit, value))


@cache
def bristle_slip_solver(bristles: int) -> ca.Function:
    """The search for the slip of so many bristles, with named inputs and outputs.

    level is ln(slip) where a bristle is moving (1) and ln v_0 where it is not (0); yielding is the
    slip by stress beyond friction, zero where the bristle sticks.
    """
    inputs = _solver_inputs(bristles)
    found = solver_outputs_at_log_speed(bristles)(
        *inputs.values(), log_speed_search(bristles)(*inputs.values())
    )
    outputs = dict(zip(("slip", "level", "moving", "yielding"), found, strict=True))
    return named_function("bristle_slip_solver", inputs, outputs, is_diff_out=[False] * len(outputs))


@cache
def log_speed_search(bristles: int, steps: int = _STEPS) -> ca.Function:
    """The logarithm w of the sliding speed of bristles that move, by the inputs of the solver.

    After two steps the slip, with the one of Newton, is right to 2e-10 of the stress.
    """
    inputs = _solver_inputs(bristles)
    size, limit, branch_gain, reach, c = inputs.values()
    growth = limit * c
    excess = size - limit + growth * _REFERENCE_LOG_SPEED
    at_rest = _slip_to_rest_limit(size, limit, branch_gain, c)
    w = ca.fmin(ca.log(ca.fmax(at_rest / reach, REST_SPEED)), excess / ca.fmax(growth, _TINY))
    for _ in range(steps):
        w = ca.fmax(w, _MIN_LOG_SPEED)
        relieved = (1 + branch_gain) * reach * ca.exp(w)
        beyond, slope = relieved + growth * w - excess, relieved + growth
        # Above the root beyond is at most what slip relieves; below, where it does not matter, no pole.
        w = w - 2 * beyond * slope / (2 * slope**2 - ca.fmin(beyond, relieved) * relieved)
    return named_function("log_speed_search", inputs, {"log_speed": ca.fmax(w, _MIN_LOG_SPEED)})


@cache
def solver_outputs_at_log_speed(bristles: int) -> ca.Function:
    """The outputs of `bristle_slip_solver`, by its inputs and w."""
    inputs, w = _solver_inputs(bristles), ca.MX.sym("log_speed", bristles)
    size, limit, branch_gain, reach, c = inputs.values()
    at_rest = _slip_to_rest_limit(size, limit, branch_gain, c)
    moving = at_rest > reach * REST_SPEED
    slipped = reach * ca.exp(w)
    relief = slipped / ((1 + branch_gain) * slipped + limit * c)
    outputs = {
        "slip": ca.if_else(moving, slipped, at_rest),
        "level": ca.if_else(moving, w + ca.log(reach), _MIN_LOG_SPEED),
        "moving": moving,
        "yielding": ca.if_else(moving, relief, (at_rest > 0) / (1 + branch_gain)),
    }
    return named_function("slip_at_log_speed", {**inputs, "log_speed": w}, outputs)


def _solver_inputs(bristles: int) -> dict[str, ca.MX]:
    vectors = {name: ca.MX.sym(name, bristles) for name in ("size", "limit")}
    return vectors | {name: ca.MX.sym(name) for name in ("branch_gain", "reach", "c")}


def _slip_to_rest_limit(size: ca.MX, limit: ca.MX, branch_gain: ca.MX, c: ca.MX) -> ca.MX:
    """Slip down to the limit of a bristle that does not move."""
    limit_at_rest = limit * (1 + c * (_MIN_LOG_SPEED - _REFERENCE_LOG_SPEED))
    return ca.fmax(0, size - limit_at_rest) / (1 + branch_gain)
