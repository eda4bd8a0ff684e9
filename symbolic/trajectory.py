"""Whole recordings through one compiled Function: the torque and its exact sensitivities.

CasADi differentiates the step of the model in d directions of the parameter vector, the sensitivities of
the memory are propagated with the memory, and the recursion runs inside one Function over a stretch of
samples (`mapaccum`).
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from symbolic.compiled import compiled
from symbolic.errors import InvalidInputError
from symbolic.model import GEOMETRY, SIGNALS, Model

STRETCH = 100
"""Samples in one call; a recording is padded to a multiple of it."""


@dataclass(frozen=True, kw_only=True)
class TorqueTrajectory:
    """Torque of a model over a recording.

    Attributes:
        M_z: aligning torque, shape (n,) [N m].
        sensitivities: derivatives of M_z along each direction, shape (n, directions).
    """

    M_z: NDArray[np.float64]
    sensitivities: NDArray[np.float64]


def simulate(
    model: Model,
    signals: NDArray[np.float64],
    theta: NDArray[np.float64],
    geometry: NDArray[np.float64],
    directions: NDArray[np.float64] | None = None,
) -> TorqueTrajectory:
    """The torque over a recording, with derivatives along `directions` of the parameter vector.

    Args:
        model: the model.
        signals: rows psi [rad], psi_dot [rad/s], F_N [N], dt [s], shape (4, n).
        theta: parameter vector in the order of `model.coordinates`, shape (p,).
        geometry: a and e [m], shape (2,).
        directions: columns in parameter space, shape (p, d); None for no derivatives.

    Raises:
        InvalidInputError: an array has another shape.
    """
    parameters = len(model.parameters)
    seeds = np.zeros((parameters, 0)) if directions is None else directions
    _check_shapes(signals, theta, geometry, seeds, parameters)
    count, d = signals.shape[1], seeds.shape[1]
    start, stretch = _functions(model, d)
    initial = [part.full() for part in start(signals[:, 0], theta, seeds, geometry)]
    padded = np.pad(signals, ((0, 0), (0, -count % STRETCH)), mode="edge")
    # Buffers: conversion to and from CasADi's matrices would take a third of the time.
    buffer, call = stretch.buffer()
    given = [*initial, padded[:, :STRETCH], theta, seeds, geometry]
    inputs = [np.array(part, dtype=np.float64).ravel(order="F") for part in given]
    outputs = [np.zeros(stretch.nnz_out(i)) for i in range(stretch.n_out())]
    # CasADi's stubs ask for a size that its buffers do not take; empty arrays have no buffer.
    for place, arrays in ((buffer.set_arg, inputs), (buffer.set_res, outputs)):
        for i, array in enumerate(arrays):
            if array.size:
                place(i, memoryview(array.data))  # type: ignore[call-arg]
    torques, derivatives = [], []
    for first in range(0, count, STRETCH):
        inputs[2][:] = padded[:, first : first + STRETCH].ravel(order="F")
        call()
        inputs[0][:], inputs[1][:] = outputs[0], outputs[1]
        torques.append(outputs[2].copy())
        derivatives.append(outputs[3].reshape(STRETCH, d).copy())
    return TorqueTrajectory(
        M_z=np.concatenate(torques)[:count], sensitivities=np.concatenate(derivatives)[:count]
    )


def _check_shapes(
    signals: NDArray[np.float64],
    theta: NDArray[np.float64],
    geometry: NDArray[np.float64],
    seeds: NDArray[np.float64],
    parameters: int,
) -> None:
    wanted = {
        "signals": (signals.shape[:1], (len(SIGNALS),)),
        "theta": (theta.shape, (parameters,)),
        "geometry": (geometry.shape, (len(GEOMETRY),)),
        "directions": (seeds.shape[:1], (parameters,)),
    }
    for name, (given, allowed) in wanted.items():
        if given != allowed:
            raise InvalidInputError(f"{name} must have leading shape {allowed}, got {given}")


@cache
def _functions(model: Model, d: int) -> tuple[ca.Function, ca.Function]:
    """The start and one stretch, each with sensitivities in d directions."""
    return _start_with_sensitivities(model, d), compiled(_stretch(model, d), vectorised=True)


def _start_with_sensitivities(model: Model, d: int) -> ca.Function:
    signals, theta, geometry = model.symbols()
    seeds = ca.MX.sym("seeds", theta.numel(), d)
    memory = model.initial(signals, theta, geometry)
    along = model.initial.forward(d)(
        signals,
        theta,
        geometry,
        memory,
        ca.MX(signals.numel(), d),
        seeds,
        ca.MX(geometry.numel(), d),
    )
    return ca.Function("start_along", [signals, theta, seeds, geometry], [memory, ca.densify(along)])


def _stretch(model: Model, d: int) -> ca.Function:
    """`STRETCH` calls of `sensitivity_step`: signals, M_z and derivative have a column for each sample.

    Memory and its sensitivity are those before the first sample, then those after the last one.
    """
    step = sensitivity_step(model, d)
    accumulated = step.mapaccum(f"{step.name()}_{STRETCH}", STRETCH, 2, {})
    given = step.mx_in()
    given[2] = ca.MX.sym("signals", len(SIGNALS), STRETCH)
    constant = [ca.repmat(part, 1, STRETCH) for part in given[3:]]
    memory, memory_sensitivity, M_z, derivatives = accumulated(*given[:3], *constant)
    memory_sensitivity = memory_sensitivity[:, (STRETCH - 1) * d :]
    return ca.Function(f"stretch_{d}", given, [memory[:, -1], memory_sensitivity, M_z, derivatives])


def sensitivity_step(model: Model, d: int) -> ca.Function:
    """The model's step with the sensitivities of memory and torque in d directions.

    Inputs: memory, memory_sensitivity (memory_size, d), signals, theta, seeds (p, d), geometry. Outputs:
    memory_next, memory_sensitivity_next, M_z and derivative (1, d).
    """
    size, parameters = model.memory_size, len(model.parameters)
    signals, theta, geometry = model.symbols()
    memory, memory_sensitivity = ca.MX.sym("memory", size), ca.MX.sym("memory_sensitivity", size, d)
    seeds = ca.MX.sym("seeds", parameters, d)
    # Differentiated as one expression, not call by call, so that zero and shared terms are found.
    moving = ca.MX.sym("moving", size + parameters)
    inputs = [moving[:size], signals, moving[size:], geometry]
    after, M_z = model.step.call(inputs, True, False)
    along = ca.jtimes(ca.vertcat(after, M_z), moving, ca.vertcat(memory_sensitivity, seeds))
    flat = ca.Function(
        "along",
        [moving, memory_sensitivity, signals, seeds, geometry],
        [after, ca.densify(along[:size, :]), M_z, ca.densify(along[size, :])],
        {"cse": True},
    )
    outputs = flat.call(
        [ca.vertcat(memory, theta), memory_sensitivity, signals, seeds, geometry], True, False
    )
    names = ["memory", "memory_sensitivity", "signals", "theta", "seeds", "geometry"]
    return ca.Function(
        f"sensitivity_step_{d}",
        [memory, memory_sensitivity, signals, theta, seeds, geometry],
        outputs,
        names,
        ["memory_next", "memory_sensitivity_next", "M_z", "derivative"],
    )
