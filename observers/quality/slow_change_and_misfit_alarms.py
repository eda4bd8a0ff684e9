"""Monitor of the innovations: slow changes of the ground, and whether the model explains the torque.

A change of ln mu by d shifts the innovation nu, of variance S, by d h, with h the slope of the
measurement by ln mu. Two cumulative sums of the log-likelihood ratio of such a change, one a side,

    g <- max(0, g + n (+-d h nu - d^2 h^2 / 2) / (S max(1, 1 + (q - w) / W))),

detect it where a sum exceeds `Tuning.alarm` [Page 1954], [Basseville 1993], section 2.2. n is the share
of an independent sample that a sample is worth. Samples in stick, h = 0, count for nothing.

The consistency is q / w, with q the sum of n nu^2 / S and w that of n, both forgetting over
W = `FORGETTING_SAMPLES` independent samples: 1 on average where the model and its stated error are
right, [Bar-Shalom 2001], section 5.4. Where it is more than that, alarms become rarer. Innovations
beyond the gate count for neither.

Friction that rises or falls steadily raises no alarm; the estimate follows it, late. How late, the
innovations tell: with K nu the correction of ln mu and r the share of its variance that a sample takes,

    l <- (1 - r)^2 l + 2 (1 - r) K nu

is their mean over half of the estimator's own memory: 0 but for the deviation of ln mu where its walk is
right, the lag behind a ramp, and 0 after a sample from which all is learnt. ln mu is no surer than that,
unless it is stated not to walk.
"""

from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, symbols
from observers.measurement.measurement_model import log_mu_prior_variance
from observers.measurement.torque_error import SENSIBLE, forgetting_factor
from observers.tuning import TUNING_FIELDS
from symbolic.named_and_buffered_functions import named_function

MONITOR = ("rise", "fall", "squares", "samples", "lag")
"""Cumulative sums for a rise and a fall of mu, q and w of the consistency, and l; 0 at the start."""
HASTE = 2
"""Memory of the estimator over that of its lag [1]."""
CHANGE = 0.5
"""Change of ln mu that is looked for [1]."""
FORGETTING_SAMPLES = 20.0
"""Independent samples after which the consistency has forgotten older ones."""
MIN_SAMPLES = 5.0
"""Independent samples before the consistency is judged: the first ones share the prior's error."""
MAX_NORMALISED_SQUARE = 25.0
"""Upper limit of a squared innovation over its variance in the consistency [1]."""


@cache
def build_innovation_monitor(change: float = CHANGE) -> ca.Function:
    """One sample of the monitor, which looks for a change of ln mu [1].

    slope is that of the measurement by ln mu, variance the one of the innovation, independent as in
    `Measurement`, 0 where the measurement is missing; accepted, alarm and inconsistent are 0 or 1;
    correction is that of ln mu, learnt the share of its variance that goes.
    """
    inputs = symbols(
        ca.SX, innovation=1, slope=1, variance=1, independent=1, accepted=1, correction=1, learnt=1,
        monitor=len(MONITOR), tuning=len(TUNING_FIELDS),
    )  # fmt: skip
    innovation, slope, variance, independent, accepted, correction, learnt, monitor, tuning = (
        inputs.values()
    )
    past, limits = named(MONITOR, monitor), named(TUNING_FIELDS, tuning)
    share, shift = accepted * independent, change * slope
    scale = share / (variance * (1 + ca.fmax(0, past["squares"] - past["samples"]) / FORGETTING_SAMPLES))
    # No single sample raises an alarm, as none makes a reset.
    most = limits["alarm"] / limits["reset_after"]
    sums = [
        ca.fmax(0, past[name] + ca.fmin(most, scale * (side * shift * innovation - shift**2 / 2)))
        for name, side in (("rise", 1), ("fall", -1))
    ]
    watched = ca.logic_and(limits["gate"] < SENSIBLE, limits["alarm"] < SENSIBLE)
    alarm = ca.logic_and(watched, ca.fmax(*sums) > limits["alarm"])
    square = ca.fmin(MAX_NORMALISED_SQUARE, innovation**2 / variance)
    older = forgetting_factor(share, FORGETTING_SAMPLES)
    squares = older * past["squares"] + share * square
    samples = older * past["samples"] + share
    inconsistent = ca.logic_and(samples >= MIN_SAMPLES, squares > limits["explained"] * samples)
    quiet = ca.logic_not(alarm)
    kept = 1 - learnt
    lag = kept**HASTE * past["lag"] + HASTE * kept * correction
    outputs = {
        "alarm": alarm,
        "inconsistent": inconsistent,
        "monitor_next": ca.vertcat(*(quiet * each for each in sums), squares, samples, quiet * lag),
    }
    return named_function("monitor", inputs, outputs)


def log_mu_variance_between_grounds(tuning: Parts) -> Expression:
    """Variance of the difference of ln mu between two unknown grounds [1]."""
    return 2 * log_mu_prior_variance(tuning)
