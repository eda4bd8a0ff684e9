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
class Torque:
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
) -> Torque:
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
    memory, carried = start(signals[:, 0], theta, seeds, geometry)
    constant = [np.tile(block, STRETCH) for block in (_column(theta), seeds, _column(geometry))]
    padded = np.pad(signals, ((0, 0), (0, -count % STRETCH)), mode="edge")
    torques, derivatives = [], []
    for first in range(0, count, STRETCH):
        made = stretch(memory, carried, padded[:, first : first + STRETCH], *constant)
        # The stretch hands back the memory after every sample; only the last one goes on.
        memory, carried = made[0][:, -1], made[1][:, made[1].shape[1] - d :]
        torques.append(made[2].full().ravel())
        derivatives.append(made[3].full().reshape(d, STRETCH, order="F").T)
    return Torque(M_z=np.concatenate(torques)[:count], sensitivities=np.concatenate(derivatives)[:count])


def _column(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector.reshape(-1, 1)


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
    return _start_with_sensitivities(model, d), compiled(_stretch(model, d))


def _start_with_sensitivities(model: Model, d: int) -> ca.Function:
    signals, theta, geometry = model.symbols()
    seeds = ca.MX.sym("seeds", theta.numel(), d)
    memory = model.start(signals, theta, geometry)
    along = model.start.forward(d)(
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
    step = step_along(model, d)
    return step.mapaccum(step.name(), STRETCH, 2, {})


def step_along(model: Model, d: int) -> ca.Function:
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
        f"step_along_{d}",
        [memory, carried, signals, theta, seeds, geometry],
        made,
        names,
        ["memory_next", "carried_next", "M_z", "derivative"],
    )
