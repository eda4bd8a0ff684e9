"""Outliers and changes of the ground: which innovations are believed.

An innovation beyond the gate is not believed. So many in a row, all to one side, are no outliers: then
the ground has changed, the variance of the prior is added to that of mu, and the samples count again.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
section 5.4 for the test of the innovation; Huber, Robust Statistics (1981), for the loss.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.layout import named
from observers.tuning import BELIEFS

Expression = Any
COUNTS = ("streak", "resets")
"""Innovations beyond the gate in a row, with the sign of their side; changes of the ground so far."""


@cache
def build_gate() -> ca.Function:
    """(innovation, open, weight, ordinary, counts, beliefs) -> (believed, reset, run, counts_next).

    open is the part of the innovation's variance that the states leave open, H P H'; weight 0 where
    nothing was measured; ordinary as in `Measurement`. believed and reset are 0 or 1; run is how many
    samples in a row, this one included, lie beyond the gate.
    """
    names = ["innovation", "open", "weight", "ordinary"]
    innovation, left_open, weight, ordinary = symbols = [ca.SX.sym(name) for name in names]
    counts, beliefs = ca.SX.sym("counts", len(COUNTS)), ca.SX.sym("beliefs", len(BELIEFS))
    streak, resets = ca.vertsplit(counts)
    belief = named(BELIEFS, beliefs)
    heard = weight > 0
    size = ca.sqrt(left_open + ca.fmin(ordinary, 1 / ca.if_else(heard, weight, 1)))
    beyond = ca.logic_and(heard, ca.fabs(innovation) > belief["gate"] * size)
    side = ca.if_else(innovation > 0, 1, -1)
    run = ca.if_else(beyond, ca.if_else(streak * side > 0, ca.fabs(streak), 0) + 1, 0)
    reset = run >= belief["reset_after"]
    believed = ca.logic_or(ca.logic_not(beyond), reset)
    streak = ca.if_else(heard, ca.if_else(reset, 0, run * side), streak)
    return ca.Function(
        "gate",
        [*symbols, counts, beliefs],
        [believed, reset, run, ca.vertcat(streak, resets + reset)],
        [*names, "counts", "beliefs"],
        ["believed", "reset", "run", "counts_next"],
    )


def huber_share(residual: Expression, ordinary: Expression, left_open: Expression = 0) -> Expression:
    """Factor on the weight of a residual, 1 or less, that makes its cost linear beyond ordinary size.

    What the states leave open, `left_open` [variance], is not the residual's fault and widens the limit.
    """
    return ca.fmin(1, ca.sqrt((ordinary + left_open) / residual**2))
