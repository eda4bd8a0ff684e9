"""Functions of scalars: parameters as numbers, and exponentials that the state contains already."""

from collections.abc import Iterable, Mapping
from typing import Any

import casadi as ca


def scalar_function(
    name: str, function: ca.Function, numbers: Mapping[str, Any], *, last: ca.SX | None = None
) -> ca.Function:
    """A Function with some inputs as numbers, expanded to scalar operations, each done once.

    Infinite parameters enter as 1/ε with ε = 0 after simplification, so that terms divided by them
    vanish.

    Args:
        name: of the result.
        function: the Function.
        numbers: for an input, its elements: numbers, or expressions of `last`.
        last: a further input of the result, `constants`.
    """
    names = [n for n in function.name_in() if n not in numbers]
    symbols = {n: ca.SX.sym(n, *function.size_in(n)) for n in names}
    epsilon = ca.SX.sym("epsilon")
    given = {n: _with_infinity(values, epsilon) for n, values in numbers.items()} | symbols
    outputs = function.expand().call([given[n] for n in function.name_in()])
    flat = ca.substitute(outputs, [epsilon], [ca.SX(0)])
    inputs = symbols if last is None else symbols | {"constants": last}
    return ca.Function(
        name, list(inputs.values()), flat, list(inputs), function.name_out(), {"cse": True}
    )


def _with_infinity(values: Iterable[Any], epsilon: ca.SX) -> ca.SX:
    return ca.vertcat(
        *(1 / epsilon if isinstance(v, float) and v == float("inf") else v for v in values)
    )


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
