"""Monitor of the innovations: slow changes of the ground, and whether the model explains the torque.

A change of ln mu by d shifts the innovation nu, of variance S, by d h, with h the slope of the
measurement by ln mu. Two cumulative sums of the log-likelihood ratio of such a change, one a side,

    g <- max(0, g + n (+-d h nu - d^2 h^2 / 2) / (S max(1, c))),

detect it where a sum exceeds `Tuning.alarm` [Page 1954], [Basseville 1993], section 2.2. n is the share
of an independent sample that a sample is worth. Samples in stick, h = 0, count for nothing.

The consistency c is the mean of nu^2 / S, forgetting over `WINDOW` independent samples: 1 where the
model and its stated error are right, [Bar-Shalom 2001], section 5.4. Where they are not, alarms become
rarer by as much. Innovations beyond the gate count for neither.
"""

from functools import cache

import casadi as ca

from observers.layout import named
from observers.measurement_model import SENSIBLE, Expression, Parts, log_mu_variance
from observers.tuning import TUNING_FIELDS

MONITOR = ("rise", "fall", "excess")
"""Cumulative sums for a rise and a fall of mu, and the consistency less 1; 0 at the start."""
CHANGE = 0.5
"""Change of ln mu that is looked for [1]."""
WINDOW = 20.0
"""Independent samples over which the consistency forgets."""
LARGEST = 25.0
"""A larger square of an innovation over its variance counts as this in the consistency [1]."""


@cache
def build_monitor() -> ca.Function:
    """One sample of the monitor.

    (innovation, slope, variance, independent, accepted, monitor, tuning) -> (alarm, inconsistent,
    monitor_next). slope is that of the measurement by ln mu, variance the one of the innovation, independent as in
    `Measurement`, 0 where the measurement is missing; accepted, alarm and inconsistent are 0 or 1.
    """
    names = ["innovation", "slope", "variance", "independent", "accepted"]
    innovation, slope, variance, independent, accepted = symbols = [ca.SX.sym(name) for name in names]
    monitor, tuning = ca.SX.sym("monitor", len(MONITOR)), ca.SX.sym("tuning", len(TUNING_FIELDS))
    past, limits = named(MONITOR, monitor), named(TUNING_FIELDS, tuning)
    share, shift = accepted * independent, CHANGE * slope
    scale = share / (variance * (1 + ca.fmax(0, past["excess"])))
    # No single sample raises an alarm, as none makes a reset.
    most = limits["alarm"] / limits["reset_after"]
    sums = [
        ca.fmax(0, past[name] + ca.fmin(most, scale * (side * shift * innovation - shift**2 / 2)))
        for name, side in (("rise", 1), ("fall", -1))
    ]
    watched = ca.logic_and(limits["gate"] < SENSIBLE, limits["alarm"] < SENSIBLE)
    alarm = ca.logic_and(watched, ca.fmax(*sums) > limits["alarm"])
    square = ca.fmin(LARGEST, innovation**2 / variance)
    excess = past["excess"] + share / WINDOW * (square - 1 - past["excess"])
    kept = ca.if_else(alarm, 0, 1)
    return ca.Function(
        "monitor",
        [*symbols, monitor, tuning],
        [alarm, 1 + excess > limits["explained"], ca.vertcat(kept * sums[0], kept * sums[1], excess)],
        [*names, "monitor", "tuning"],
        ["alarm", "inconsistent", "monitor_next"],
    )


def change_variance(tuning: Parts) -> Expression:
    """Variance of the difference of ln mu between two unknown grounds [1]."""
    return 2 * log_mu_variance(tuning)
