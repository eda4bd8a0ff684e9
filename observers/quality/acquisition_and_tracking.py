"""Supervision of an estimator: acquisition before it tracks, and the scale of the torque while it does.

`build_step_with_acquisition` puts both around the step of any `ModelObserver`, which does not know it.

- While friction is acquired, `observers.quality.acquisition` rules: its ln mu and M_0 replace those of
  the estimator after every sample. A change of the ground (`Status.RESET`) begins another acquisition.
- After the handover the aligning torque is divided by s, the stiffness over the declared one, and the
  results are multiplied by it: the torque of the patch is homogeneous in (mu, k).
- What s is off by is k's error or the torque's, which nothing tells apart: it widens the band. The
  search goes on, to know s better, until friction is confirmed or the model is doubted.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.layout import Expression, Layout, Parts, named, symbols_of_inputs, vector_of
from observers.measurement.measurement_model import (
    MAX_ZERO_DEVIATIONS,
    RIG,
    MeasurementModel,
    has_gear_friction,
    impute_load,
)
from observers.measurement.torque_error import is_known, share_of_full_slide
from observers.patch.patch_protocol import EQUIVALENT, split_theta_rig_tuning
from observers.protocol import OUTPUT, SAMPLE, Status
from observers.quality.acquisition import (
    FAILED,
    FAILED_FOR_LONG,
    OVER,
    OWN,
    PROVED,
    EquivalentPatch,
    build_acquisition_step,
    build_hypothesis_search_step,
    supervision_symbols,
)
from observers.quality.acquisition_handover import (
    handover_names,
    insert_acquired_state,
    newest_sample_values,
    newest_state,
    states_handed_over,
)
from observers.quality.branch_consistency_and_band import build_tracking_consistency
from observers.quality.equivalent_patch import (
    build_equivalent_contact,
    build_patch_angle,
    effect_torques_of_sample,
    newest_signals,
)
from observers.quality.hysteresis_branches import TRACK, build_present_branch_update, sliding_onset_turn
from observers.quality.mu_and_scale_from_hypotheses import VERDICT, build_mu_std_from_torque_scale
from observers.quality.mu_over_k_hypotheses import (
    RESTART_STD,
    SETTINGS,
    VAGUE,
    acquisition_settings,
    build_hypothesis_search_restart,
    build_hypothesis_search_start,
    search_layout,
)
from observers.quality.sample_screening import has_flag
from observers.tuning import TUNING_FIELDS
from symbolic import GEOMETRY, SIGNALS, Model, full_slide_torque
from symbolic.named_and_buffered_functions import named_function, output_if

MAY_HAVE_MOVED = 3.0
"""Factor on the deviations of s and of the zero where friction is acquired anew as an innovation lasted:
what moved shows as another ground does [1]."""
CONFIRMS = 0.5
"""Least turn of an informative branch, over the turn at which the patch begins to slide [1]."""
BESIDE = 2
"""Hypotheses to each side of the likeliest that are weighed after the handover [1]."""
AFTERWARDS = 4.0
"""Independent samples not explained that a new acquisition begins with at most."""
DRY = ("dry", "dry_std")
PREDICTED = OUTPUT.index("M_z_predicted")


@cache
def supervision_layout(measurement_model: MeasurementModel) -> Layout:
    """State of the supervision."""
    block = max(len(measurement_model.torque_state), 1)
    own = Layout.of(own=len(OWN), block=block, verdict=len(VERDICT))
    return Layout.of(*own.fields, *search_layout(has_gear_friction(measurement_model)).fields)


def initial_supervision(
    measurement_model: MeasurementModel, psi: Expression, F_N: Expression, zero_std: Expression
) -> dict[str, Expression]:
    """The parts of the state at the first sample; zero_std is that of the torque's zero [N m]."""
    gear = has_gear_friction(measurement_model)
    start = build_hypothesis_search_start(gear)(
        psi, 1, VAGUE, 0, zero_std, *_gear_friction_std(measurement_model)
    )
    search = search_layout(gear).split(ca.MX(start))
    # The first verdict, before any torque counts, is the prior.
    own: dict[str, Expression] = dict.fromkeys(OWN, 0)
    own |= {"acquiring": 1, "phase": 1, "scale": 1, "F_N": F_N, "F_N_first": F_N, "patch_psi": psi}
    return {"own": vector_of(OWN, own), **search}


def _gear_friction_std(measurement_model: MeasurementModel) -> tuple[float, ...]:
    return (measurement_model.gear_spread,) if has_gear_friction(measurement_model) else ()


@cache
def build_tracking_step(patch: EquivalentPatch, measurement_model: MeasurementModel) -> ca.Function:
    """A sample while the estimator tracks, with inputs and outputs as of `build_acquisition_step`.

    The search for s goes on until friction is confirmed or the model is doubted.
    """
    gear, states = has_gear_friction(measurement_model), states_handed_over(measurement_model.states)
    inputs = supervision_symbols(gear)
    search, verdict, own, output, psi, M_z, interval, added, tyre, limits, friction, *dry = (
        inputs.values()
    )
    parts, numbers = search_layout(gear).split(search), named(OWN, own)
    at = ca.if_else(is_known(psi), psi, named(TRACK, parts["track"])["extreme"])
    known = is_known(named(OUTPUT, output)["nis"])
    least = CONFIRMS * sliding_onset_turn(named(OUTPUT, output)["mu"], numbers["load"], tyre)
    track, share = build_present_branch_update()(
        parts["track"], at, named(SETTINGS, limits)["psi_noise"], least, known
    )
    path = named(TRACK, track)
    turn = ca.fabs(path["extreme"] - path["origin"])
    loads = ca.vertcat(numbers["load"], numbers["load_at_rest"])
    torque = (psi, numbers["F_N"], loads, M_z, added, tyre, limits, *dry)
    idle = (search_layout(gear).join({**parts, "track": track}), verdict, 0, 0)
    search, verdict, _, counted = output_if(
        numbers["phase"] < OVER, build_hypothesis_search_step(gear),
        (search, verdict, numbers["phase"], BESIDE, *torque), *idle,
    )  # fmt: skip
    # While the search goes on, a branch tells something only where its torque was weighed.
    share = ca.if_else(numbers["phase"] < OVER, counted, 1) * share
    excess = build_mu_std_from_torque_scale(patch.misfit > 0, measurement_model.gain_share)
    judged = ca.logic_and(numbers["phase"] == 1, ca.logic_not(named(VERDICT, verdict)["unexplained"]))
    numbers["excess"] = output_if(judged, excess, (verdict, limits), numbers["excess"])
    own, result = build_tracking_consistency(patch, measurement_model)(
        vector_of(OWN, numbers), verdict, output, share, turn, interval, M_z, added, counted, tyre,
        limits, friction,
    )  # fmt: skip
    nothing = ca.MX(ca.DM.zeros(len(handover_names(states))))
    return ca.Function("follow", [*inputs.values()], [search, verdict, own, nothing, result])


@cache
def build_step_with_acquisition(
    step: ca.Function, model: Model, measurement_model: MeasurementModel, parts: Layout,
    patch: EquivalentPatch,
) -> ca.Function:  # fmt: skip
    """The step of an estimator, supervised.

    Its state has the parts of the estimator, on which `step` works, and those of `supervision_layout`.
    The numbers of the declared patch that stands for the model are among the constants.
    """
    added_parts = supervision_layout(measurement_model)
    inputs = symbols_of_inputs(step)
    inputs["state"] = state = ca.MX.sym("state", parts.size + added_parts.size)
    before, now = added_parts.split(state[parts.size :]), named(SAMPLE, inputs["sample"])
    own = named(OWN, before["own"])
    theta, rig, tuning = split_theta_rig_tuning(model, inputs["constants"])
    fields, scaled = named(TUNING_FIELDS, tuning), measurement_model.scaled
    stiffness, friction = ca.vertsplit(inputs["constants"][-len(EQUIVALENT) :])
    tyre = ca.vertcat(theta[model.coordinate_names.index("k")] * stiffness, rig[0], rig[1])
    given = ca.vertcat(*(now[n] / own["scale"] if n == scaled else now[n] for n in SAMPLE))
    after, output = step(state[: parts.size], given, inputs["constants"])
    (own["F_N"], _, lifted), names = impute_load(now, own), measurement_model.torque_state
    last = named(names, before["block"]) if names else {}
    sensed = {**now, "M_z": ca.if_else(lifted, float("nan"), now["M_z"])}
    block, psi, M_z, added = measurement_model.observed_torque(last, sensed, rig, tuning)
    # The declared patch stands for the model's patch alone. Of a model with effects, s is 1.
    at_torque, at_sample = effect_torques_of_sample(model, measurement_model, parts, after, theta, psi)
    M_z, output[PREDICTED] = M_z - at_torque, output[PREDICTED] - at_sample
    M_z = ca.if_else(lifted, float("nan"), M_z)
    zero_std = _torque_zero_std(own["F_N"], rig, fields)
    psi = _patch_angle_behind_gaps(model, own, psi, M_z, added + zero_std**2, theta)
    tyre[1] = _half_length(model, own, newest_signals(measurement_model, parts, after), theta, rig)
    reset = has_flag(named(OUTPUT, output)["status"], Status.RESET)
    changed, tracked = ca.logic_or(reset, own["lost"]), own["acquiring"] == 0
    restarts, anew = ca.logic_and(changed, tracked), ca.logic_or(own["lost"], reset * tracked)
    own["again"] = ca.if_else(restarts, _restart_reason(own), own["again"])
    limits = acquisition_settings(fields, patch.misfit, own["again"] > 0)
    searched = search_layout(gear := has_gear_friction(measurement_model))
    was = named(OUTPUT, parts.split(state[: parts.size])["output"])
    ground = (_torque_at_reset(reset, M_z, gear), was["M_slide"], tyre)
    zero = own["scale"] * newest_state(parts, measurement_model, after, "M_0")
    known = _search_restart_moments(own, before["verdict"], tracked, zero, zero_std, scaled)
    search = _restart_search_if(anew, searched.join(before), (*ground, *known), measurement_model)
    own["phase"] = ca.if_else(anew, 0, own["phase"])
    own["doubt"] = ca.if_else(anew, ca.fmin(own["doubt"], AFTERWARDS), own["doubt"])
    own["lost"], own["acquiring"] = ca.MX(0), ca.logic_or(own["acquiring"], changed)
    search, verdict, own_next, handover, output = _build_acquire_or_track(measurement_model, patch)(
        own["acquiring"], search, before["verdict"], vector_of(OWN, own), output, psi, M_z,
        newest_sample_values(parts, after, ("interval",)), added, tyre, limits, friction,
        *([newest_sample_values(parts, after, DRY)] if gear else []),
    )  # fmt: skip
    output[PREDICTED] += at_sample
    handed = insert_acquired_state(parts, measurement_model.states, after, handover)
    after = ca.if_else(own["acquiring"], handed, after)
    after[parts.places["output"][0]] = output
    state_next = {
        "own": own_next, "verdict": verdict, **searched.split(search),
        "block": vector_of(names, block) if names else ca.MX(0),
    }  # fmt: skip
    outputs = {"state_next": ca.vertcat(after, added_parts.join(state_next)), "output": output}
    return named_function(step.name(), inputs, outputs)


def _torque_zero_std(F_N: Expression, rig: Expression, tuning: Parts) -> Expression:
    """Standard deviation of the torque's zero at this load [N m]."""
    slide, declared = full_slide_torque(F_N, rig[0]), named(RIG, rig)["zero_std"]
    return slide * share_of_full_slide(declared, slide, tuning["zero_std"])


def _half_length(
    model: Model, own: dict[str, Any], signals: Expression, theta: Expression, rig: Expression
) -> Expression:
    """The half-length [m] of `build_equivalent_contact`, whose loads are kept in own."""
    own["load"] = own["load_at_rest"] = own["F_N"]
    if (contact := build_equivalent_contact(model)) is None:
        return rig[0]
    signals[SIGNALS.index("F_N")] = own["F_N"]
    loads, half_length = contact.call([signals, theta, rig[: len(GEOMETRY)]])
    own["load"], own["load_at_rest"] = ca.vertsplit(loads)
    return half_length


def _patch_angle_behind_gaps(
    model: Model, own: dict[str, Any], psi: Expression, M_z: Expression, variance: Expression,
    theta: Expression,
) -> Expression:  # fmt: skip
    """The angle of the patch behind the gaps of the model, kept in own; psi where it has none [rad]."""
    if (patch_angle := build_patch_angle(model)) is None:
        return psi
    own["patch_psi"] = patch_angle(own["patch_psi"], psi, M_z, variance, own["F_N"], theta)
    return ca.if_else(is_known(psi), own["patch_psi"], float("nan"))


def _build_acquire_or_track(measurement_model: MeasurementModel, patch: EquivalentPatch) -> ca.Function:
    """A sample while friction is acquired or while the estimator tracks, by its first input."""
    acquire = build_acquisition_step(patch, measurement_model)
    return ca.Function.if_else("supervise", acquire, build_tracking_step(patch, measurement_model))


def _restart_search_if(
    anew: Expression, search: Expression, begun: tuple[Expression, ...],
    measurement_model: MeasurementModel,
) -> Any:  # fmt: skip
    """The search; where it begins anew, on this ground, with these moments of s and of the zero."""
    known = (search, *begun, *_gear_friction_std(measurement_model))
    return output_if(
        anew, build_hypothesis_search_restart(has_gear_friction(measurement_model)), known, search
    )


def _restart_reason(own: Parts) -> Expression:
    """`again` of a new ground: a model that has failed for long is wrong, whatever the ground."""
    return ca.if_else(ca.logic_and(own["confirmed"], own["doubt"] < FAILED_FOR_LONG), 1, FAILED)


def _torque_at_reset(reset: Expression, M_z: Expression, gear: bool) -> Expression:
    """The torque that may tell a rise of friction [N m]; 0 for none, as beside a gear's friction."""
    return ca.if_else(ca.logic_and(reset, is_known(M_z)), M_z, 0) * (not gear)


def _search_restart_moments(
    own: Parts, verdict: Expression, tracked: Expression, zero: Expression, zero_std: Expression,
    scaled: str,
) -> tuple[Expression, ...]:  # fmt: skip
    """Mean and deviation of s [1] and of the torque's zero [N m] with which a search begins anew."""
    found, most = ca.exp(named(VERDICT, verdict)["log_gain"]), MAX_ZERO_DEVIATIONS * zero_std
    lasted = ca.logic_and(own["lost"], own["confirmed"] == PROVED)
    moved = ca.if_else(ca.logic_and(tracked, lasted), MAY_HAVE_MOVED, 1)
    scale = ca.if_else(tracked, found, own["scale"])
    # From the steering torque nothing tells s on ice anew: it stays known. Garbage may have moved the
    # zero far: it keeps its range.
    scale_std = ca.if_else(tracked, (moved if scaled else 1) * RESTART_STD, VAGUE)
    return scale, scale_std, ca.fmax(-most, ca.fmin(most, zero)), moved * zero_std
