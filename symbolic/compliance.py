"""A torsional compliance in series with the patch: the turn that balances both, at every sample.

The patch follows psi + C M_z, with C the compliance and M_z the torque of the patch at that turn.
M_z falls monotonically with the turn and, for a given memory, is piecewise smooth, so bracketed Newton
steps from rest find the turn.
"""

import casadi as ca

from symbolic.patch import Expression, Patch

SEARCH_STEPS = 5
"""Number of bracketed Newton steps that are not differentiated; one differentiated step follows [1]."""


def advance_in_series(
    patch: Patch,
    memory: Expression,
    rigid_turn: Expression,
    coefficients: Expression,
    compliance: Expression,
) -> tuple[Expression, Expression]:
    """The turn t with t = rigid_turn + C M_z(t) [rad], and the patch memory after it.

    The search itself is not differentiated. One more Newton step from its end is, with constant
    slopes: first derivatives are those of the implicit function theorem, second derivatives are wrong.

    Args:
        patch: the patch in series.
        memory: patch memory before the sample.
        rigid_turn: turn of a patch without the compliance [rad].
        coefficients: of the sample, from `patch.coefficients`.
        compliance: C >= 0 [rad/(N m)].
    """
    root, slope, follows = _search(patch)(memory, coefficients, rigid_turn, compliance)
    near = patch.advance(memory, root, coefficients)
    further = (rigid_turn + compliance * patch.torque(near, coefficients) - root) / slope
    turn = root + further
    return turn, near + follows * further if patch.smooth else patch.advance(memory, turn, coefficients)


def _search(patch: Patch) -> ca.Function:
    """The search for the turn: (memory, coefficients, rigid_turn, compliance) -> (turn, slope, follows).

    slope is the derivative of the residual turn - rigid_turn - C M_z by the turn [1]; follows is that of
    the memory, zero where the patch is not `smooth`.
    """
    before, rest = ca.MX.sym("memory", patch.size), ca.MX.sym("coefficients", patch.coefficient_size)
    turn, goal, soft = (ca.MX.sym(name) for name in ("turn", "rigid_turn", "compliance"))
    after = patch.advance(before, turn, rest)
    M_z = patch.torque(after, rest)
    follows = ca.densify(ca.jtimes(after, turn, ca.MX(1))) if patch.smooth else ca.MX(0)
    slope = 1 - soft * ca.jtimes(M_z, turn, ca.MX(1))
    inputs, names = (
        [before, turn, rest, goal, soft],
        ["memory", "turn", "coefficients", "rigid_turn", "compliance"],
    )
    newton = ca.Function(
        "newton", inputs, [turn - goal - soft * M_z, slope], names, ["residual", "slope"]
    )
    slopes = ca.Function("slopes", inputs, [slope, follows], names, ["slope", "follows"])
    # The residual rises with the turn by at least one to one, so its value at rest brackets the root.
    root: Expression = ca.MX(0)
    residual, steep = newton(before, root, rest, goal, soft)
    low, high = ca.fmin(0, -residual), ca.fmax(0, -residual)
    for i in range(SEARCH_STEPS):
        step = root - residual / steep
        inside = ca.logic_and(step >= low, step <= high)
        root = ca.if_else(inside, step, (low + high) / 2)
        if i + 1 < SEARCH_STEPS:
            residual, steep = newton(before, root, rest, goal, soft)
            low, high = ca.if_else(residual < 0, root, low), ca.if_else(residual < 0, high, root)
    return ca.Function(
        "search",
        [before, rest, goal, soft],
        [root, *slopes(before, root, rest, goal, soft)],
        ["memory", "coefficients", "rigid_turn", "compliance"],
        ["turn", "slope", "follows"],
        {"is_diff_out": [False] * 3},
    )
