"""Functions of scalars, with the parameters as numbers in them."""

from collections.abc import Mapping
from typing import Any

import casadi as ca


def scalar_function(name: str, function: ca.Function, numbers: Mapping[str, Any]) -> ca.Function:
    """A Function with some inputs as numbers, expanded to scalar operations, each done once.

    Infinite parameters enter as 1/ε with ε = 0 after simplification, so that terms divided by them
    vanish.
    """
    names = [n for n in function.name_in() if n not in numbers]
    symbols = {n: ca.SX.sym(n, *function.size_in(n)) for n in names}
    epsilon = ca.SX.sym("epsilon")
    given = {n: _with_infinity(values, epsilon) for n, values in numbers.items()} | symbols
    outputs = function.expand().call([given[n] for n in function.name_in()])
    flat = ca.substitute(outputs, [epsilon], [ca.SX(0)])
    return ca.Function(name, list(symbols.values()), flat, names, function.name_out(), {"cse": True})


def _with_infinity(values: Any, epsilon: ca.SX) -> ca.SX:
    return ca.vertcat(*(1 / epsilon if value == float("inf") else value for value in values.tolist()))
