"""Supervision in C: the Functions of `observers.quality.acquisition` around an estimator.

C loops over the hypotheses and calls one Function for each, see `templates/estimators/supervision.c`.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca

from observers.embedded.c_loops_over_vectors import c_function_with_loops
from observers.embedded.jinja_templates import ObserverBody, render
from observers.embedded.scalar_expansion import (
    ConstantSubstitution,
    Tunable,
    expand_with_constants,
    without_outputs,
)
from observers.embedded.scalar_type import Real
from observers.estimators.model_observer import ModelObserver
from observers.layout import named, symbols, vector_of
from observers.measurement.measurement_model import CLEAN, MIN_LOAD_SHARE, RIG, has_gear_friction
from observers.protocol import OUTPUT, SAMPLE
from observers.quality import (
    acquisition,
    acquisition_and_tracking,
    branch_consistency_and_band,
    hysteresis_branches,
    mu_and_scale_from_hypotheses,
    mu_over_k_hypotheses,
)
from observers.quality.acquisition_handover import covariance_pairs, handover_names, states_handed_over
from observers.quality.equivalent_patch import (
    build_added_torque,
    build_equivalent_contact,
    build_patch_angle,
)
from observers.tuning import TUNING_FIELDS
from symbolic.bristle_patch import BristlePatch
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_moment_by_zones import corner_moment_and_derivative


def acquisition_functions(observer: ModelObserver, constants: ConstantSubstitution) -> list[ca.Function]:
    """The Functions that C calls beside those of the estimator; none without supervision."""
    if not observer.acquire:
        return []
    patch, model = observer.equivalent_patch, observer.measurement_model
    known = {"friction": [patch.friction]}
    follow = branch_consistency_and_band.build_tracking_consistency(patch, model)
    conclude = acquisition.build_acquisition_decision(patch, model)
    functions = [
        without_outputs(hysteresis_branches.build_all_branches_update(), {"turns"}).expand(
            "follow_turns", {"cse": True}
        ),
        hysteresis_branches.build_present_branch_update(),
        hysteresis_branches.build_new_ground_branches(),
        hysteresis_branches.build_sliding_onset_turn(),
        _build_stick_moment_beyond(observer, constants.tunable == "all"),
        mu_over_k_hypotheses.build_one_hypothesis_update(has_gear_friction(model)),
        mu_over_k_hypotheses.build_torque_error_variance(),
        expand_with_constants("follow_output", follow, known),
        mu_and_scale_from_hypotheses.build_mu_std_from_torque_scale(patch.misfit > 0, model.gain_share),
        expand_with_constants("conclude", conclude, known),
    ]
    theta = observer.constants[: len(observer.model.coordinate_names)].tolist()
    numbers = {"theta": theta, "geometry": [observer.rig.a, observer.rig.e]}
    for build in (build_added_torque, build_equivalent_contact, build_patch_angle):
        if (function := build(observer.model)) is not None:
            used = {name: numbers[name] for name in function.name_in() if name in numbers}
            functions.append(expand_with_constants(function.name(), function, used))
    return [*functions, _observe_torque(observer, constants)]


def _build_stick_moment_beyond(observer: ModelObserver, tunable: bool) -> ca.Function:
    """(z, a, e) -> moment that a stuck patch has beyond z, over k [m^3], `unit_corner_moment`."""
    inputs = symbols(ca.SX, z=1, a=1, e=1)
    z, *geometry = inputs.values()
    patch = observer.model.patch()
    varies = tunable or (isinstance(patch, BristlePatch) and patch.traits.growth is not None)
    given = geometry if varies else [ca.SX(observer.rig.a), ca.SX(observer.rig.e)]
    moment = corner_moment_and_derivative(z, *given)[0]
    return named_function("beyond", inputs, {"moment": moment}, cse=True)


def verdict_function_and_loop_c(
    observer: ModelObserver, real: Real, tunable: Tunable
) -> tuple[ca.Function, str]:
    """The verdict of the hypotheses, and its C as loops over them.

    Of its limits those are numbers that are the tuning's, without `tunable`.
    """
    gear = has_gear_friction(observer.measurement_model)
    function = mu_and_scale_from_hypotheses.build_hypotheses_verdict(gear)
    begin = len(observer.model.coordinate_names) + len(RIG)
    tuning = dict(zip(TUNING_FIELDS, observer.constants[begin:].tolist(), strict=False))
    names, count = ("mu", "mu_std", "stiffness_std"), len(mu_over_k_hypotheses.RATIOS)
    numbers = {mu_over_k_hypotheses.SETTINGS.index(name): tuning[name] for name in names}
    known = {} if tunable else {"limits": numbers}
    return function, c_function_with_loops("verdict_of", function, count, real.c_type, known)


def with_supervision(
    observer: ModelObserver, real: Real, terms: Mapping[str, Any], body: ObserverBody
) -> ObserverBody:
    """The code of an estimator with its supervision; as it is where that is switched off."""
    if not observer.acquire:
        return body
    values = {**terms, **_placeholders(observer, terms)}
    values |= _handover_indices(observer, is_window=bool(terms["window"]))
    sizes = {
        "own": len(acquisition.OWN), "verdict": len(mu_and_scale_from_hypotheses.VERDICT),
        "block": len(observer.measurement_model.torque_state),
        "track": len(hysteresis_branches.TRACK),
        "points": hysteresis_branches.POINTS * hysteresis_branches.PATHS, "result": len(OUTPUT),
    }  # fmt: skip
    fields = ", ".join(f"{name}[{size}]" for name, size in sizes.items() if size)
    parts = mu_over_k_hypotheses.hypothesis_fields(has_gear_friction(observer.measurement_model))
    rows, columns = len(mu_over_k_hypotheses.RATIOS), len(parts)
    return replace(
        body,
        stepping=f"{body.stepping}\n{render('estimators/supervision.c', values)}",
        private_fields=f"{body.private_fields}\n    {real.c_type} {fields}; /* of the supervision */\n"
        f"    {real.c_type} hypotheses[{rows}][{columns}];",
        bytes=body.bytes + (sum(sizes.values()) + rows * columns) * real.size,
        supervised=True,
        scaled=bool(observer.measurement_model.scaled),
    )


def _handover_indices(observer: ModelObserver, *, is_window: bool) -> dict[str, Any]:
    """Where the states that are handed over go, and their covariances, stored column by column."""
    states, handed = observer.states, states_handed_over(observer.states)
    at = {name: i for i, name in enumerate(handover_names(handed))}
    pairs = [(states.index(a), states.index(b), f"{a}_{b}") for a, b in covariance_pairs(handed)]
    n, kind = len(states), "P" if is_window else "F"
    covariance = [{"index": i + n * j, "at": at[f"{kind}_{pair}"]} for i, j, pair in pairs]
    if is_window:
        covariance += [{"index": j + n * i, "at": at[f"P_{pair}"]} for i, j, pair in pairs if i < j]
    return {
        "handed": [{"index": states.index(name), "at": at[name]} for name in handed],
        "handed_covariance": covariance,
        "handed_factor": [{"index": i + n * j, "at": at[f"F_{pair}"]} for i, j, pair in pairs],
    }


def _observe_torque(observer: ModelObserver, constants: ConstantSubstitution) -> ca.Function:
    """(block, sample, again) -> (block_next, psi, M_z, added, limits)."""
    model, names = observer.measurement_model, observer.measurement_model.torque_state
    sizes = {"rig": len(RIG), "tuning": len(TUNING_FIELDS)}
    inputs = symbols(ca.SX, block=len(names), sample=len(SAMPLE), again=1, **sizes)
    block, sample, again, rig, tuning = inputs.values()
    observed = model.observed_torque(named(names, block), named(SAMPLE, sample), rig, tuning)
    after, psi, M_z, added = observed
    misfit = observer.equivalent_patch.misfit
    limits = mu_over_k_hypotheses.acquisition_settings(named(TUNING_FIELDS, tuning), misfit, again)
    outputs = {"block_next": vector_of(names, after), "psi": psi, "M_z": M_z, "added": added}
    function = named_function("observe_torque", inputs, {**outputs, "limits": limits})
    return constants.substitute_constants("observe_torque", function)


def _placeholders(observer: ModelObserver, terms: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the placeholders of `templates/estimators/supervision.c`."""
    patch = observer.equivalent_patch
    begin = len(observer.model.coordinate_names)
    places = {"k": observer.model.coordinate_names.index("k")}
    places |= {name: begin + i for i, name in enumerate(RIG)}
    places["zero_std"] = begin + len(RIG) + TUNING_FIELDS.index("zero_std")
    numbers = observer.constants.tolist()
    literal = {name: repr(float(numbers[at])) for name, at in places.items()}
    if terms["tunable"]:
        tuned = places if terms["tunable"] == "all" else ("zero_std",)
        literal |= {name: f"state->constants[{places[name]}]" for name in tuned}
    zero_std, states, model = observer.rig.zero_std, observer.states, observer.measurement_model
    gear = has_gear_friction(model)
    declared = f"{literal['zero_std']} * 0.375 * sample[2] * {literal['a']}"
    restart = f"limits[LIMIT_ZERO_STD] * 0.375 * state->own[OWN_F_N] * {literal['a']}"
    return {
        "acquisition": acquisition, "branches": hysteresis_branches, "hypotheses": mu_over_k_hypotheses,
        "tracking": acquisition_and_tracking, "verdicts": mu_and_scale_from_hypotheses, "gear": gear,
        "parts": mu_over_k_hypotheses.hypothesis_fields(gear),
        "added_torque": build_added_torque(observer.model) is not None,
        "contact": build_equivalent_contact(observer.model) is not None,
        "has_gap": build_patch_angle(observer.model) is not None,
        "gear_spread": repr(float(model.gear_spread)), "least_load": MIN_LOAD_SHARE,
        "interval": f"{terms['newest_last']}[{CLEAN.index('interval')}]",
        "dry": f"{terms['newest_last']}[{CLEAN.index('dry')}]",
        "dry_std": f"{terms['newest_last']}[{CLEAN.index('dry_std')}]",
        "block": len(model.torque_state), "handover": len(handover_names(states_handed_over(states))),
        "tyre": [f"{literal['k']} * {patch.stiffness!r}", literal["a"], literal["e"]],
        # Deviation of the torque's zero before the first sample, and on a new ground [N m].
        "zero_std": declared if zero_std is None else repr(zero_std),
        "restart_zero_std": restart if zero_std is None else repr(zero_std),
        "zero_state": f"{terms['newest_x']}[{states.index('M_0')}]" if "M_0" in states else "0.0",
    }  # fmt: skip
