"""filterpy's extended Kalman filter on the same problem, with the same compiled physics."""

import math
from collections.abc import Callable

import casadi as ca
import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from benchmarks.problem import Array, TimedProblem
from symbolic import compiled
from symbolic.named_and_buffered_functions import BufferedCall

Call = Callable[..., list[Array]]


def in_place(function: ca.Function) -> Call:
    """The Function on buffers of its own, the quickest way to call one from Python."""
    buffered = BufferedCall(function)

    def call(*values: Array) -> list[Array]:
        for array, value in zip(buffered.inputs, values, strict=True):
            array[:] = value
        buffered.call()
        return buffered.outputs

    return call


def through_casadi(function: ca.Function) -> Call:
    """The Function as casadi offers it: NumPy in, DM out."""
    return lambda *values: [output.full().ravel() for output in function.call(list(values))]


def filter_all(problem: TimedProblem, wrap: Callable[[ca.Function], Call]) -> Array:
    """The filter over the whole problem, sample by sample; mu after each."""
    parts = (problem.advance, problem.torque, problem.slopes)
    advance, torque, slopes = (wrap(compiled(part)) for part in parts)
    ekf = ExtendedKalmanFilter(dim_x=2, dim_z=1)
    ekf.x = problem.prior.reshape(2, 1)
    ekf.P = np.diag(problem.spreads**2)
    ekf.Q = np.diag(problem.walks)
    ekf.R = np.array([[problem.noise**2]])
    memory, mu = problem.start, np.empty(problem.count)
    for i, (signals, M_z) in enumerate(zip(problem.signals.T, problem.M_z, strict=True)):
        memory, inputs = (part.copy() for part in advance(memory, signals))
        ekf.predict()
        ekf.update(
            M_z,
            lambda x, at=(memory, inputs): slopes(*at, x[:, 0])[0].reshape(1, 2),
            lambda x, at=(memory, inputs): torque(*at, x[:, 0])[0].reshape(1, 1),
        )
        mu[i] = math.exp(ekf.x[0, 0])
    return mu
