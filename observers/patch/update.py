"""Patch update: the memory advanced by one sample, the torque, and the slopes of the torque.

The memory of the patch is not filtered: it follows from the recorded angles and loads and from the
tyre's states.

The memory of the exact patch depends on neither mu nor k, so that a correction of mu holds for the whole
history: exact for a ground that stays the same.

Where the memory depends on the tyre, as that of bristles does, its sensitivity to the tyre is propagated
exactly, and a correction moves the memory to first order. Under a random walk the past mu is correlated
with the present one only in part, so the sensitivity is multiplied by the regression P (P + Q)^-1 of the
one on the other. So bristles, `Model(discretised=True)`, suit a ground that changes within seconds.
"""

from collections.abc import Mapping
from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, outputs_of, symbols, vector_of
from observers.measurement.directional_friction import EXCHANGED, OTHER
from observers.measurement.measurement_model import CLEAN, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import TYRE, slope_states, state_index
from observers.patch.patch_protocol import PatchModel
from symbolic import GEOMETRY, SIGNALS
from symbolic.named_and_buffered_functions import named_function

Fields = tuple[tuple[str, int, int], ...]
PARAMETERS = dict(zip(TYRE, ("mu", "k"), strict=True))
"""The model's parameter that a state of the tyre sets or scales."""


def tyre_states(measurement_model: MeasurementModel) -> tuple[str, ...]:
    """The states that are parameters of the tyre."""
    return tuple(name for name in TYRE if name in measurement_model.states)


def memory_fields(model: PatchModel, measurement_model: MeasurementModel) -> Fields:
    """Names and shapes: memory; sensitivity and linearisation point where it depends on the tyre."""
    size, count = model.memory_size, len(tyre_states(measurement_model))
    if not memory_depends_on_tyre(model, measurement_model):
        return (("memory", size, 1),)
    return (("memory", size, 1), ("memory_sensitivity", size, count), ("linearisation_point", count, 1))


@cache
def memory_depends_on_tyre(model: PatchModel, measurement_model: MeasurementModel) -> bool:
    """True where the memory depends on a state of the tyre."""
    return any(model.memory_depends_on(PARAMETERS[name]) for name in tyre_states(measurement_model))


@cache
def build_linearised_patch_update(model: PatchModel, measurement_model: MeasurementModel) -> ca.Function:
    """(*fields, signals, tyre, theta, geometry) -> (*fields_next, patch_signals, M_z, slopes).

    fields as in `memory_fields`; signals as in `symbolic.SIGNALS`, patch_signals those that reach the
    patch; tyre (t,) is mu and, where it is a state, k over its nominal value; theta the nominal
    parameters; slopes (d,) of M_z by the angle, where that is a state, and by the tyre.
    """
    size, count = model.memory_size, len(tyre_states(measurement_model))
    depends = memory_depends_on_tyre(model, measurement_model)
    theta = ca.MX.sym("theta", len(model.coordinate_names))
    geometry = ca.MX.sym("geometry", len(GEOMETRY))
    arguments = ca.MX.sym("arguments", size + len(SIGNALS) + count)
    memory, signals, tyre = ca.vertsplit(arguments, [0, size, size + len(SIGNALS), arguments.numel()])
    at = theta_with_estimated_tyre(model, measurement_model, theta, tyre)
    memory_next, patch_signals = model.advance.call([memory, signals, at, geometry], True, False)
    M_z = model.torque.call([memory_next, patch_signals, at, geometry], True, False)[0]
    seeds = ca.MX.sym("seeds", size, count) if depends else ca.MX(size, count)
    by_tyre = ca.vertcat(seeds, ca.MX(len(SIGNALS), count), ca.MX(ca.DM.eye(count)))
    psi = ca.DM.eye(len(SIGNALS))[:, SIGNALS.index("psi")]
    by_angle = ca.vertcat(ca.MX(size, 1), psi, ca.MX(count, 1))
    angles = [by_angle for name in slope_states(measurement_model) if name == "psi"]
    slopes = ca.jtimes(ca.vertcat(memory_next, M_z), arguments, ca.horzcat(*angles, by_tyre))
    sensitivity = [seeds] if depends else []
    by_memory = [slopes[:size, len(angles) :] for _ in sensitivity]
    results = [memory_next, *by_memory, patch_signals, M_z, slopes[size, :].T]
    flat = ca.Function("flat", [arguments, *sensitivity, theta, geometry], results, {"cse": True})
    inputs = _patch_update_symbols(model, measurement_model, signals=len(SIGNALS))
    fields = {name: inputs[name] for name, *_ in memory_fields(model, measurement_model)}
    tyre = inputs["tyre"]
    memory_next, *sensitivity, patch_signals, M_z, slopes = flat.call(
        [
            ca.vertcat(memory_at(fields, tyre), inputs["signals"], tyre), *list(fields.values())[1:2],
            inputs["theta"], inputs["geometry"],
        ], True, False,
    )  # fmt: skip
    points = [tyre for _ in sensitivity]
    results = [memory_next, *map(ca.densify, sensitivity), *points]
    outputs = dict(zip((f"{name}_next" for name in fields), results, strict=True))
    outputs |= {"patch_signals": patch_signals, "M_z": M_z, "slopes": ca.densify(slopes)}
    return named_function("patch_update", inputs, outputs)


def scale_memory_sensitivity(
    model: PatchModel, measurement_model: MeasurementModel, parts: Parts, retention: ca.MX
) -> dict[str, ca.MX]:
    """The fields of the memory among parts; of its sensitivity the share of `sensitivity_retention`."""
    memory = {name: parts[name] for name, *_ in memory_fields(model, measurement_model)}
    if memory_depends_on_tyre(model, measurement_model):
        memory["memory_sensitivity"] = memory["memory_sensitivity"] @ retention
    return memory


def advance_patch(
    model: PatchModel, measurement_model: MeasurementModel, memory: Parts, x: ca.MX, now: ca.MX,
    theta: ca.MX, rig: ca.MX,
) -> dict[str, ca.MX]:  # fmt: skip
    """Memory, patch_signals, M_z and slopes after a cleaned sample `now`, at the states x (n,)."""
    results = outputs_of(
        build_linearised_patch_update(model, measurement_model), *memory.values(),
        signals_with_states(measurement_model, x, now), estimated_tyre_parameters(measurement_model, x),
        theta, rig[: len(GEOMETRY)],
    )  # fmt: skip
    return {name.removesuffix("_next"): result for name, result in results.items()}


def _patch_update_symbols(
    model: PatchModel, measurement_model: MeasurementModel, **own: int
) -> dict[str, ca.MX]:
    """Symbols for the fields of the memory, others of a size, the tyre, theta and the geometry."""
    fields = {name: (rows, cols) for name, rows, cols in memory_fields(model, measurement_model)}
    sizes = {"tyre": len(tyre_states(measurement_model)), "theta": len(model.coordinate_names)}
    return symbols(ca.MX, **fields, **own, **sizes, geometry=len(GEOMETRY))


@cache
def build_patch_torque(model: PatchModel, measurement_model: MeasurementModel) -> ca.Function:
    """(*fields, patch_signals, tyre, theta, geometry) -> (M_z, slopes), of a memory already advanced.

    slopes (t,) are by the tyre alone.
    """
    inputs = _patch_update_symbols(model, measurement_model, patch_signals=len(SIGNALS))
    fields = {name: inputs[name] for name, *_ in memory_fields(model, measurement_model)}
    tyre = inputs["tyre"]
    at = theta_with_estimated_tyre(model, measurement_model, inputs["theta"], tyre)
    given = [memory_at(fields, tyre), inputs["patch_signals"], at, inputs["geometry"]]
    M_z = model.torque.call(given, True, False)[0]
    outputs = {"M_z": M_z, "slopes": ca.densify(ca.jacobian(M_z, tyre).T)}
    return named_function("torque_with_slopes", inputs, outputs, cse=True)


def memory_at(fields: Mapping[str, ca.MX], tyre: ca.MX) -> ca.MX:
    """The memory at the parameters `tyre` (t,), to first order where it depends on them."""
    memory = fields["memory"]
    if "memory_sensitivity" not in fields:
        return memory
    return memory + fields["memory_sensitivity"] @ (tyre - fields["linearisation_point"])


def sensitivity_retention(
    measurement_model: MeasurementModel, P: ca.MX, Q: ca.MX, x: ca.MX, now: ca.MX
) -> ca.MX:
    """Share (t, t) of the memory's sensitivity that a walk of the tyre's states by Q (n,) leaves.

    The sensitivity is multiplied by it from the right. P (n, n) is the covariance of the states and x
    (n,) the states, before the walk; now is the sample, cleaned. Nothing is left where the directions
    of friction are exchanged: the memory is that of the other one's friction.
    """
    at = [state_index(measurement_model, name) for name in tyre_states(measurement_model)]
    before, walk = P[at, at], ca.diag(Q[at])
    # Without a walk it is exactly the identity, also where P is singular.
    total = before + walk
    if len(at) == 1:
        retention = ca.if_else(walk > 0, before / ca.if_else(walk > 0, total, 1), 1)
    else:
        determinant = total[0, 0] * total[1, 1] - total[0, 1] * total[1, 0]
        inverse = ca.blockcat([[total[1, 1], -total[0, 1]], [-total[1, 0], total[0, 0]]]) / determinant
        retention = ca.if_else(ca.trace(walk) > 0, before @ inverse, ca.DM.eye(2))
    if OTHER in measurement_model.states:
        retention *= 1 - now[CLEAN.index(EXCHANGED)]
    # From the states to the parameters and back.
    scale = tyre_jacobian(measurement_model, x)
    return ca.diag(scale) @ retention @ ca.diag(1 / scale) if len(at) > 1 else retention


def reset_retention(reset: ca.MX, variance: ca.MX, increment: ca.MX) -> ca.MX:
    """Share of the memory's sensitivity that stays when a reset adds to the variance of ln mu.

    The memory was made on the old ground; it is not to follow corrections towards the new one.
    """
    retention: ca.MX = ca.if_else(reset, variance / (variance + increment), 1)
    return retention


def theta_with_estimated_tyre(
    model: PatchModel, measurement_model: MeasurementModel, theta: ca.MX, tyre: ca.MX
) -> Expression:
    """The parameters theta with mu, and k where it is a state, replaced by those of `tyre` (t,)."""
    rows, values = named(model.coordinate_names, theta), named(tyre_states(measurement_model), tyre)
    rows["mu"] = values["log_mu"]
    if "stiffness" in values:
        rows["k"] = rows["k"] * values["stiffness"]
    return vector_of(model.coordinate_names, rows)


def estimated_tyre_parameters(measurement_model: MeasurementModel, x: ca.MX) -> ca.MX:
    """mu, and k over its nominal value where it is a state, of states (n,) or a row of them (n, N)."""
    rows = {name: x[state_index(measurement_model, name), :] for name in tyre_states(measurement_model)}
    return ca.vertcat(*((rows | {"log_mu": ca.exp(rows["log_mu"])}).values()))


def tyre_jacobian(measurement_model: MeasurementModel, x: ca.MX) -> ca.MX:
    """The derivative of `estimated_tyre_parameters` by its own states, element by element."""
    mu = ca.exp(x[state_index(measurement_model), :])
    ones = ca.MX.ones(len(tyre_states(measurement_model)) - 1, x.shape[1])
    return ca.vertcat(mu, ones)


def slopes_by_states(measurement_model: MeasurementModel, slopes: ca.MX, x: ca.MX) -> ca.MX:
    """Slopes (d,) by the angle and the tyre's parameters as slopes by the states in `slope_states`."""
    scale = tyre_jacobian(measurement_model, x)
    angles = len(slope_states(measurement_model)) - len(tyre_states(measurement_model))
    return slopes * ca.vertcat(ca.MX.ones(angles, x.shape[1]), scale)


def signals_with_states(measurement_model: MeasurementModel, x: ca.MX, now: ca.MX) -> ca.MX:
    """The signals of a cleaned sample `now`, with those that are states taken from x."""
    states = measurement_model.states
    return ca.vertcat(*(
        x[states.index(name), :] if name in states else now[CLEAN.index(name), :] for name in SIGNALS
    ))  # fmt: skip
