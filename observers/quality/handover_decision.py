"""When friction that was acquired is handed over to the estimator."""

import casadi as ca

from observers.layout import Expression, Parts, named
from observers.measurement.torque_error import is_known
from observers.quality.hypotheses import SETTINGS, build_error
from observers.quality.verdict import ALLOWED

DECIDED = 0.15
"""Standard deviation of ln mu at which the filter takes over [1]."""
SLIPPERY = (0.015, 0.3)
"""Standard deviations of mu and of ln mu at which friction of a car is known too, whatever s may be [1]:
on ice the contacts slide at once, and nothing tells how stiff they are."""
AGREES = 2.0
"""Deviations of the error of a sample to which the estimator predicts the torque at the handover of
another ground's friction [1]."""


def is_decided(
    inputs: Parts, own: Parts, verdict: Parts, output: Parts, unsure: Expression, zero: Expression, *,
    slides: float, gear: bool,
) -> Expression:  # fmt: skip
    """Whether friction is handed over: it is known, and the estimator's patch is as the wheel's.

    Args:
        inputs: of `build_conclusion`.
        own: of them, by name, as the next two.
        verdict: of the hypotheses.
        output: of the estimator.
        unsure: variance of ln mu [1].
        zero: of the torque [N m].
        slides: share of the full slide beyond which memory keeps nothing of an earlier mu [1].
        gear: there is a steering gear.
    """
    limits = named(SETTINGS, inputs["limits"])
    decided = _is_friction_known(verdict, unsure, limits, gear)
    # The estimator begins with a patch free of torque.
    decided = ca.logic_and(ca.logic_and(decided, verdict["wiped"]), own["phase"] == 1)
    if slides:
        torque = ca.fabs(output["M_z_predicted"] - zero)
        decided = ca.logic_and(decided, torque > slides * output["M_slide"])
    # After a change of the ground the estimator's patch remembers the old one until it slides.
    return ca.logic_and(decided, ca.logic_or(own["again"] != 1, _agrees(inputs, own, output, limits)))


def _is_friction_known(verdict: Parts, unsure: Expression, limits: Parts, gear: bool) -> Expression:
    known = ca.logic_and(unsure < DECIDED**2, verdict["verified"])
    if not gear:
        return known
    most = ca.fmin(SLIPPERY[1], SLIPPERY[0] * ca.exp(-verdict["log_mu"]))
    possible = ca.fabs(verdict["log_gain"]) < ALLOWED * limits["stiffness_std"]
    return ca.logic_or(known, ca.logic_and(unsure < most**2, possible))


def _agrees(inputs: Parts, own: Parts, output: Parts, limits: Parts) -> Expression:
    """Whether the estimator predicts the torque, if one is known."""
    slide, predicted = (output[name] * own["scale"] for name in ("M_slide", "M_z_predicted"))
    _, variance, _ = build_error()(
        0, own["F_N"], inputs["tyre"][1], inputs["added"], slide, 1, limits["error"]
    )
    off = ca.if_else(is_known(inputs["M_z"]), inputs["M_z"] - predicted, 0)
    return off**2 <= AGREES**2 * variance
