"""A torsional compliance in series with the patch: the turn that balances both, at every sample.

The patch follows psi + C M_z, with C the compliance and M_z the torque that the patch itself makes at
the turn looked for. M_z falls monotonically with the turn and, the memory given, is piecewise smooth,
so bracketed Newton steps from rest find the turn.
"""

import casadi as ca

from symbolic.patch import Expression, Patch

SEARCH_STEPS = 5
"""Bracketed Newton steps, not differentiated, before the one that is."""


def solve_turn(
    patch: Patch,
    memory: Expression,
    asked: Expression,
    drive: Expression,
    compliance: Expression,
) -> Expression:
    """The turn t with t = asked + C M_z(t) [rad].

    The search itself is not differentiated. One more Newton step from its end is, with the slope held
    fixed; that derivative is the one of the implicit function theorem.

    Args:
        patch: the patch in series.
        memory: patch memory before the sample.
        asked: turn that would hold without the compliance [rad].
        drive: what `patch.drive` made of the sample.
        compliance: C >= 0 [rad/(N m)].
    """
    before, rest = ca.MX.sym("memory", patch.size), ca.MX.sym("drive", patch.drive_size)
    turn, goal, give = (ca.MX.sym(name) for name in ("turn", "asked", "compliance"))
    M_z = patch.torque(patch.advance(before, turn, rest), rest)
    slope = 1 - give * ca.jtimes(M_z, turn, ca.MX(1))
    newton = ca.Function(
        "newton",
        [before, turn, rest, goal, give],
        [turn - goal - give * M_z, slope],
        ["memory", "turn", "drive", "asked", "compliance"],
        ["residual", "slope"],
        {"is_diff_out": [True, False]},
    )
    # The residual rises with the turn by at least one to one, so its value at rest brackets the root.
    found: Expression = ca.MX(0)
    off, steep = newton(before, found, rest, goal, give)
    low, high = ca.fmin(0, -off), ca.fmax(0, -off)
    for _ in range(SEARCH_STEPS):
        step = found - off / steep
        inside = ca.logic_and(step >= low, step <= high)
        found = ca.if_else(inside, step, (low + high) / 2)
        off, steep = newton(before, found, rest, goal, give)
        low, high = ca.if_else(off < 0, found, low), ca.if_else(off < 0, high, found)
    search = ca.Function(
        "search",
        [before, rest, goal, give],
        [found],
        ["memory", "drive", "asked", "compliance"],
        ["turn"],
        {"is_diff_out": [False]},
    )
    start = search(memory, drive, asked, compliance)
    residual, steepness = newton(memory, start, drive, asked, compliance)
    return start - residual / steepness
