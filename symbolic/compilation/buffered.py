"""Calls of a Function on arrays of their own: handing over CasADi's matrices would take longer."""

import casadi as ca
import numpy as np


class BufferedCall:
    """A Function that reads and writes flat arrays, whose entries lie column by column.

    Attributes:
        inputs: an array for each input, which the caller fills.
        outputs: an array for each output, as the last call left it.
        call: evaluates the Function.
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
