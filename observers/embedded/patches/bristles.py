"""The bristle patch in compact C, `templates/patches/bristles.c`: tables, and the effects.

One loop over the bristles advances them, with their derivatives by mu and, where it is a state, by k.
What the effects change enters as C of their own expressions (`symbolic.Effect`): once a sample what is
the same for all bristles, and for each bristle its pressure, where the patch grows, and the factors on
its limit. An effect of a user's own needs nothing else. Where nothing depends on the sample, pressure is
a table.
"""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.special import wrightomega

from observers.embedded.patches.patch_code import LinearisedPatch, PatchCode, mhe_window_length
from observers.embedded.patches.patch_effects import TERMS, PatchEffects
from observers.embedded.scalar_type import SINGLE, Real
from observers.estimators.model_observer import ModelObserver
from observers.measurement.motion_and_torque_jacobians import angle_is_state
from symbolic import Model
from symbolic.bristle_patch import SPAN
from symbolic.bristle_slip import REFERENCE_SPEED, REST_SPEED
from symbolic.compilation.scalar_c import c_function, c_struct_array
from symbolic.elements_in_series import BALANCE_STEPS
from symbolic.patch_moment_by_zones import full_slide_arm

OMEGA = (-12, 24)
"""Arguments between which Wright's function is a table; it is e^x before."""
OMEGA_KNOTS_PER_UNIT = 4
OMEGA_FAR, OMEGA_SPARSE = 32, 32
"""Knots beyond, so many times as far apart; after them it is x - ln x ..."""
MAX_GROUP_SIZE, MIN_GROUPS = 5, 16
"""Single precision searches a turn on one bristle of each group: largest group, fewest groups."""


def has_bristles(observer: ModelObserver) -> bool:
    """True for a model that needs bristles."""
    return type(observer.model) is Model and not observer.model.uses_exact_patch


def bristle_patch_code(observer: ModelObserver, real: Real) -> PatchCode:
    """The patch of an observer for which `has_bristles` holds."""
    effects, window = PatchEffects(observer), mhe_window_length(observer)
    terms = bristle_placeholders(effects, real)
    functions = {"sample_terms": effects.sample_terms(), "initial_memory": effects.initial_memory()}
    if terms["grows"]:
        functions["pressure_at"] = effects.pressure()
    if terms["limited"]:
        functions["limit_factor"] = effects.build_friction_factor_by_speed()
    if (deflection := effects.build_series_deflection()) is not None:
        functions["deflection"] = deflection
    written = [c_function(name, function, real.c_type) for name, function in functions.items()]
    table = bristle_constants(effects, terms)
    by_k = terms["by_k"]
    arrays = (2 + by_k) * len(terms["parts"]) + terms["compliant"]
    numbers = effects.memory_size + 4 + by_k + terms["compliant"] * (5 + 3 * by_k + terms["relaxation"])
    kept = ["M_z", "by_mu", "mu", *(("by_k", "stiffness", "nominal") if by_k else ())]
    kept += ["angle", "by_angle"] if angle_is_state(observer.measurement_model) else []
    tried = bristle_group_table_c(table, terms["coarse"], real) if terms["coarse"] else ""
    return PatchCode(
        observer=observer,
        real=real,
        torque_model=LinearisedPatch(by_stiffness=by_k, slides=True),
        functions="\n".join([c_struct_array("bristle", table, real.c_type), tried, *written]),
        templates=("patches/bristles.c", *(("patches/bristles_window.c",) if window else ())),
        type_template="patches/bristles_type.c",
        terms=terms | {"stiff": repr(float(-(table["moment"] * table["lever"]).sum()))},
        k=repr(float(observer.values["k"])),
        bytes=int(real.size * (arrays * effects.numeric_patch.bristle_count + numbers)),
        kept=f"    {real.c_type} {', '.join(f'{name}[{window}]' for name in kept)};\n",
        kept_bytes=len(kept) * real.size,
        follows_mu=True,
        takes_rig=False,
    )


def bristle_placeholders(effects: PatchEffects, real: Real) -> dict[str, Any]:
    """Values of the placeholders of the templates."""
    patch, rig, deflection = (
        effects.numeric_patch,
        effects.observer.rig,
        effects.build_series_deflection(),
    )
    traits, log_reference = patch.traits, float(np.log(REFERENCE_SPEED))
    branched, compliant = traits.relaxation is not None, deflection is not None
    creep = 0.0 if traits.creep is None else float(traits.creep)
    slide = patch.effective_friction(effects.inputs_at_unit_mu(speed=rig.slide_rate))
    return {
        "bristles": patch.bristle_count, "rig_at_run_time": False, "effects": True,
        "own": effects.memory_size,
        "angle_is_state": angle_is_state(effects.observer.measurement_model),
        "by_k": "stiffness" in effects.observer.states, "parts": ["q", *["branch"] * branched],
        "a": repr(float(rig.a)), "terms": TERMS,
        "times_k": " * stiffness" if "stiffness" in effects.observer.states else "",
        "gained": "(1.0 + terms[TERM_GAIN]) * " if branched else "",
        "shared": " * limits->share" if branched else "",
        "branched": " + branch" if branched else "",
        "branched_by_mu": " + branch_by_mu" if branched else "",
        "relaxation": branched, "creep": creep, "grows": traits.growth is not None,
        "limited": bool(traits.limits), "static_limit": traits.growth is None and not traits.limits,
        "compliant": compliant, "evaluations": 7,
        "coarse": _bristles_per_group(patch.bristle_count) if compliant and real is SINGLE else 0,
        "balance_steps": 1 if _is_linear(deflection) else BALANCE_STEPS,
        "rest_factor": 1 + creep * float(np.log(REST_SPEED / REFERENCE_SPEED)),
        "log_reference": log_reference, "offset": log_reference - (1 / creep if creep else 0.0),
        "rest_speed": REST_SPEED, "single": real is SINGLE, **_wright_omega_table(),
        # Effective friction over mu where the patch has one length, else empty [1].
        "slide": "" if traits.growth is not None else repr(float(slide)),
        "slide_rate": repr(float(rig.slide_rate)),
        # Torque of q / a over the full-slide torque of the declared patch under 1 N.
        "slide_weight": repr(1.0 / float(full_slide_arm(rig.a, rig.e))),
    }  # fmt: skip


def _wright_omega_table() -> dict[str, Any]:
    """The table of Wright's function: a cubic of the place between two knots."""
    near = (OMEGA[1] - OMEGA[0]) * OMEGA_KNOTS_PER_UNIT
    apart = np.repeat([1, OMEGA_SPARSE], [near, OMEGA_FAR]) / OMEGA_KNOTS_PER_UNIT
    w = wrightomega(OMEGA[0] + np.concatenate([[0], np.cumsum(apart)]))
    slopes, rise = w / (1 + w), np.diff(w)
    bend = (slopes[:-1] + slopes[1:]) * apart - 2 * rise
    first = slopes[:-1] * apart
    cubics = np.column_stack([w[:-1], first, rise - first - bend, bend])
    return {
        "omega": [", ".join(f"{number:.9g}" for number in cubic) for cubic in cubics],
        "omega_from": float(OMEGA[0]), "omega_near": near, "omega_far": OMEGA_FAR,
        "omega_sparse": OMEGA_SPARSE,
        "omega_knots_per_unit": float(OMEGA_KNOTS_PER_UNIT),
    }  # fmt: skip


def bristle_constants(effects: PatchEffects, terms: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Values of every bristle that do not depend on the sample.

    Lever arm over a [1] and moment of q / a [N m]; limit of q / a over mu and load [1/N], or the
    place over a [1] where the patch grows.
    """
    patch = effects.numeric_patch
    geometry = replace(patch, traits=replace(patch.traits, limits=()))
    numbers = np.asarray(geometry.coefficients(effects.inputs_at_unit_mu())).ravel()
    n = patch.bristle_count
    tables = {"lever": numbers[:n], "moment": numbers[2 * n : 3 * n]}
    if terms["grows"]:
        return tables | {"place": SPAN * np.asarray(patch.nodes_and_weights()[0]).ravel()}
    tables["pressure"] = pressure = numbers[n : 2 * n]
    if terms["creep"] and terms["static_limit"]:
        tables |= {
            "inverse_pressure": 1 / pressure, "log_pressure": OMEGA_KNOTS_PER_UNIT * np.log(pressure),
        }  # fmt: skip
    return tables


def _bristles_per_group(bristles: int) -> int:
    """Bristles in each of these groups: an odd divisor of their number."""
    divisors = [n for n in range(1, MAX_GROUP_SIZE + 1, 2) if bristles % n == 0]
    return max(n for n in divisors if n == 1 or bristles // n >= MIN_GROUPS)


def bristle_group_table_c(table: dict[str, NDArray[np.float64]], coarse: int, real: Real) -> str:
    """C of the bristles on which a turn is searched: their indices, and the moment of each group."""
    moments = table["moment"].reshape(-1, coarse).sum(axis=1)
    rows = [f"    {{{coarse * i + coarse // 2}, {m!r}}}," for i, m in enumerate(moments.tolist())]
    return (
        f"typedef struct {{\n    int32_t at;\n    {real.c_type} moment;\n}} tried_t;\n\n"
        f"static const tried_t tried_of[{len(rows)}] = {{\n" + "\n".join(rows) + "\n};\n"
    )


def _is_linear(deflection: ca.Function | None) -> bool:
    if deflection is None:
        return True
    M_z, F_N = ca.SX.sym("M_z"), ca.SX.sym("F_N")
    return not ca.depends_on(deflection(M_z, F_N)[1], M_z)
