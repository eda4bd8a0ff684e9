"""Whole recordings through compiled code: the torque and its exact sensitivities.

CasADi differentiates the step of the model in d directions of the parameter vector, the sensitivities of
the memory are propagated with the memory. Bristles run through the loops of `symbolic.compilation`; for
the exact patch, and where there is no compiler, the recursion runs inside one Function over a stretch of
samples (`mapaccum`).
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from symbolic.compilation.bristle_kernel import bristle_kernel
from symbolic.compilation.compiled_function_cache import compiled
from symbolic.effects.base import Effect
from symbolic.errors import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.model import GEOMETRY, SIGNALS, Model, transform_sample_by_effects
from symbolic.named_and_buffered_functions import BufferedCall, named_function

RIG_DIRECTIONS = (*GEOMETRY, "load")
"""Directions beside the parameter vector: half-length and caster [m], factor on the load [1]."""
ROUNDING = 1e-9
"""Share by which a value may be beyond its bound [1]."""
SAMPLES_PER_CALL = 100
"""Samples in one call; a recording is padded to a multiple of it."""


@dataclass(frozen=True, kw_only=True)
class TorqueAndSensitivities:
    """Torque of a model over a recording.

    Attributes:
        M_z: aligning torque, shape (n,) [N m].
        sensitivities: derivatives of M_z along each direction, shape (n, directions).
    """

    M_z: Array
    sensitivities: Array


def simulate(
    model: Model, signals: Array, theta: Array, geometry: Array, directions: Array | None = None
) -> TorqueAndSensitivities:
    """The torque over a recording, with derivatives along `directions` of the parameter vector.

    With an effect that has a `tare` the torque of the first sample is taken off.

    Args:
        model: the model.
        signals: rows psi [rad], psi_dot [rad/s], F_N [N], dt [s], shape (4, n).
        theta: parameter vector in the order of `model.coordinate_names`, shape (p,), as `model.theta`
            gives it of physical values, shape (p, 1): of a stiffness such as k_t it holds 1/k_t.
        geometry: a and e [m], shape (2,).
        directions: columns in parameter space, shape (p, d), or with `RIG_DIRECTIONS` as further rows,
            shape (p + 3, d); None for no derivatives.

    Raises:
        InvalidInputError: an array has another shape, or theta holds a value in place of one over it.
    """
    parameters = len(model.parameters)
    theta = np.asarray(theta, dtype=float)
    theta = theta[:, 0] if theta.shape == (parameters, 1) else theta
    seeds = np.zeros((parameters, 0)) if directions is None else directions
    _check_shapes(signals, theta, geometry, seeds, parameters)
    _require_reciprocals(model, theta)
    simulated = _simulate_untared(model, signals, theta, geometry, seeds)
    if not any(effect.tare for effect in model.effects):
        return simulated
    return TorqueAndSensitivities(
        M_z=simulated.M_z - simulated.M_z[0],
        sensitivities=simulated.sensitivities - simulated.sensitivities[0],
    )


def _simulate_untared(
    model: Model, signals: Array, theta: Array, geometry: Array, seeds: Array
) -> TorqueAndSensitivities:
    """The same with the torque of the first sample."""
    parameters = len(model.parameters)
    count, d = signals.shape[1], seeds.shape[1]
    rig = seeds.shape[0] > parameters
    start = BufferedCall(_initial_memory_sensitivities(model, d, rig=rig))
    for buffer, given in zip(start.inputs, (signals[:, 0], theta, seeds, geometry), strict=True):
        buffer[:] = given.ravel(order="F")
    start.call()
    initial = start.outputs
    if (kernel := bristle_kernel(model)) is not None:
        all_seeds = np.vstack([seeds, np.zeros((0 if rig else len(RIG_DIRECTIONS), d))])
        M_z, sensitivities = kernel.run(signals, theta, geometry, all_seeds, *initial)
        return TorqueAndSensitivities(M_z=M_z, sensitivities=sensitivities)
    stretch = BufferedCall(_compiled_sample_block(model, d, rig=rig))
    padded = np.pad(signals, ((0, 0), (0, -count % SAMPLES_PER_CALL)), mode="edge")
    parts = [*initial, padded[:, :SAMPLES_PER_CALL], theta, seeds, geometry]
    for buffer, part in zip(stretch.inputs, parts, strict=True):
        buffer[:] = part.ravel(order="F")
    torques, derivatives = [], []
    for first in range(0, count, SAMPLES_PER_CALL):
        stretch.inputs[2][:] = padded[:, first : first + SAMPLES_PER_CALL].ravel(order="F")
        stretch.call()
        for memory, memory_next in zip(stretch.inputs[:2], stretch.outputs[:2], strict=True):
            memory[:] = memory_next
        torques.append(stretch.outputs[2].copy())
        derivatives.append(stretch.outputs[3].reshape(SAMPLES_PER_CALL, d).copy())
    return TorqueAndSensitivities(
        M_z=np.concatenate(torques)[:count], sensitivities=np.concatenate(derivatives)[:count]
    )


def final_full_slide_memory(model: Model, signals: Array, theta: Array) -> Array:
    """The memory (memory_size,) after a recording, as far as full slide depends on it; the rest is 0.

    It is what effects on friction count up, such as the travel of `friction_drift`. Signals (4, n) are
    as of `simulate`, theta has the shape (p,).
    """
    memory = np.zeros(model.memory_size)
    if not any(
        effect.memory and type(effect).friction is not Effect.friction for effect in model.effects
    ):
        return memory
    step, count, own = _effect_memories_step(model), signals.shape[1], 1 + model.patch().memory_size
    begin = np.asarray(model.initial(signals[:, 0], theta, np.zeros(len(GEOMETRY)))).ravel()[own:]
    after = step.fold(count)(begin, signals, np.tile(theta[:, None], count))
    memory[own:] = np.asarray(after).ravel()
    return memory


@cache
def _effect_memories_step(model: Model) -> ca.Function:
    """(memory of the effects, signals, theta) -> that memory after the sample."""
    signals, theta, _ = model.input_symbols()
    before = ca.MX.sym("before", sum(effect.memory for effect in model.effects))
    _, after, _ = transform_sample_by_effects(model, model.split_effect_memories(before), signals, theta)
    return ca.Function("effects_step", [before, signals, theta], [ca.vertcat(*after)])


def _check_shapes(signals: Array, theta: Array, geometry: Array, seeds: Array, parameters: int) -> None:
    with_rig = parameters + len(RIG_DIRECTIONS)
    for name, given, allowed in (
        ("signals", signals.shape[:1], (len(SIGNALS),)),
        ("theta", theta.shape, (parameters,)),
        ("geometry", geometry.shape, (len(GEOMETRY),)),
    ):
        if given != allowed:
            raise InvalidInputError(f"{name} must have leading shape {allowed}, got {given}")
    if seeds.shape[:1] not in ((parameters,), (with_rig,)):
        raise InvalidInputError(
            f"directions must have leading shape {(parameters,)}, or {(with_rig,)} with those of the"
            f" rig, got {seeds.shape[:1]}"
        )


def _require_reciprocals(model: Model, theta: Array) -> None:
    """Refuse a value in place of one over it, which is far beyond what bounds allow."""
    given = zip(model.coordinate_names, model.parameters, theta, strict=True)
    for coordinate, (_, parameter), value in given:
        if parameter.inverse and value * parameter.lower > 1 + ROUNDING:
            name = coordinate.replace("1/", "")
            raise InvalidInputError(
                f"theta holds {coordinate}, one over {name}, which must be at least {parameter.lower:g}"
                f" {parameter.unit}, got {coordinate} = {value:g}; model.theta takes {name} itself"
            )


@cache
def _initial_memory_sensitivities(model: Model, d: int, *, rig: bool) -> ca.Function:
    signals, theta, geometry = model.input_symbols()
    moving, inputs, at = _differentiated_inputs(model, signals, theta, geometry, rig=rig)
    seeds = ca.MX.sym("seeds", moving.numel(), d)
    (memory,) = model.initial.call(inputs, True, False)
    results = [memory, ca.jtimes(memory, moving, seeds)]
    along = ca.Function("along", [signals, moving, seeds, geometry], results)
    outputs = map(ca.densify, along.call([signals, at, seeds, geometry], True, False))
    return ca.Function("start_along", [signals, theta, seeds, geometry], [*outputs])


def _differentiated_inputs(
    model: Model, signals: ca.MX, theta: ca.MX, geometry: ca.MX, *, rig: bool
) -> tuple[ca.MX, list[ca.MX], ca.MX]:
    """What is varied (theta, with `rig` also `RIG_DIRECTIONS`), the model's inputs by it, its values."""
    parameters = len(model.parameters)
    if not rig:
        moving = ca.MX.sym("moving", parameters)
        return moving, [signals, moving, geometry], theta
    moving = ca.MX.sym("moving", parameters + len(RIG_DIRECTIONS))
    factors = [moving[-1] if name == "F_N" else 1 for name in SIGNALS]
    inputs = [signals * ca.vertcat(*factors), moving[:parameters], moving[parameters:-1]]
    return moving, inputs, ca.vertcat(theta, geometry, 1)


@cache
def _compiled_sample_block(model: Model, d: int, *, rig: bool) -> ca.Function:
    """`SAMPLES_PER_CALL` calls of `sensitivity_step`: a column of signals, M_z and derivative each."""
    step = sensitivity_step(model, d, rig=rig)
    accumulated = step.mapaccum(f"{step.name()}_{SAMPLES_PER_CALL}", SAMPLES_PER_CALL, 2, {"base": -1})
    given = step.mx_in()
    given[2] = ca.MX.sym("signals", len(SIGNALS), SAMPLES_PER_CALL)
    constant = [ca.repmat(part, 1, SAMPLES_PER_CALL) for part in given[3:]]
    memory, memory_sensitivity, M_z, derivatives = accumulated(*given[:3], *constant)
    memory_sensitivity = memory_sensitivity[:, (SAMPLES_PER_CALL - 1) * d :]
    outputs = [memory[:, -1], memory_sensitivity, M_z, derivatives]
    return compiled(ca.Function(f"stretch_{d}", given, outputs), vectorised=True)


def sensitivity_step(model: Model, d: int, *, rig: bool = False) -> ca.Function:
    """The model's step with the sensitivities of memory and torque in d directions.

    Inputs: memory, memory_sensitivity (memory_size, d), signals, theta, seeds (p, d), geometry. Outputs:
    memory_next, memory_sensitivity_next, M_z and derivative (1, d). With `rig`, seeds have
    `RIG_DIRECTIONS` as further rows.
    """
    size = model.memory_size
    signals, theta, geometry = model.input_symbols()
    memory, memory_sensitivity = ca.MX.sym("memory", size), ca.MX.sym("memory_sensitivity", size, d)
    # Differentiated as one expression, not call by call, so that zero and shared terms are found.
    by, given, at = _differentiated_inputs(model, signals, theta, geometry, rig=rig)
    seeds = ca.MX.sym("seeds", by.numel(), d)
    moving = ca.MX.sym("moving", size + by.numel())
    # The parts of `by` become parts of what is differentiated by together with the memory.
    taken = ca.Function("inputs", [signals, by, geometry], given).call(
        [signals, moving[size:], geometry], True, False
    )
    after, M_z = model.step.call([moving[:size], *taken], True, False)
    along = ca.jtimes(ca.vertcat(after, M_z), moving, ca.vertcat(memory_sensitivity, seeds))
    rest = [memory_sensitivity, signals, seeds, geometry]
    results = [after, ca.densify(along[:size, :]), M_z, ca.densify(along[size, :])]
    flat = ca.Function("along", [moving, *rest], results, {"cse": True})
    outputs = flat.call([ca.vertcat(memory, at), *rest], True, False)
    inputs = {"memory": memory, "memory_sensitivity": memory_sensitivity, "signals": signals}
    inputs |= {"theta": theta, "seeds": seeds, "geometry": geometry}
    names = ("memory_next", "memory_sensitivity_next", "M_z", "derivative")
    return named_function(f"sensitivity_step_{d}", inputs, dict(zip(names, outputs, strict=True)))
