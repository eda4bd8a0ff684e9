"""The filter in compact C, `templates/estimators/filter.c`.

It is the Function of `observers.estimators.ekf` on a patch whose torque is an input, expanded to
scalars, with the parameters as numbers.
"""

import casadi as ca

from observers.embedded.estimators.shared_step_functions import (
    TORQUE,
    EstimatorCode,
    effective_friction,
    function_of_symbols,
    initial_state_parts,
    sensitivity_retentions,
    stiffness_ratio_c,
)
from observers.embedded.patches.patch_code import PatchCode
from observers.embedded.scalar_expansion import (
    ConstantSubstitution,
    drop_unused_inputs,
    inputs_used,
    with_exponential_input,
)
from observers.estimators.ekf import build_ekf_step, ekf_layout
from observers.layout import Layout
from observers.measurement.directional_friction import EXCHANGED, OTHER
from observers.measurement.measurement_model import CLEAN
from observers.measurement.motion_and_torque_jacobians import angle_is_state, slope_states, state_index
from observers.patch.update import tyre_states
from observers.udu import symbolic_covariance_from_udu

PATCH = ("M_z", "slopes")
"""Parts of the state that the patch of C sets, not the step."""


def compact_ekf_code(patch: PatchCode, constants: ConstantSubstitution) -> EstimatorCode:
    """An `Ekf` of one linearisation on a patch of C."""
    observer, real = patch.observer, patch.real.c_type
    model, memory = (
        observer.measurement_model,
        [name for name, _, _ in patch.torque_model.memory_layout.fields],
    )
    parts = ekf_layout(patch.torque_model, model)
    step = _build_step(patch, constants, parts)
    # C keeps the parts that a step depends on.
    used = inputs_used(step)
    kept = Layout(tuple(field for field in parts.fields if field[0] in used - {"memory"}))
    names = [name for name, _, _ in kept.fields]
    step = drop_unused_inputs(step, {name for name, _, _ in parts.fields} - {*names, "memory"})
    begin = initial_state_parts("begin_filter", patch, parts, {name: f"first_{name}" for name in names})
    functions = [constants.substitute_constants("begin_filter", begin), step]
    if patch.follows_mu:
        factor = ca.MX.sym("factor", *parts.places["factor"][1])
        functions.append(
            sensitivity_retentions(
                observer, constants, factor, symbolic_covariance_from_udu(factor), predicted=True
            )
        )
    if angle_is_state(model) and patch.torque_model.slides:
        functions.append(effective_friction(patch))
    before = stiffness_ratio_c(model, "before->x")
    other = state_index(model, OTHER) if OTHER in model.states else 0
    mu_now = "mu_now" if other else "mu"
    given = {
        "M_z": "torque[M_Z]", "by_mu": "torque[BY_MU]", "mu": mu_now,
        "by_k": f"torque[BY_STIFFNESS] / {patch.k}", "k": f"{patch.k} * {before}",
        "slide": "slide[0]", "beside": "slide[1]",
    }  # fmt: skip
    by_state = {name: f"torque[{TORQUE[name]}]" for name in slope_states(model)}
    by_state["log_mu"] += " * output[OUT_MU]"
    fields = "".join(f"    {real} {part}[{rows * columns}];\n" for part, rows, columns in kept.fields)
    return EstimatorCode(
        template="estimators/filter.c",
        functions=functions,
        element_names={"memory": memory},
        terms={
            "first": [f"first->{name}" for name in names],
            "before": [f"before->{name}{'[0]' * (name == 'M_z')}" for name in names],
            "after": [f"after->{name}" for name in names if name not in PATCH],
            "walk": len(tyre_states(model)) ** 2, "stiffness_before": before,
            "stiffness_after": stiffness_ratio_c(model, "after->x"),
            "memory": [given[name] for name in memory], "slopes": list(by_state.values()), "window": 0,
            "newest_x": "state->filter[state->now].x", "newest_last": "state->filter[state->now].last",
            "x": "filter->x", "P": "filter->factor",
            "own_state": "filter->", "other": other, "mu_now": mu_now,
            "exchanged": CLEAN.index(EXCHANGED), "clean_dt": CLEAN.index("dt"),
        },
        types=f"/* The filter, see the code. */\ntypedef struct {{\n{fields}}} NAME_filter_t;\n\n",
        private_fields="    NAME_filter_t filter[2]; /* before and after a sample */\n"
        "    NAME_patch_t patch;",
        bytes=2 * kept.size * patch.real.size,
    )  # fmt: skip


def _build_step(patch: PatchCode, constants: ConstantSubstitution, parts: Layout) -> ca.Function:
    """(parts, memory, sample, exp of ln mu before it) -> (steps between, parts after, output)."""
    model = patch.observer.measurement_model
    step = build_ekf_step(patch.torque_model, model, 1, commented=True)
    before = {name: ca.MX.sym(name, rows * columns) for name, rows, columns in parts.fields}
    sample, vector = (ca.MX.sym(step.name_in(i), step.numel_in(i)) for i in (1, 2))
    *between, state_next, output = step(ca.vertcat(*before.values()), sample, vector)
    after = parts.split(state_next)
    outputs = dict(zip((step.name_out(i) for i in range(len(between))), between, strict=True))
    outputs |= {f"{n}_next": after[n] for n in before if n not in (*PATCH, "memory", "output")}
    memory = before.pop("memory")
    inputs = [*before.values(), memory, sample, ca.MX.sym("mu"), vector]
    flat = constants.substitute_constants(
        "filter", function_of_symbols("filter", inputs, **outputs, result=output)
    )
    return with_exponential_input(flat, ("x", state_index(model)), "mu")
