"""Functions of scalars, with the parameters as numbers in them."""

from collections.abc import Mapping
from typing import Any

import casadi as ca


def scalars(name: str, function: ca.Function, numbers: Mapping[str, Any]) -> ca.Function:
    """A Function with some inputs as numbers, expanded to scalar operations, each done once.

    An infinite number comes in as 1 over nothing, so that what it divides goes away.
    """
    names = [n for n in function.name_in() if n not in numbers]
    symbols = {n: ca.SX.sym(n, *function.size_in(n)) for n in names}
    nothing = ca.SX.sym("nothing")
    given = {n: _by_nothing(values, nothing) for n, values in numbers.items()} | symbols
    made = function.expand().call([given[n] for n in function.name_in()])
    flat = ca.substitute(made, [nothing], [ca.SX(0)])
    return ca.Function(name, list(symbols.values()), flat, names, function.name_out(), {"cse": True})


def _by_nothing(values: Any, nothing: ca.SX) -> ca.SX:
    return ca.vertcat(*(1 / nothing if value == float("inf") else value for value in values.tolist()))
