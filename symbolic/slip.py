"""How far bristles slip in one sample, also where friction rises with their own sliding speed.

Without such a law slip takes off what exceeds the limit: the elastoplastic stop of the source, (2.16).
With it, s = v dt is the slip at which stress and friction balance,

    |stress| - (1 + held) s = limit (1 + c ln(max(v, v_0) / v_ref)),

held being the share of a Maxwell branch. So a bristle that is no longer driven does not lose stress in
an instant when the wheel stops; it creeps on, ever slower, until it comes to rest at v_0. In w = ln v
the balance is a convex, rising function, and Newton's method comes to its root from above.
"""

from functools import cache

import casadi as ca
import numpy as np

from symbolic.patch import Expression

REFERENCE_SPEED = 1e-3
"""Sliding speed at which the factor on the limit is one [m/s]."""
REST_SPEED = 1e-4
"""Below this the limit stays what it is here, so that creep ends [m/s]."""
_LEAST, _REFERENCE = float(np.log(REST_SPEED)), float(np.log(REFERENCE_SPEED))
_STEPS = 5
"""Newton steps, not differentiated, before the one that is: the slip is then right to 1e-7 of the limit,
its derivatives to 1e-6."""


def slip(
    stress: Expression, limit: Expression, held: Expression, reach: Expression, c: Expression | None
) -> Expression:
    """Slip of every bristle that brings it back to what friction bears.

    Args:
        stress: of every bristle before it slips, shape (n,), in the unit of the limit.
        limit: friction bound, at the reference speed where it depends on speed, shape (n,).
        held: stiffness of a Maxwell branch that slips along, as a share of the spring's; 0 for none.
        reach: slip of one sample at 1 m/s, in the same unit.
        c: growth of the limit with the log of the sliding speed, >= 0 [1]; None for the plain stop.
    """
    if c is None:
        return (stress - clipped(stress, limit)) / (1 + held)
    size = ca.fabs(stress)
    at_rest = ca.fmax(0, size - limit * (1 + c * (_LEAST - _REFERENCE))) / (1 + held)
    found = _search(int(stress.numel()))(at_rest, size, limit, held, reach, c)
    beyond, slope = _balance(found, size, limit, held, reach, c)
    moving = reach * ca.exp(found - beyond / slope)
    return ca.sign(stress) * ca.if_else(at_rest > reach * REST_SPEED, moving, at_rest)


def clipped(value: Expression, limit: Expression) -> Expression:
    """The elastoplastic stop (2.16)."""
    return ca.fmax(-limit, ca.fmin(limit, value))


def _balance(
    w: Expression,
    size: Expression,
    limit: Expression,
    held: Expression,
    reach: Expression,
    c: Expression,
) -> tuple[Expression, Expression]:
    """What friction and slip bear beyond the stress at ln v = w, and its slope by w."""
    relieved = (1 + held) * reach * ca.exp(w)
    return relieved + limit * (1 + c * (w - _REFERENCE)) - size, relieved + limit * c


@cache
def _search(n: int) -> ca.Function:
    """(at_rest, size, limit, held, reach, c) -> ln v of n bristles, at least that of v_0.

    at_rest is the slip that would bring a bristle back to what friction bears at v_0.
    """
    at_rest, size, limit = (ca.MX.sym(name, n) for name in ("at_rest", "size", "limit"))
    held, reach, c = (ca.MX.sym(name) for name in ("held", "reach", "c"))
    w = ca.log(ca.fmax(at_rest / reach, REST_SPEED))
    for _ in range(_STEPS):
        beyond, slope = _balance(w, size, limit, held, reach, c)
        w = w - beyond / slope
    return ca.Function(
        "slip_search",
        [at_rest, size, limit, held, reach, c],
        [ca.fmax(w, _LEAST)],
        ["at_rest", "size", "limit", "held", "reach", "c"],
        ["w"],
        {"is_diff_out": [False]},
    )
