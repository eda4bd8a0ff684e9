"""Which input looks wrong by its unit, its sign or its sensor: evidence gathered sample by sample.

What is suspected, and why, say `suspected_by_message` and `suspicions_from_state`. A few odd samples, as
a faulty sensor has them, are no evidence. What is suspected stays suspected. The check is part of the
step of every observer, in Python and in C; the status has `Status.SUSPECT`.
"""

import math
from collections.abc import Iterable
from functools import cache, reduce
from typing import Any

import casadi as ca
import numpy as np

from observers.compiled_step import compiled_stretch, run_stretches
from observers.layout import Expression, Layout, Parts, named, symbols, vector_of
from observers.measurement.torque_error import SENSIBLE, is_known
from observers.protocol import OUTPUT, SAMPLE, Sample, Status
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from symbolic import Rig, full_slide_torque
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import named_function
from symbolic.signal_plausibility_limits import (
    MAX_PLAUSIBLE_PERIOD,
    MAX_RETURNED_WORK,
    MAX_STEERING_ANGLE,
    MIN_SIGN_TRAVEL,
    MIN_WHEEL_LOAD,
)

MAX_TORQUE_RATIO = 15.0
"""Ratio of torque to that of full slide at mu = 1 which no ground reaches [1]."""
MAX_TYRE_FRICTION = 2.75
"""Friction coefficient of a tyre that no ground has [1]."""
LIFTED = 0.05
"""Share of the first load below which the wheel is lifted, and a torque beside it no evidence [1]."""
IN_A_ROW = 10
"""Samples in a row that make a suspicion."""
WORK_TRAVEL = 2.0
"""Turn in which work is forgotten [rad]."""
MAX_STRETCH = 0.05
"""Turn between two torques, with samples between, up to which the second does its work [rad]."""
FROZEN = 6
"""Samples in a row with the same torque that may be a frozen one."""
FROZEN_TRAVEL = 0.015
"""Turn for which a sliding patch does not give the same torque to the last digit [rad]."""
MIN_JUMP, MIN_DIGITS = 3e-3, 1.5
"""Change before a frozen torque that no patch near full slide shows: as a share of the torque, and over
the least change that the sensor resolves [1]."""
JUMP_LEFT = (0.7, 0.3)
"""Share of the change before that counts beside a change of the other sign, as noise makes them, and of
the same, as a torque that grows into full slide [1]: of a noisy torque the last change may be small."""
KNOWN_SCALE, OFF_SCALE = 0.1, 0.25
"""Standard deviation of ln s below which, and |ln s| beyond which a scale that is not verified, and why
friction is not acquired, is named [1]."""
CONVENTIONS = {
    "M_z": "M_z is the moment of the ground on the wheel, negative for a first turn to positive psi"
    " (left): flip M_z, or psi if that is positive to the right",
    "M": "M is the torque of the hand or motor on the wheel, positive for a first turn to positive psi"
    " (left): flip M, or psi if that is positive to the right",
}
"""What to flip, by the torque that is measured."""
EVIDENCE = Layout.of(
    angle=1, period=1, friction=1, load=1, first_load=1, psi=1, turn=1, travel=1, work=1, exchanged=1,
    torque=1, jump=1, digit=1, frozen=1, frozen_travel=1, clipped=1,
)  # fmt: skip
"""State of the check. Samples in a row, up to now, beyond what is possible, `IN_A_ROW` stays: angle,
period, friction. The last load and the first one [N], the last angle [rad], NaN before; the turn since
the last torque, and the turn so far between torques, without its sign [rad]; work of the ground on the
wheel, and the same with each torque without its sign [N m]. The last torque; its last change, with its
sign, no less than `JUMP_LEFT` of the one before, and the least one, 0 before [N m]; samples for which it
has been the same, and their turn [rad]; 1 once it was clipped."""
START = np.array([0.0, 0, 0, -1, -1, np.nan, 0, 0, 0, 0, np.nan, 0, 0, 0, 0, 0])
"""The state before the first sample; a load of -1 is none."""


@cache
def build_implausibility_evidence(torque_channel: str) -> ca.Function:
    """(evidence, sample, a) -> (evidence_next, suspect), by `torque_channel`; suspect is 0 or 1."""
    inputs = symbols(ca.SX, evidence=EVIDENCE.size, sample=len(SAMPLE), a=1)
    was, now = named(EVIDENCE.places, inputs["evidence"]), named(SAMPLE, inputs["sample"])
    torque = now["M_z"] if torque_channel == "M_z" else -now["M"]
    given, measured = ca.logic_and(is_known(now["F_N"]), now["F_N"] > 0), is_known(torque)
    load = ca.if_else(given, now["F_N"], was["load"])
    first = ca.if_else(was["first_load"] > 0, was["first_load"], load)
    most = MAX_TORQUE_RATIO * full_slide_torque(load, inputs["a"])
    beyond = ca.logic_and(measured, ca.logic_and(load > 0, ca.fabs(torque) > most))
    known = is_known(now["psi"])
    turn = ca.if_else(ca.logic_and(known, is_known(was["psi"])), now["psi"] - was["psi"], 0)
    # A torque may come more seldom than the angle.
    since = was["turn"] + turn
    near = ca.logic_or(was["turn"] == 0, ca.fabs(since) < MAX_STRETCH)
    stretch = ca.if_else(ca.logic_and(measured, near), since, 0)
    work = ca.if_else(measured, torque * stretch, 0)
    older = ca.if_else(ca.fabs(turn) < WORK_TRAVEL, 1 - ca.fabs(turn) / WORK_TRAVEL, 0)
    change = ca.if_else(ca.logic_and(measured, is_known(was["torque"])), torque - was["torque"], 0)
    same = ca.logic_and(measured, change == 0)
    turned = ca.if_else(change == 0, was["frozen_travel"] + ca.fabs(turn), 0)
    frozen = ca.if_else(same, was["frozen"] + 1, ca.if_else(measured, 0, was["frozen"]))
    size, earlier = ca.fabs(change), ca.fabs(was["jump"])
    left = ca.if_else(change * was["jump"] < 0, *JUMP_LEFT) * earlier
    larger = ca.if_else(size > left, size, left)
    jump = ca.if_else(change == 0, was["jump"], ca.if_else(change < 0, -larger, larger))
    is_least = ca.logic_and(change != 0, ca.logic_or(was["digit"] == 0, size < was["digit"]))
    digit = ca.if_else(is_least, size, was["digit"])
    large = ca.fabs(jump)
    steep = ca.logic_and(large > MIN_JUMP * ca.fabs(torque), large > MIN_DIGITS * digit)
    stays = ca.logic_and(frozen >= FROZEN, turned > FROZEN_TRAVEL)
    clipped = ca.logic_and(stays, steep)
    after = {
        "angle": _count_in_a_row(
            was["angle"], ca.logic_and(known, ca.fabs(now["psi"]) > MAX_STEERING_ANGLE)
        ),
        "period": _count_in_a_row(was["period"], now["dt"] >= MAX_PLAUSIBLE_PERIOD),
        "friction": _count_in_a_row(was["friction"], ca.logic_and(beyond, load >= LIFTED * first)),
        "load": load,
        "first_load": first,
        "psi": ca.if_else(known, now["psi"], was["psi"]),
        "turn": ca.if_else(measured, 0, since),
        "travel": was["travel"] + ca.fabs(stretch),
        "work": older * was["work"] + work,
        "exchanged": older * was["exchanged"] + ca.fabs(work),
        "torque": ca.if_else(measured, torque, was["torque"]),
        "jump": jump,
        "digit": digit,
        "frozen": frozen,
        "frozen_travel": turned,
        "clipped": ca.logic_or(was["clipped"], clipped),
    }
    suspect = reduce(ca.logic_or, suspected_by_message(after, torque_channel).values(), ca.SX(0))
    outputs = {"evidence_next": vector_of(EVIDENCE.places, after), "suspect": suspect}
    return named_function("evidence", inputs, outputs, cse=True)


def suspected_by_message(evidence: Parts, channel: str) -> dict[str, Expression]:
    """Each cause in a sentence that says what to do, and whether it is suspected of this torque."""
    light = evidence["load"] < MIN_WHEEL_LOAD
    beyond = evidence["friction"] >= IN_A_ROW
    given_back = evidence["work"] > MAX_RETURNED_WORK * evidence["exchanged"]
    return {
        "psi looks like degrees, or like a steering wheel's angle: it goes beyond a right angle;"
        " convert it to rad, or divide it by the steering ratio": evidence["angle"] >= IN_A_ROW,
        f"time looks like milliseconds or less: samples are at least {MAX_PLAUSIBLE_PERIOD:g} s apart;"
        " convert it to s": (evidence["period"] >= IN_A_ROW),
        "F_N looks like kN: the torque is more than any ground holds at it; convert it to N": beyond
        * light,
        "the torque looks like N mm, or like another shaft's: it is more than any ground holds;"
        " convert it to N m at the kingpin": beyond * (1 - light),
        "psi or the torque has the other sign: the ground would turn the wheel;"
        f" {CONVENTIONS[channel]}": (evidence["travel"] >= MIN_SIGN_TRAVEL) * given_back,
        "the torque is clipped or frozen: it stays the same to the last digit while the wheel turns;"
        " check the sensor and its range": evidence["clipped"],
    }


def suspicions_from_state(state: Any, channel: str) -> tuple[str, ...]:
    """Each suspected cause of an observer's state in a sentence; empty where all is plausible.

    A state without the check, or None, has none.
    """
    places = getattr(getattr(state, "layout", None), "places", {})
    if "evidence" not in places:
        return ()
    found = _suspected_cause_texts(state["evidence"], channel)
    if found or "verdict" not in places:
        return found
    status = int(np.nan_to_num(state["output"][OUTPUT.index("status")]))
    verdict = dict(zip(VERDICT, np.ravel(state["verdict"]).tolist(), strict=True))
    known = 0 < verdict["var_log_gain"] < KNOWN_SCALE**2
    off = known and abs(verdict["log_gain"]) > OFF_SCALE
    if verdict["suspect"] or (status & Status.ACQUIRING and off and not verdict["verified"]):
        return (
            f"the torque grows with the angle {math.exp(verdict['log_gain']):.2g} times as k, a and F_N"
            " say: check the torque's unit and gear, the angle's unit, k, a and F_N",
        )
    if status & Status.SUSPECT:
        return ("F_N looks like lbf or kgf: friction is more than any ground has; convert it to N",)
    return ()


def _suspected_cause_texts(evidence: Array, channel: str) -> tuple[str, ...]:
    values = {name: float(evidence[at][0]) for name, (at, _) in EVIDENCE.places.items()}
    return tuple(text for text, holds in suspected_by_message(values, channel).items() if holds)


def suspicions_of(samples: Iterable[Sample], rig: Rig, channel: str) -> tuple[str, ...]:
    """The suspicions after all samples of a recording.

    Args:
        samples: the samples; what is missing in one is no evidence.
        rig: gives the half-length.
        channel: the torque that is measured, `M_z` or `M`.
    """
    rows = np.array([sample.numbers for sample in samples]).T
    if rows.size == 0:
        return ()
    rows[4:] = np.where(np.abs(rows[4:]) < SENSIBLE, rows[4:], np.nan)
    stretch = compiled_stretch(build_implausibility_evidence(channel))
    states = run_stretches(stretch, START, rows, np.array([rig.a]), 0)
    return _suspected_cause_texts(states[:, -1], channel)


def _count_in_a_row(before: Expression, holds: Expression) -> Expression:
    return ca.if_else(before >= IN_A_ROW, before, ca.if_else(holds, before + 1, 0))
