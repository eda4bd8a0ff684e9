"""Changes of friction by direction: a stroke against the one before it the same way.

Friction that somebody changes is followed by a state that walks far, and to such a state a change is
no surprise. So the two questions have two models. Beside the estimate x, each direction has a reference
m of ln mu, of variance V, which walks as friction does where nobody changes it. In a stroke it is held,
and the innovations nu of the estimate, of slope h, give

    b <- (1 - n / W) b + w h (nu + h (x - m)),    J <- (1 - n / W) J + w h^2,

with w the inverse variance of the measurement's error, n the share of an independent sample and
W = `FORGETTING_SAMPLES`, so that a change within a stroke is not averaged away. The log-likelihood ratio
of a change is b^2 / (J + J^2 V) / 2 at its most likely size [Basseville 1993], section 2.4; where it
exceeds `Tuning.alarm`, friction has changed, from J V > `TOLD` on. V limits it: how many samples are
independent matters little. Outliers weigh less by their distance from the estimate, not from the
reference, from which a change is one. The end of a stroke corrects its reference; after a reset it
begins anew at the estimate.
"""

import casadi as ca

from observers.layout import Expression, Parts, named
from observers.measurement.directional_friction import EXCHANGED, OTHER
from observers.measurement.measurement_model import CLEAN, MeasurementModel
from observers.measurement.torque_error import SENSIBLE, forgetting_factor
from observers.quality.slow_change_and_misfit_alarms import FORGETTING_SAMPLES, MONITOR
from observers.tuning import TUNING_FIELDS

REFERENCE = ("reference", "variance", "other_reference", "other_variance", "score", "information")
"""m and V of the direction that loads the patch, then of the other one; b and J. A reference whose
variance is 0 begins at the next sample."""
STEADY_WALK = 0.033
"""Random walk of ln mu from stroke to stroke the same way where nobody changes it [1/sqrt(s)]."""
STROKE_CHANGE = 0.3
"""Change of ln mu that the innovations are watched for, in place of `innovation_monitor.CHANGE` [1]."""
AT_REST = 1e-3
"""Yaw rate up to which the wheel stands, and no stroke is compared [rad/s]."""
TINY = 1e-12
"""Divisor of the ratio before the first sample that counts."""
TOLD = 0.5
"""J V from which on a stroke is compared: it tells friction half as well as its reference does. A peak
where the patch breaks away is no change [1]."""


def change_monitor_fields(measurement_model: MeasurementModel) -> tuple[str, ...]:
    """Names of the numbers that the monitor keeps."""
    return (*MONITOR, *REFERENCE) if OTHER in measurement_model.states else MONITOR


def predict_reference_friction(
    kept: Expression, log_mu: Expression, P: Expression, now: Expression
) -> Parts:
    """As `REFERENCE` at the sample now, as `CLEAN`, from that of the last one.

    log_mu is predicted, of the direction that loads the patch, P its variance: where a reference begins.
    """
    past, sample = named(REFERENCE, kept), named(CLEAN, now)
    b, J, V = past["score"], past["information"], past["variance"]
    other = kept[2:4]
    corrected = ca.vertcat(past["reference"] + V * b / (1 + J * V), V / (1 + J * V))
    exchanged = ca.logic_and(sample[EXCHANGED], sample["dt"] > 0)
    here, there = ca.if_else(exchanged, other, kept[:2]), ca.if_else(exchanged, corrected, other)
    begins, walk = here[1] <= 0, STEADY_WALK**2 * sample["dt"]
    m, V = ca.if_else(begins, log_mu, here[0]), ca.if_else(begins, P, here[1] + walk)
    other_V = ca.if_else(there[1] > 0, there[1] + walk, 0)
    sums = ca.if_else(exchanged, 0, kept[4:])
    return named(REFERENCE, ca.vertcat(m, V, there[0], other_V, sums))


def update_change_statistic(
    reference: Parts, difference: Expression, slope: Expression, weight: Expression, share: Expression
) -> Parts:
    """As `REFERENCE` after a sample: difference is its innovation about the reference.

    slope is that of the measurement by ln mu, weight its inverse variance, 0 where it is not accepted,
    share that of an independent sample.
    """
    older = forgetting_factor(share, FORGETTING_SAMPLES)
    score = older * reference["score"] + weight * slope * difference
    return {
        **reference, "score": score, "information": older * reference["information"] + weight * slope**2,
    }  # fmt: skip


def has_friction_changed(reference: Parts, tuning: Expression) -> Expression:
    """Whether the log-likelihood ratio says that friction of this direction has changed: 0 or 1."""
    limits, J = named(TUNING_FIELDS, tuning), reference["information"]
    told = J * reference["variance"]
    ratio = reference["score"] ** 2 / (2 * ca.fmax(J * (1 + told), TINY))
    watched = ca.logic_and(limits["gate"] < SENSIBLE, limits["alarm"] < SENSIBLE)
    return ca.logic_and(watched, ca.logic_and(told > TOLD, ratio > limits["alarm"]))


def reset_reference_friction(reference: Parts, reset: Expression) -> Expression:
    """As `REFERENCE`, (6,): after a reset, that of this direction begins at the next sample."""
    anew = ("variance", "score", "information")
    return ca.vertcat(*(ca.if_else(reset, 0, v) if n in anew else v for n, v in reference.items()))
