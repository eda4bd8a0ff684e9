"""The step Function of an observer called from Python: one sample at a time, or a whole recording."""

import threading
from functools import cache

import casadi as ca
import numpy as np

from observers.protocol import Sample
from symbolic import compiled
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import BufferedCall
from symbolic.trajectory_sensitivity import SAMPLES_PER_CALL


class CompiledStep(threading.local):
    """Calls (state, sample, constants) -> (state_next, ...) on buffers of its own, one set a thread."""

    def __init__(self, function: ca.Function, constants: Array) -> None:
        """Allocate the buffers."""
        self._buffered = buffered = BufferedCall(function)
        self._state, self._sample, buffered.inputs[2][:] = *buffered.inputs[:2], constants
        self._next, self._call = buffered.outputs[0], buffered.call

    def __call__(self, state: Array, sample: Sample) -> Array:
        """The state after the sample, a new array."""
        self._state[:] = state
        self._sample[:] = (sample.psi, sample.psi_dot, sample.F_N, sample.dt, sample.M_z, sample.M)
        self._call()
        return self._next.copy()


def first_sample(samples: Array) -> Sample:
    """The first column of rows in the order of `SAMPLE`."""
    psi, psi_dot, F_N, dt, M_z, M = samples[:, 0].tolist()
    return Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, M_z=M_z, M=M)


@cache
def compiled_step(step: ca.Function) -> ca.Function:
    """A step (state, sample, constants) -> (state_next, output) in machine code."""
    return compiled(step)


@cache
def compiled_stretch(step: ca.Function, length: int = SAMPLES_PER_CALL) -> ca.Function:
    """So many samples of a step in machine code, one column each."""
    return compiled(step.mapaccum(f"{step.name()}_stretch", length, 1, {"base": -1}))


class CompiledStretch:
    """Calls a step mapped over some samples, as of `compiled_stretch`, on buffers of its own.

    CasADi's matrices would be new ones in every call, and the states are large.
    """

    def __init__(self, stretch: ca.Function) -> None:
        """Allocate the buffers."""
        self._buffered, self.length = BufferedCall(stretch), stretch.size2_in(1)

    def __call__(self, state: Array, samples: Array, constants: Array) -> list[Array]:
        """States and outputs of `length` samples, one a column, valid until the next call."""
        given = (state, samples.ravel("F"), np.tile(constants, self.length))
        for buffer, values in zip(self._buffered.inputs, given, strict=True):
            buffer[:] = values
        self._buffered.call()
        return [output.reshape(self.length, -1).T for output in self._buffered.outputs]


def run_stretches(
    stretch: ca.Function, state: Array, samples: Array, constants: Array, result: int = 1
) -> Array:
    """Outputs of all samples, one column each; the states, which take far more memory, for result 0."""
    call, count, parts = CompiledStretch(stretch), samples.shape[1], []
    padded = np.pad(samples, ((0, 0), (0, -count % call.length)), mode="edge")
    for at in range(0, count, call.length):
        results = call(state, padded[:, at : at + call.length], constants)
        state = results[0][:, -1].copy()
        parts.append(results[result].copy())
    return np.hstack(parts)[:, :count]
