"""When friction that was acquired is handed over to the estimator."""

import casadi as ca

from observers.layout import Expression, Parts
from observers.measurement.torque_error import is_known
from observers.quality.mixture_verdict import ALLOWED

DECIDED = 0.15
"""Standard deviation of ln mu at which the filter takes over [1]."""
SLIPPERY = (0.015, 0.3)
"""Standard deviations of mu and of ln mu at which friction of a car is known too, whatever s may be [1]:
on ice the contacts slide at once, and nothing tells how stiff they are."""
AGREES = 2.0
"""Deviations of the error of a sample to which the estimator predicts the torque at the handover of
another ground's friction [1]."""


def is_decided(
    own: Parts, verdict: Parts, output: Parts, limits: Parts, sample: Parts, unsure: Expression,
    zero: Expression, *, memoryless_share: float, gear: bool,
) -> Expression:  # fmt: skip
    """Whether friction is handed over: it is known, and the estimator's patch is as the wheel's.

    sample has M_z [N m], the variance of its noise, `added` [N^2 m^2], and that of the model's `error`
    [1]; unsure is the variance of ln mu [1], zero that of the torque [N m], memoryless_share as in
    `EquivalentPatch`.
    """
    decided = _is_friction_known(verdict, unsure, limits, gear)
    # The estimator begins with a patch free of torque.
    decided = ca.logic_and(ca.logic_and(decided, verdict["wiped"]), own["phase"] == 1)
    if memoryless_share:
        torque = ca.fabs(output["M_z_predicted"] - zero)
        decided = ca.logic_and(decided, torque > memoryless_share * output["M_slide"])
    # After a change of the ground the estimator's patch remembers the old one until it slides.
    return ca.logic_and(decided, ca.logic_or(own["again"] != 1, _agrees(own, output, sample)))


def _is_friction_known(verdict: Parts, unsure: Expression, limits: Parts, gear: bool) -> Expression:
    known = ca.logic_and(unsure < DECIDED**2, verdict["verified"])
    if not gear:
        return known
    most = ca.fmin(SLIPPERY[1], SLIPPERY[0] * ca.exp(-verdict["log_mu"]))
    possible = ca.fabs(verdict["log_gain"]) < ALLOWED * limits["stiffness_std"]
    return ca.logic_or(known, ca.logic_and(unsure < most**2, possible))


def _agrees(own: Parts, output: Parts, sample: Parts) -> Expression:
    """Whether the estimator predicts the torque, if one is known."""
    slide, predicted = (output[name] * own["scale"] for name in ("M_slide", "M_z_predicted"))
    off = ca.if_else(is_known(sample["M_z"]), sample["M_z"] - predicted, 0)
    return off**2 <= AGREES**2 * (sample["added"] + sample["error"] * slide**2)
