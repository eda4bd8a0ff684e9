"""Elements in series with the patch: the turn that balances them and the patch, at every sample.

The patch follows psi + d(M_z), with d the deflection of the elements and M_z the torque of the patch at
that turn. M_z falls with the turn and, for a given memory, is piecewise smooth; d rises with the torque.
Newton steps linearise the patch, which takes its time to evaluate, and solve for the deflection as it
is: a backlash bends far more sharply than the patch does.
"""

import casadi as ca

from symbolic.effects.base import ModelProtocol
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression, Patch

SEARCH_STEPS = 5
"""Number of bracketed Newton steps that are not differentiated; one differentiated step follows [1]."""
BALANCE_STEPS = 8
"""Newton steps within each of them, for the deflection against a patch that is linear [1]."""


def series_deflection(model: ModelProtocol, *, gaps: bool = False) -> ca.Function | None:
    """(M_z, load and theta) -> turn of what is in series with the patch [rad], or of gaps alone.

    None where there is nothing.
    """
    M_z, F_N, theta = ca.MX.sym("M_z"), ca.MX.sym("F_N"), model.input_symbols()[1]
    turns = [
        effect.deflection(M_z, F_N, values)
        for effect, values in model.values_by_effect(theta)
        if effect.is_gap or not gaps
    ]
    present = [turn for turn in turns if turn is not None]
    if not present:
        return None
    return ca.Function("deflection", [M_z, ca.vertcat(F_N, theta)], [sum(present)])


def advance_in_series(
    patch: Patch,
    memory: Expression,
    rigid_turn: Expression,
    coefficients: Expression,
    deflection: ca.Function | None,
    elements: Expression,
    steps: int,
) -> tuple[Expression, Expression]:
    """The turn t with t = rigid_turn + d(M_z(t)) [rad], and the patch memory after it.

    The deflection (M_z, elements) -> d rises with M_z and is zero at zero; None is a rigid patch. The
    search by so many bracketed Newton steps is not differentiated. One more step from its end is, with
    constant slopes: first derivatives are those of the implicit function theorem, second ones are wrong.
    """
    if deflection is None:
        return rigid_turn, patch.advance(memory, rigid_turn, coefficients)
    root, slope, follows = _series_torque_search(patch, deflection, steps)(
        memory, coefficients, rigid_turn, elements
    )
    turn = rigid_turn + deflection(root, elements)
    near = patch.advance(memory, turn, coefficients)
    M_z = root + (patch.torque(near, coefficients) - root) / slope
    further = rigid_turn + deflection(M_z, elements) - turn
    if patch.smooth:
        return turn + further, near + follows * further
    return turn + further, patch.advance(memory, turn + further, coefficients)


def _series_torque_search(patch: Patch, deflection: ca.Function, steps: int) -> ca.Function:
    """The search for M_z: (memory, coefficients, rigid_turn, elements) -> (M_z, slope, follows)."""
    before, rest = (
        ca.MX.sym("memory", patch.memory_size),
        ca.MX.sym("coefficients", patch.coefficient_size),
    )
    elements = ca.MX.sym("elements", deflection.size1_in(1))
    turn, goal = ca.MX.sym("turn"), ca.MX.sym("rigid_turn")
    after = patch.advance(before, turn, rest)
    M_z = patch.torque(after, rest)
    follows = ca.densify(ca.jtimes(after, turn, ca.MX(1))) if patch.smooth else ca.MX(0)
    given = {"memory": before, "turn": turn, "coefficients": rest}
    slope = ca.jtimes(M_z, turn, ca.MX(1))
    tangent = named_function("tangent", given, {"M_z": M_z, "slope": slope})
    slopes = named_function("slopes", given, {"slope": slope, "follows": follows})
    balanced = build_linear_patch_balance(deflection)
    # The residual rises with the turn by at least one to one, so its value at rest brackets the root.
    root: Expression = ca.MX(0)
    torque, slope = tangent(before, root, rest)
    residual = root - goal - deflection(torque, elements)
    low, high = ca.fmin(0, -residual), ca.fmax(0, -residual)
    for i in range(steps):
        torque = balanced(torque + slope * (goal - root), slope, elements)
        step = goal + deflection(torque, elements)
        # Rounding must not turn a converged step back out of the bracket, whose other end may be far.
        step = ca.if_else(residual < 0, ca.fmax(step, root), ca.fmin(step, root))
        inside = ca.logic_and(step >= low, step <= high)
        root = ca.if_else(inside, step, (low + high) / 2)
        if i + 1 < steps:
            torque, slope = tangent(before, root, rest)
            residual = root - goal - deflection(torque, elements)
            low, high = ca.if_else(residual < 0, root, low), ca.if_else(residual < 0, high, root)
    slope, follows = slopes(before, goal + deflection(torque, elements), rest)
    M_z = ca.MX.sym("M_z")
    softness = ca.Function("softness", [M_z, elements], [ca.jacobian(deflection(M_z, elements), M_z)])
    inputs = {"memory": before, "coefficients": rest, "rigid_turn": goal, "elements": elements}
    # slope is the derivative of the residual M_z - M_z(rigid_turn + d(M_z)) by M_z.
    found = {"M_z": torque, "slope": 1 - slope * softness(torque, elements), "follows": follows}
    return named_function("search", inputs, found, is_diff_out=[False] * len(found))


def build_linear_patch_balance(deflection: ca.Function) -> ca.Function:
    """(rigid, slope, elements) -> M with M = rigid + slope d(M), the patch being linear.

    rigid is the torque of the patch without the elements [N m], slope <= 0 that by its turn [N m/rad].
    """
    rigid, slope = ca.MX.sym("rigid"), ca.MX.sym("slope")
    elements, M = ca.MX.sym("elements", deflection.size1_in(1)), ca.MX.sym("M")
    residual = M - rigid - slope * deflection(M, elements)
    newton = ca.Function("newton", [M, rigid, slope, elements], [residual, ca.jacobian(residual, M)])
    low, high = ca.fmin(0, rigid), ca.fmax(0, rigid)
    # The deflection at the largest torque is too large: what it leaves is too small a torque.
    root = ca.fmin(high, ca.fmax(low, rigid + slope * deflection(rigid, elements)))
    for _ in range(BALANCE_STEPS):
        value, steep = newton(root, rigid, slope, elements)
        low, high = ca.if_else(value < 0, root, low), ca.if_else(value < 0, high, root)
        step = root - value / steep
        inside = ca.logic_and(step >= low, step <= high)
        root = ca.if_else(inside, step, (low + high) / 2)
    return ca.Function("balance", [rigid, slope, elements], [root])
