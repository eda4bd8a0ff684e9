"""Implausible values of the sensors, beyond the limits of `Tuning`, are left out sample by sample.

Such a value is missing, and the status of the sample has `Status.IMPLAUSIBLE`. An angle that jumps and
stays, each sample near the one before, is that of a sensor whose zero has moved, as after a restart or a
full turn: the wheel itself cannot jump. The jump is taken off all later angles, so that the patch keeps
its history. After a time without an angle the wheel may have turned as far as the rate allows.
"""

from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.compiled_step import compiled_stretch, run_stretches
from observers.layout import Expression, Layout, Parts, named, symbols, vector_of
from observers.measurement.measurement_model import MIN_FIRST_LOAD
from observers.protocol import OUTPUT, SAMPLE, Status
from observers.quality.wrong_units_or_signs import EVIDENCE, build_implausibility_evidence
from observers.tuning import NO_LIMIT, PLAUSIBLE
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import named_function

SLACK = 0.01
"""Change of the angle that any time allows: noise, steps of a sensor, an uneven clock [rad]."""
SCREEN = Layout.of(psi=1, age=1, offset=1, other=1, other_age=1, waiting=1, jump=1, implausible=1)
"""State of the check: last plausible angle, less the offset [rad], and its age [s], 0 if it is that of
the sample; offset of the sensor [rad]; last implausible angle, less the offset [rad], and its age [s];
time for which such angles have followed each other, -1 for none [s]; jump that began them [rad]; 1 where
a value of the sample is implausible."""


@cache
def build_input_screen() -> ca.Function:
    """(screen, sample, limits) -> (screen_next, sample_next), as in `SCREEN`, `SAMPLE`, `PLAUSIBLE`."""
    inputs = symbols(ca.SX, screen=SCREEN.size, sample=len(SAMPLE), limits=len(PLAUSIBLE))
    now, limit = named(SAMPLE, inputs["sample"]), named(PLAUSIBLE, inputs["limits"])
    after, psi = _screen_angle(named(SCREEN.places, inputs["screen"]), now, limit)
    passed, implausible = {**now, "psi": psi}, after["implausible"]
    bounds = {"psi_dot": "psi_rate_limit", "F_N": "F_N_limit"}
    bounds |= {"M_z": "torque_limit", "M": "torque_limit"}
    for name, bound in bounds.items():
        beyond = ca.logic_and(ca.fabs(now[name]) >= limit[bound], ca.fabs(now[name]) < NO_LIMIT)
        implausible = ca.logic_or(implausible, beyond)
        passed[name] = ca.if_else(beyond, float("nan"), now[name])
    outputs = {
        "screen_next": vector_of(SCREEN.places, {**after, "implausible": implausible}),
        "sample_next": vector_of(SAMPLE, passed),
    }
    return named_function("screen", inputs, outputs, cse=True)


def _screen_angle(before: Parts, now: Parts, limit: Parts) -> tuple[Parts, Expression]:
    """The state of the check after an angle, and that angle less the offset, NaN if it is left out."""
    psi, none = now["psi"] - before["offset"], ca.SX(float("nan"))
    age, other_age = before["age"] + now["dt"], before["other_age"] + now["dt"]
    inside = ca.fabs(now["psi"]) < limit["psi_limit"]
    turn, step = ca.fabs(psi - before["psi"]), ca.fabs(psi - before["other"])
    near_other = ca.logic_and(step <= SLACK + limit["psi_rate_limit"] * other_age, step < turn)
    follows = ca.logic_and(inside, ca.logic_and(before["waiting"] >= 0, near_other))
    near = ca.logic_and(turn <= SLACK + limit["psi_rate_limit"] * age, ca.logic_not(follows))
    near = ca.logic_and(inside, near)
    waiting = before["waiting"] + other_age
    # Half a step more, so that rounding does not decide.
    settled = ca.logic_and(follows, waiting + now["dt"] / 2 >= limit["rezero_time"])
    jumps = ca.logic_and(inside, ca.logic_not(ca.logic_or(follows, near)))
    out = ca.logic_and(inside, ca.logic_not(ca.logic_or(near, settled)))
    used = ca.if_else(near, psi, ca.if_else(settled, psi - before["jump"], none))
    taken = ca.logic_or(near, settled)
    far = ca.logic_and(ca.fabs(now["psi"]) < NO_LIMIT, ca.logic_not(inside))
    after = {
        "psi": ca.if_else(taken, used, before["psi"]),
        "age": ca.if_else(taken, 0, age),
        "offset": before["offset"] + ca.if_else(settled, before["jump"], 0),
        "other": ca.if_else(out, psi, before["other"]),
        "other_age": ca.if_else(out, 0, other_age),
        "waiting": ca.if_else(
            taken, -1, ca.if_else(jumps, 0, ca.if_else(follows, waiting, before["waiting"]))
        ),
        "jump": ca.if_else(jumps, psi - before["psi"], before["jump"]),
        "implausible": ca.logic_or(out, far),
    }
    return after, used


def initial_screen_state(psi: float) -> Array:
    """The state of the check at the first sample, whose angle is psi [rad]."""
    start = np.zeros(SCREEN.size)
    start[SCREEN.places["psi"][0]], start[SCREEN.places["waiting"][0]] = psi, -1.0
    return start


@cache
def build_screened_step(
    step: ca.Function, parts: Layout, limits: tuple[float, ...] | int, channel: str, a_at: int | None
) -> ca.Function:
    """A step (state, sample, constants) -> (state_next, output) of plausible samples alone.

    The parts of its state are followed by those of the check. `limits` are in the order of `PLAUSIBLE`,
    or the index of the first among the constants; `a_at` is the index of the half-length there, None
    where units and signs are not checked. So one step serves all limits and lengths.
    """
    checked = EVIDENCE.size if a_at is not None else 0
    # A user's own step need not name its inputs.
    inputs = symbols(
        ca.MX, state=parts.size + SCREEN.size + checked, sample=len(SAMPLE), constants=step.numel_in(2)
    )
    state, sample, constants = inputs.values()
    places = [0, parts.size, parts.size + SCREEN.size, state.shape[0]]
    own, screen, evidence = ca.vertsplit(state, places)
    suspect = ca.MX(0)
    if a_at is not None:
        evidence, suspect = build_implausibility_evidence(channel)(evidence, sample, constants[a_at])
    if isinstance(limits, int):
        bounds = ca.fmin(constants[limits : limits + len(PLAUSIBLE)], NO_LIMIT)
    else:
        bounds = ca.MX(ca.DM(limits))
    screen, passed = build_input_screen()(screen, sample, bounds)
    after, output = step(own, passed, constants)
    at = OUTPUT.index("status")
    status = with_flag(output[at], Status.SUSPECT, suspect)
    status = status + int(Status.IMPLAUSIBLE) * screen[SCREEN.places["implausible"][0]]
    output[at] = status
    after[parts.places["output"][0].start + at] = status
    outputs = {"state_next": ca.vertcat(after, screen, evidence), "output": output}
    return named_function(step.name(), inputs, outputs)


def has_flag(status: Expression, flag: Status) -> Expression:
    """Whether a status, as a number, has a flag: 0 or 1; by comparisons, which cost a target nothing."""
    rest = status
    for higher in sorted((int(each) for each in Status if each > flag), reverse=True):
        rest = ca.if_else(rest >= higher, rest - higher, rest)
    return rest >= int(flag)


def with_flag(status: Expression, flag: Status, holds: Expression) -> Expression:
    """The status with a flag, where it holds and is not set yet."""
    return status + int(flag) * ca.logic_and(holds, ca.logic_not(has_flag(status, flag)))


def plausible_angles(samples: Array, limits: tuple[float, ...]) -> Array:
    """The angles that pass, (n,) [rad], NaN for others, of samples (6, n) from a usable one on."""
    stretch = compiled_stretch(build_input_screen())
    start = initial_screen_state(samples[0, 0])
    states = run_stretches(stretch, start, samples, np.array(limits), result=0)
    psi, age = (states[SCREEN.places[name][0]].ravel() for name in ("psi", "age"))
    return np.where(age == 0, psi, np.nan)


def beyond_limits(samples: Array, limits: tuple[float, ...]) -> NDArray[np.bool_]:
    """Mask (n,) of the samples (6, n) with a value at or beyond its limit, the rate of psi excepted."""
    psi_limit, rate_limit, F_N_limit, torque_limit, _ = limits
    bounds = np.array([psi_limit, rate_limit, F_N_limit, NO_LIMIT, torque_limit, torque_limit])
    sizes = np.abs(samples)
    return np.asarray(((sizes >= bounds[:, None]) & (sizes < NO_LIMIT)).any(axis=0))


def sample_limits_of(observer: object) -> tuple[float, ...]:
    """The limits of an observer's samples; beyond any value for one that does not screen them."""
    limits: tuple[float, ...] = getattr(observer, "sample_limits", (NO_LIMIT,) * len(PLAUSIBLE))
    return limits


def is_plausible_first_sample(observer: object, psi: float, F_N: float) -> bool:
    """True where angle [rad] and load [N] can be those of a first sample."""
    psi_limit, _, F_N_limit, *_ = sample_limits_of(observer)
    return abs(psi) < psi_limit and MIN_FIRST_LOAD <= F_N < F_N_limit
