"""CasADi Functions by the names of their inputs and outputs, under a condition, and on own arrays."""

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np


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


class BufferedCall:
    """A Function that reads and writes flat arrays, whose entries lie column by column.

    The caller fills `inputs`, `call` evaluates, `outputs` are those of the last call. Handing over
    CasADi's matrices would take longer.
    """

    def __init__(self, function: ca.Function) -> None:
        """Allocate the arrays; structural zeros have no place in them."""
        self.inputs = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self.outputs = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self._buffer, self.call = function.buffer()
        # CasADi's stubs ask for a size that its buffers do not take; an empty array has no buffer.
        for place, arrays in ((self._buffer.set_arg, self.inputs), (self._buffer.set_res, self.outputs)):
            for i, array in enumerate(arrays):
                if array.size:
                    place(i, memoryview(array.data))  # type: ignore[call-arg]
