"""Exponentials that a state contains already, read instead of computed again."""

from collections.abc import Mapping

import casadi as ca


def with_known_exponentials(function: ca.Function, known: Mapping[int, int]) -> ca.Function:
    """The same Function of scalars, where exp of some elements of its first input is read from others.

    Args:
        function: a Function that is expanded to scalars.
        known: for an element of the first input, the element that holds exp of it.
    """
    inputs = [ca.SX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    outputs = [ca.SX(function.sparsity_out(i)) for i in range(function.n_out())]
    work: dict[int, ca.SX] = {}
    element: dict[int, int] = {}
    for k in range(function.n_instructions()):
        operation, at = function.instruction_id(k), function.instruction_input(k)
        to = function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[to[0]].nz[to[1]] = work[at[0]]
            continue
        source = element.get(at[0], -1) if operation == ca.OP_EXP else -1
        if operation == ca.OP_CONST:
            value = ca.SX(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            value = inputs[at[0]].nz[at[1]]
        elif source in known:
            value = inputs[0].nz[known[source]]
        else:
            operands = [work[i] for i in at]
            value = (ca.SX.unary if len(at) == 1 else ca.SX.binary)(operation, *operands)
        work[to[0]] = value
        element[to[0]] = at[1] if operation == ca.OP_INPUT and at[0] == 0 else -1
    return ca.Function(
        function.name(), inputs, outputs, function.name_in(), function.name_out(), {"cse": True}
    )
