"""Whole recordings through one compiled Function: the torque and its exact sensitivities.

The step of the model is differentiated by casadi in as many directions as are asked for, the
sensitivities of the memory are carried along with the memory, and the recursion runs inside one Function
over a stretch of samples (`mapaccum`).
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
    """What a model makes of a recording's angle and load.

    Attributes:
        M_z: aligning torque, shape (n,) [N m].
        sensitivities: derivatives of M_z in the directions asked for, shape (n, directions).
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
    at_first = [part.full() for part in start(signals[:, 0], theta, seeds, geometry)]
    padded = np.pad(signals, ((0, 0), (0, -count % STRETCH)), mode="edge")
    # Called on buffers of its own: casadi's matrices would take a third of the time.
    buffer, call = stretch.buffer()
    given = [*at_first, padded[:, :STRETCH], theta, seeds, geometry]
    inputs = [np.array(part, dtype=np.float64).ravel(order="F") for part in given]
    made = [np.zeros(stretch.nnz_out(i)) for i in range(stretch.n_out())]
    # casadi's stubs ask for a size that its buffers do not take; what is empty has no place to name.
    for place, arrays in ((buffer.set_arg, inputs), (buffer.set_res, made)):
        for i, array in enumerate(arrays):
            if array.size:
                place(i, memoryview(array.data))  # type: ignore[call-arg]
    torques, derivatives = [], []
    for first in range(0, count, STRETCH):
        inputs[2][:] = padded[:, first : first + STRETCH].ravel(order="F")
        call()
        inputs[0][:], inputs[1][:] = made[0], made[1]
        torques.append(made[2].copy())
        derivatives.append(made[3].reshape(STRETCH, d).copy())
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
    """`STRETCH` samples: memory, carried, signals, theta, seeds, geometry -> those two, M_z, derivative.

    What the steps hand on to each other stays inside; derivative has d columns a sample.
    """
    step = sensitivity_step(model, d)
    accumulated = step.mapaccum(f"{step.name()}_{STRETCH}", STRETCH, 2, {})
    given = step.mx_in()
    given[2] = ca.MX.sym("signals", len(SIGNALS), STRETCH)
    constant = [ca.repmat(part, 1, STRETCH) for part in given[3:]]
    memory, carried, M_z, derivatives = accumulated(*given[:3], *constant)
    carried = carried[:, (STRETCH - 1) * d :]
    return ca.Function(f"stretch_{d}", given, [memory[:, -1], carried, M_z, derivatives])


def sensitivity_step(model: Model, d: int) -> ca.Function:
    """The model's step with d sensitivities of memory and torque carried along.

    (memory, carried, signals, theta, seeds, geometry) -> (memory, carried, M_z, derivative), with
    carried (memory_size, d), seeds (p, d) and derivative (1, d).
    """
    size, parameters = model.memory_size, len(model.parameters)
    signals, theta, geometry = model.symbols()
    memory, carried = ca.MX.sym("memory", size), ca.MX.sym("carried", size, d)
    seeds = ca.MX.sym("seeds", parameters, d)
    # Differentiated as one expression, not call by call: what is zero or shared is then seen.
    moving = ca.MX.sym("moving", size + parameters)
    inputs = [moving[:size], signals, moving[size:], geometry]
    after, M_z = model.step.call(inputs, True, False)
    along = ca.jtimes(ca.vertcat(after, M_z), moving, ca.vertcat(carried, seeds))
    flat = ca.Function(
        "along",
        [moving, carried, signals, seeds, geometry],
        [after, ca.densify(along[:size, :]), M_z, ca.densify(along[size, :])],
        {"cse": True},
    )
    made = flat.call([ca.vertcat(memory, theta), carried, signals, seeds, geometry], True, False)
    names = ["memory", "carried", "signals", "theta", "seeds", "geometry"]
    return ca.Function(
        f"sensitivity_step_{d}",
        [memory, carried, signals, theta, seeds, geometry],
        made,
        names,
        ["memory_next", "carried_next", "M_z", "derivative"],
    )
