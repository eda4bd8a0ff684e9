"""One bristle, a sample and the elements in series as Functions of scalars, with their derivatives.

The expressions are those of `symbolic.bristle_patch`, `symbolic.bristle_slip`,
`symbolic.elements_in_series` and the effects, with one bristle in the place of all.
`symbolic.compilation.bristle_kernel` makes a recording of them.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from symbolic.bristle_patch import BristlePatch
from symbolic.bristle_slip import log_speed_search, solver_outputs_at_log_speed
from symbolic.elements_in_series import build_linear_patch_balance
from symbolic.model import (
    GEOMETRY,
    SIGNALS,
    Model,
    add_effect_torques,
    effect_memory_torque,
    transform_sample_by_effects,
)
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression, Signals, patch_inputs

Functions = dict[str, ca.Function]
SCALARS = (*SIGNALS, "factor", "memory_torque")
"""A sample's scalars: the signals at the patch, the factor on friction, the torque of the effects' own
memories, then theta, a and e."""
PLACES = ("lever", "limit", "moment")
"""Coefficients of each bristle, see `BristlePatch.coefficients`."""
SHARED = 4
"""How many follow there that all bristles share."""
FOUND = 4
"""Results of `symbolic.bristle_slip.bristle_slip_solver`."""


@dataclass(frozen=True, kw_only=True)
class BristleAtPlace(BristlePatch):
    """One bristle, whose place x / a and y / half_width, and weight over u, are expressions."""

    place: tuple[Expression, Expression, Expression]

    @property
    def bristle_count(self) -> int:
        """One."""
        return 1

    def nodes_and_weights(self) -> tuple[Expression, Expression, Expression]:
        """Place and weight."""
        return self.place


def bristle_patch_of(model: Model, theta: Expression | None = None) -> BristlePatch:
    """The bristles of a model, with the traits at a parameter vector."""
    patch = model.patch(theta)
    assert isinstance(patch, BristlePatch)
    return patch


def sample_scalar_count(model: Model) -> int:
    """How many scalars of a sample there are."""
    return len(SCALARS) + len(model.parameters) + len(GEOMETRY)


def sample_functions(model: Model) -> Functions:
    """A sample's scalars and the torque beside the patch, each with its derivative along a direction."""
    p, size = len(model.parameters), sum(effect.memory for effect in model.effects)
    lengths = {"own": size, "theta": p, "geometry": len(GEOMETRY), "load": 1}
    moving = {name: ca.SX.sym(name, length) for name, length in lengths.items()}
    along = {f"{name}_by": ca.SX.sym(f"{name}_by", length) for name, length in lengths.items()}
    signals = ca.SX.sym("signals", len(SIGNALS))
    factors = ca.vertcat(*(moving["load"] if name == "F_N" else 1 for name in SIGNALS))
    own = model.split_effect_memories(moving["own"])
    patch_signals, memories, factor = transform_sample_by_effects(
        model, own, signals * factors, moving["theta"]
    )
    scalars = ca.vertcat(
        *(getattr(patch_signals, name) for name in SIGNALS), factor,
        effect_memory_torque(memories, model, moving["theta"]), moving["theta"], moving["geometry"]
    )  # fmt: skip
    after = ca.vertcat(*memories) if size else ca.SX(0, 1)
    moved = ca.vertcat(*moving.values()), ca.vertcat(*along.values())
    results = [after, scalars, ca.jtimes(after, *moved), ca.jtimes(scalars, *moved)]
    after, scalars, after_by, scalars_by = ca.substitute(results, [moving.pop("load")], [ca.SX(1)])
    inputs = {"own": moving["own"], "signals": signals, **moving}
    z, z_by = _sample_scalar_symbols(model)
    patch_signals, _, theta, _ = _split_sample_scalars(model, z)
    beside = add_effect_torques(z[SCALARS.index("memory_torque")], model, patch_signals, theta)
    return {
        "sample": _dense_function("sample", inputs, {"own_next": after, "scalars": scalars}),
        "sample_along": _dense_function(
            "sample_along", inputs | along, {"own_next_by": after_by, "scalars_by": scalars_by}
        ),
        "beside": _dense_function("beside", {"z": z}, {"torque": beside}),
        "beside_along": _dense_function(
            "beside_along", {"z": z, "z_by": z_by}, {"torque_by": ca.jtimes(beside, z, z_by)}
        ),
    }


def _sample_scalar_symbols(model: Model) -> tuple[ca.SX, ca.SX]:
    """A sample's scalars, and their derivative along a direction."""
    return ca.SX.sym("z", sample_scalar_count(model)), ca.SX.sym("z_by", sample_scalar_count(model))


def _split_sample_scalars(model: Model, z: ca.SX) -> tuple[Signals, ca.SX, ca.SX, ca.SX]:
    """Signals at the patch, factor on friction, theta and geometry, out of a sample's scalars."""
    *signals, factor, _ = ca.vertsplit(z[: len(SCALARS)])
    theta, geometry = ca.vertsplit(
        z[len(SCALARS) :], [0, len(model.parameters), z.numel() - len(SCALARS)]
    )
    return Signals(**dict(zip(SIGNALS, signals, strict=True))), factor, theta, geometry


def coefficient_functions(model: Model) -> Functions:
    """Coefficients of a bristle and those that all share, with their derivatives."""
    z, z_by = _sample_scalar_symbols(model)
    signals, factor, theta, geometry = _split_sample_scalars(model, z)
    u, v, w = (ca.SX.sym(name) for name in "uvw")
    one = BristleAtPlace(traits=bristle_patch_of(model, theta).traits, place=(u, v, w))
    coefficients = one.coefficients(patch_inputs(signals, factor, theta, geometry))
    own, shared = coefficients[: len(PLACES)], coefficients[len(PLACES) :]
    inputs = {"u": u, "v": v, "w": w, "z": z}
    return {
        "place": _dense_function("place", inputs, dict(zip(PLACES, ca.vertsplit(own), strict=True))),
        "place_partials": _dense_function("place_partials", inputs, {}, partials=ca.jacobian(own, z)),
        "share": _dense_function("share", {"z": z}, {"shared": shared}),
        "share_along": _dense_function(
            "share_along", {"z": z, "z_by": z_by}, {"shared_by": ca.jtimes(shared, z, z_by)}
        ),
    }


def _bristle_step_expressions(
    model: Model,
) -> tuple[dict[str, ca.SX], ca.SX, ca.SX, tuple[Expression, ...] | None]:
    """Inputs, a bristle's stresses after its step, what the search found, and what it searches by."""
    # What is found is an input: the search is not differentiated.
    found = ca.SX.sym("found", FOUND)
    calls: list[tuple[Expression, ...]] = []

    def solve(*arguments: Expression) -> list[ca.SX]:
        calls.append(arguments)
        return list(ca.vertsplit(found))

    # The traits say which laws there are; their numbers are among the coefficients.
    one = BristleAtPlace(traits=bristle_patch_of(model).traits, place=(0, 0, 0), solver=solve)
    stresses = {f"stress_{s}": ca.SX.sym(f"stress_{s}") for s in range(one.memory_size)}
    rest = {name: ca.SX.sym(name) for name in ("turn", "lever", "limit")}
    shared = ca.SX.sym("shared", SHARED)
    # The step does not need the moment.
    coefficients = ca.vertcat(rest["lever"], rest["limit"], 0, shared)
    after = one.advance(ca.vertcat(*stresses.values()), rest["turn"], coefficients)
    return {**stresses, **rest, "shared": shared}, after, found, calls[0] if calls else None


def bristle_step_functions(model: Model) -> Functions:
    """The step of a bristle, what it follows of the turn, and its derivatives."""
    inputs, after, found, searched = _bristle_step_expressions(model)
    follow = ca.jtimes(after, inputs["turn"], ca.SX(1))
    partials = ca.jacobian(after, ca.vertcat(*inputs.values()))
    functions, given = {}, inputs
    if searched is not None:
        given = {**inputs, "found": found}
        log_speed = ca.SX.sym("log_speed")
        sought = log_speed_search(1, 2).expand()(*searched)
        results = ca.vertcat(*solver_outputs_at_log_speed(1).expand()(*searched, log_speed))
        functions["seek"] = _dense_function("seek", inputs, {"log_speed": sought})
        functions["find"] = _dense_function(
            "find", {**inputs, "log_speed": log_speed}, {"found": results}
        )
    outputs: dict[str, Any] = {"after": after, "follow": follow}
    return functions | {
        "tangent": _dense_function("tangent", given, outputs),
        "advance": _dense_function("advance", given, outputs, partials=partials),
    }


def series_element_functions(deflection: ca.Function) -> Functions:
    """The deflection of what is in series, its derivatives, and its balance with a linear patch."""
    size = deflection.numel_in(1)
    M, elements, along = ca.SX.sym("M"), ca.SX.sym("elements", size), ca.SX.sym("elements_by", size)
    slope, rigid = ca.SX.sym("slope"), ca.SX.sym("rigid")
    turn = deflection.expand()(M, elements)
    inputs = {"M": M, "elements": elements}
    balanced = build_linear_patch_balance(deflection).expand()(rigid, slope, elements)
    return {
        "deflection": _dense_function("deflection", inputs, {"turn": turn}),
        "compliance": _dense_function("compliance", inputs, {"by_torque": ca.jacobian(turn, M)}),
        "deflection_along": _dense_function(
            "deflection_along", inputs | {"elements_by": along},
            {"turn_by": ca.jtimes(turn, elements, along)},
        ),
        "balance": _dense_function(
            "balance", {"rigid": rigid, "slope": slope, "elements": elements}, {"M": balanced}
        ),
    }  # fmt: skip


def _dense_function(
    name: str, inputs: dict[str, Any], outputs: dict[str, Any], **sparse: ca.SX
) -> ca.Function:
    """A Function whose outputs are dense, but for the last ones: of these C has the nonzeros."""
    dense = {output: ca.densify(value) for output, value in outputs.items()}
    return named_function(name, inputs, dense | sparse, cse=True)
