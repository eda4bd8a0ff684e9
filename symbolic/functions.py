"""CasADi Functions by the names of their inputs and outputs, and those called under a condition."""

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca


def named_function(
    name: str, inputs: Mapping[str, Any], outputs: Mapping[str, Any], **options: Any
) -> ca.Function:
    """A Function from symbols to expressions, each under its name; options are CasADi's."""
    return ca.Function(name, [*inputs.values()], [*outputs.values()], [*inputs], [*outputs], options)


def output_if(condition: Any, function: ca.Function, inputs: Sequence[Any], *otherwise: Any) -> Any:
    """A Function's outputs where a condition holds; elsewhere other values, and it is not called."""
    last = [ca.MX.sym(f"o{i}", *function.size_out(i)) for i in range(function.n_out())]
    given = [ca.MX.sym(f"i{i}", *function.size_in(i)) for i in range(function.n_in())]
    name = function.name()
    due = ca.Function(f"{name}_due", [*given, *last], function.call(given, False, True))
    idle = ca.Function(f"no_{name}", [*given, *last], last)
    return ca.Function.if_else(f"{name}_if", due, idle)(condition, *inputs, *otherwise)
