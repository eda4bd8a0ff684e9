"""A torsional compliance in series with the patch: the turn that balances both, at every sample.

The patch follows psi + C M_z, with C the compliance and M_z the torque that the patch itself makes at
the turn looked for. M_z falls monotonically with the turn and, the memory given, is piecewise smooth,
so bracketed Newton steps from rest find the turn.
"""

import casadi as ca

from symbolic.patch import Expression, Patch

SEARCH_STEPS = 5
"""Bracketed Newton steps, not differentiated, before the one that is."""


def advance_in_series(
    patch: Patch,
    memory: Expression,
    asked: Expression,
    drive: Expression,
    compliance: Expression,
) -> tuple[Expression, Expression]:
    """The turn t with t = asked + C M_z(t) [rad], and the patch memory after it.

    The search itself is not differentiated. One more Newton step from its end is, with the slopes held
    fixed; that first derivative is the one of the implicit function theorem, second ones are not right.

    Args:
        patch: the patch in series.
        memory: patch memory before the sample.
        asked: turn that would hold without the compliance [rad].
        drive: what `patch.drive` made of the sample.
        compliance: C >= 0 [rad/(N m)].
    """
    found, slope, follows = _search(patch)(memory, drive, asked, compliance)
    near = patch.advance(memory, found, drive)
    further = (asked + compliance * patch.torque(near, drive) - found) / slope
    turn = found + further
    return turn, near + follows * further if patch.smooth else patch.advance(memory, turn, drive)


def _search(patch: Patch) -> ca.Function:
    """(memory, drive, asked, compliance) -> (turn, slope of what is left by the turn, of the memory).

    The latter is zero where the memory may not be moved along it.
    """
    before, rest = ca.MX.sym("memory", patch.size), ca.MX.sym("drive", patch.drive_size)
    turn, goal, give = (ca.MX.sym(name) for name in ("turn", "asked", "compliance"))
    after = patch.advance(before, turn, rest)
    M_z = patch.torque(after, rest)
    follows = ca.densify(ca.jtimes(after, turn, ca.MX(1))) if patch.smooth else ca.MX(0)
    slope = 1 - give * ca.jtimes(M_z, turn, ca.MX(1))
    inputs, names = [before, turn, rest, goal, give], ["memory", "turn", "drive", "asked", "compliance"]
    newton = ca.Function("newton", inputs, [turn - goal - give * M_z, slope], names, ["left", "slope"])
    slopes = ca.Function("slopes", inputs, [slope, follows], names, ["slope", "follows"])
    # What is left rises with the turn by at least one to one, so its value at rest brackets the root.
    found: Expression = ca.MX(0)
    left, steep = newton(before, found, rest, goal, give)
    low, high = ca.fmin(0, -left), ca.fmax(0, -left)
    for i in range(SEARCH_STEPS):
        step = found - left / steep
        inside = ca.logic_and(step >= low, step <= high)
        found = ca.if_else(inside, step, (low + high) / 2)
        if i + 1 < SEARCH_STEPS:
            left, steep = newton(before, found, rest, goal, give)
            low, high = ca.if_else(left < 0, found, low), ca.if_else(left < 0, high, found)
    return ca.Function(
        "search",
        [before, rest, goal, give],
        [found, *slopes(before, found, rest, goal, give)],
        ["memory", "drive", "asked", "compliance"],
        ["turn", "slope", "follows"],
        {"is_diff_out": [False] * 3},
    )
