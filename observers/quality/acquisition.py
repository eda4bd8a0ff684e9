"""Acquisition: friction found among hypotheses from any prior, before an estimator tracks it.

A filter linearises about its prior, and at mu = 1 the torque says nothing of ice. While nothing is
known, `observers.quality.mu_over_k_hypotheses` estimates friction; this module concludes from its
verdict when friction is handed over to the estimator, with which uncertainty, and what the output is
until then.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, symbols, vector_of
from observers.measurement.measurement_model import MeasurementModel, has_gear_friction
from observers.measurement.torque_error import forgetting_factor, is_known
from observers.protocol import OUTPUT, Status
from observers.quality.acquisition_handover import handover_vector, may_hand_over, states_handed_over
from observers.quality.hysteresis_branches import (
    START,
    TRACK,
    build_all_branches_update,
    loads_of_branches,
    relative_mu_sensitivity,
)
from observers.quality.mu_and_scale_from_hypotheses import (
    VERDICT,
    build_hypotheses_verdict,
    build_mu_std_from_torque_scale,
)
from observers.quality.mu_over_k_hypotheses import (
    MAX_MODEL_ERROR,
    RATIOS,
    SETTINGS,
    build_hypotheses_update,
    build_torque_error_variance,
    gear_friction_input_sizes,
    search_layout,
)
from observers.quality.sample_screening import has_flag
from observers.quality.wrong_units_or_signs import MAX_TYRE_FRICTION
from symbolic.named_and_buffered_functions import named_function, output_if

HANDED = 3.0
"""Factor on the model error in the deviation of ln mu at handover [1]: it does not average out."""
MAX_MODEL_VARIANCE = 1.0
"""Upper limit of the variance of ln mu from the model's error [1]."""
SHRINK = 4.0
"""Model errors that ln s is uncertain by [1]."""
DOUBT_LIMIT, MAX_DOUBT = 2.0, 10.0
"""Unexplained independent samples from which on the status is INCONSISTENT, and the most that count."""
HOPELESS = 8.0
"""Independent samples not explained after which friction is acquired anew."""
FAILED_FOR_LONG = 9.0
"""Independent samples not explained from which on a model is taken to be wrong on any ground."""
FAILED = 2
"""`again` where the model had explained no torque before: it is doubted at the next handover."""
OVER = 2
"""`phase` after the search."""
PROVED = 3
"""`confirmed` of a model that has explained the torque for long."""
FORGIVING = 10.0
"""Explained independent samples over which that count fades."""
OWN = (
    *("acquiring", "phase", "scale", "excess", "F_N", "F_N_first", "load", "load_at_rest"),
    *("squares", "weight", "doubt", "again", "streak", "lost", "predicted", "predicted_before"),
    *("confirmed", "lasting", "patch_psi"),
)
"""Whether friction is being acquired; 1 where the verdict is due, `OVER` after the search; s that the
torque is divided by [1]; what s adds to the relative deviation of mu [1]; last load, the first one, and
the loads of `build_equivalent_contact` [N]; sum of the squares of the innovations, and that of their
weights; independent samples that were not explained; 1 after a change of the ground, or `FAILED`;
torques in a row, computed from the steering torque, that friction does not explain, and 1 where friction
is acquired anew; torques predicted at the last two of them [N m]; 1 once the model has explained torque
since the handover, 2 where nothing lasted, `PROVED` where it has for long; smoothed innovation [N m];
angle behind the gaps in series with the patch [rad]."""
SWINGS = 1.25
"""Friction of the present rate over that of rest from which on a model of it is believed only after a
turn back [1]: until then a wrong law of speed and another stiffness look alike."""
KEPT = (Status.MISSING, Status.HELD, Status.RESET)
"""Flags of the estimator that count while friction is acquired."""


@dataclass(frozen=True)
class EquivalentPatch:
    """The declared patch that a model comes closest to, for acquisition.

    Functions take stiffness and friction as inputs, so that those of a model serve every rig.
    """

    stiffness: float = 1.0  # Its k over that of the model's parameters [1].
    friction: float = 1.0  # Its mu over the model's [1].
    misfit: float = 0.0  # Least share of the torque by which both differ [1].
    # Share of the full slide beyond which memory keeps nothing of an earlier mu [1].
    memoryless_share: float = 0.0


DECLARED_PATCH = EquivalentPatch()


@cache
def build_hypothesis_search_step(gear: bool = False) -> ca.Function:
    """One torque while friction is acquired: weighed, or the verdict is given, in turn, phase 0 and 1.

    So a sample takes half the work. loads (2,) are those at the present rate and at rest [N], tyre is k,
    a and e; M_z [N m] is NaN where nothing is measured; added is the variance of the way to it [N^2
    m^2]; with a gear, dry is a further input; counted is 1 where the torque was weighed. Hypotheses
    beside the likeliest, so many to each side, are weighed.
    """
    inputs = symbols(
        ca.MX, search=search_layout(gear).size, verdict=len(VERDICT), phase=1, beside=1, psi=1, F_N=1,
        loads=2, M_z=1, added=1, tyre=3, limits=len(SETTINGS), **gear_friction_input_sizes(gear),
    )  # fmt: skip
    search, verdict, phase, beside, psi, F_N, loads, M_z, added, tyre, limits, *dry = inputs.values()
    parts, numbers = search_layout(gear).split(search), named(SETTINGS, limits)
    known = ca.logic_and(is_known(psi), is_known(M_z))
    torque = ca.if_else(known, M_z, 0)
    at = ca.if_else(is_known(psi), psi, named(TRACK, parts["track"])["extreme"])
    size, _, _ = build_torque_error_variance()(torque, F_N, tyre[1], 0, 0, 1, 0)
    was = named(TRACK, parts["track"])
    turned = (was["extreme"] - at) * was["direction"]
    # Within the angle's noise of the farthest angle, the wheel may or may not have turned back.
    uncertain = ca.logic_and(turned > 0, turned <= numbers["psi_noise"])
    # At rest that noise is no turn: the torque tells its zero.
    away = ca.fabs(at - was["origin"])
    rests = ca.logic_and(was["direction"] == 0, away <= START * numbers["psi_noise"])
    at = ca.if_else(rests, was["origin"], at)
    counts = ca.logic_and(ca.logic_and(known, phase == 0), ca.logic_not(uncertain))
    track, points, turns, share = build_all_branches_update()(
        parts["track"], parts["points"], at, torque, size, numbers["psi_noise"], counts
    )
    after = named(TRACK, track)
    _, variance, noisy = build_torque_error_variance()(
        torque, F_N, tyre[1], added, after["reach"], share, numbers["error"]
    )
    variance = variance + sum((d[1] ** 2 / share for d in dry), ca.MX(0))
    carried = loads_of_branches(after, loads)
    weighed = (parts["hypotheses"], beside, turns, carried, torque, variance, share, tyre, *dry)
    hypotheses = output_if(counts, build_hypotheses_update(gear), weighed, parts["hypotheses"])
    after["explained"] += ca.if_else(counts, noisy, 0)
    judged = (hypotheses, after["explained"], after["reach"], limits)
    found = {"track": vector_of(TRACK, after), "points": points, "hypotheses": hypotheses}
    outputs = {
        "search_next": search_layout(gear).join(found),
        "verdict_next": output_if(phase == 1, build_hypotheses_verdict(gear), judged, verdict),
        "share": share,
        "counted": counts,
    }
    return named_function("search", inputs, outputs)


@cache
def build_acquisition_decision(
    patch: EquivalentPatch, measurement_model: MeasurementModel
) -> ca.Function:
    """A sample while friction is acquired; the handover is in the order of `handover_names`.

    turns is the number of turning points in use, counted 1 where a torque was weighed, share what it is
    worth; friction is the patch's; M_z and added are as for `build_hypothesis_search_step`.
    """
    is_scaled, states = bool(measurement_model.scaled), states_handed_over(measurement_model.states)
    inputs = symbols(
        ca.SX, own=len(OWN), verdict=len(VERDICT), output=len(OUTPUT), widest=1, turns=1, counted=1,
        share=1, M_z=1, added=1, tyre=3, limits=len(SETTINGS), friction=1,
    )  # fmt: skip
    own, limits = named(OWN, inputs["own"]), named(SETTINGS, inputs["limits"])
    verdict, output = named(VERDICT, inputs["verdict"]), named(OUTPUT, inputs["output"])
    error = ca.fmin(limits["error"], MAX_MODEL_ERROR) ** 2
    # A model's error does not average out: where mu moves the torque little, it moves mu much.
    given = (inputs["widest"], ca.exp(verdict["log_ratio"]), own["load"], inputs["tyre"])
    by_error = error / relative_mu_sensitivity(*given) ** 2
    sample = {"M_z": inputs["M_z"], "added": inputs["added"], "error": error}
    told = (own, verdict, output, limits, sample, verdict["variance"] + by_error)
    zero, gear = is_scaled * verdict["zero"], "gear" in states
    decided = may_hand_over(*told, zero, memoryless_share=patch.memoryless_share, gear=gear)
    if patch.misfit > 0:
        swings = own["load"] > SWINGS * own["load_at_rest"]
        decided = ca.logic_and(decided, ca.logic_not(ca.logic_and(inputs["turns"] == 1, swings)))
    spread, doubtful = limits["stiffness_std"] ** 2, verdict["var_log_gain"] + SHRINK**2 * error
    # A model that was found knows its k better than the declared patch that stands for it does.
    log_scale = is_scaled * (patch.misfit == 0) * verdict["log_gain"] * spread / (spread + doubtful)
    excess = build_mu_std_from_torque_scale(patch.misfit > 0, measurement_model.gain_share)
    doubt = leaky_unexplained_count(
        own["doubt"], inputs["counted"] * inputs["share"], verdict["unexplained"]
    )
    failed = decided * (own["again"] == FAILED)
    after = own | {
        "acquiring": ca.logic_not(decided),
        # Without a torque there is nothing to give a verdict on.
        "phase": ca.if_else(own["phase"] == 1, 0, inputs["counted"]),
        "scale": ca.if_else(decided, ca.exp(log_scale), 1),
        "excess": excess(inputs["verdict"], inputs["limits"]),
        **dict.fromkeys(("squares", "weight", "streak", "confirmed", "lasting"), 0),
        "doubt": ca.fmax(doubt, HOPELESS * failed),
        "lost": doubt > HOPELESS,
    }
    variance = verdict["variance"] + ca.fmin(HANDED**2 * by_error, MAX_MODEL_VARIANCE)
    log_mu = verdict["log_mu"] - ca.log(after["scale"] * inputs["friction"])
    means = {"log_mu": log_mu, "stiffness": 1}
    means |= {name: verdict[of] / after["scale"] for name, of in (("M_0", "zero"), ("gear", "gear"))}
    covariances = {"log_mu_log_mu": variance, "M_0_M_0": verdict["var_zero"]}
    if gear:
        covariances |= _gear_handover_covariances(verdict, after["scale"], spread, doubtful)
    results = _acquisition_output(after, own, verdict, output, log_mu, variance, limits)
    outputs = {
        "own_next": vector_of(OWN, after),
        "handover": handover_vector(states, means, covariances),
        "result": vector_of(OUTPUT, results),
    }
    return named_function("conclude", inputs, outputs, cse=True)


def _gear_handover_covariances(
    verdict: Parts, scale: Expression, spread: Expression, doubtful: Expression
) -> Parts:
    """Covariances of ln mu, stiffness, M_0 and the gear's friction, torques divided by s."""
    return {
        "stiffness_stiffness": spread * doubtful / (spread + doubtful),
        "log_mu_M_0": verdict["log_mu_zero"] / scale,
        "log_mu_gear": verdict["log_mu_gear"] / scale,
        "M_0_M_0": verdict["var_zero"] / scale**2,
        "M_0_gear": verdict["zero_gear"] / scale**2,
        "gear_gear": verdict["var_gear"] / scale**2,
    }


def leaky_unexplained_count(doubt: Expression, share: Expression, wrong: Expression) -> Expression:
    """Update the count of unexplained independent samples; explained ones reduce it."""
    more = ca.fmin(MAX_DOUBT, doubt + share)
    return ca.if_else(wrong, more, doubt * forgetting_factor(share, FORGIVING))


def _acquisition_output(
    after: Parts, own: Parts, verdict: Parts, output: Parts, log_mu: Expression, variance: Expression,
    limits: Parts,
) -> Parts:  # fmt: skip
    """The output while friction is acquired, in torques as they were measured."""
    mu = ca.exp(log_mu) * after["scale"]
    mu = ca.fmax(limits["least"], ca.fmin(limits["greatest"], mu))
    relative = ca.sqrt(variance + limits["mu_floor"] ** 2 + after["excess"] ** 2)
    grown = mu / output["mu"]
    stays = after["acquiring"]
    flags = {flag: has_flag(output["status"], flag) for flag in KEPT}
    flags |= {
        Status.BOUND: ca.logic_or(mu <= limits["least"], mu >= limits["greatest"]),
        Status.INCONSISTENT: ca.logic_and(stays, verdict["unexplained"]),
        # What is handed over is yet to be confirmed.
        Status.ACQUIRING: ca.SX(1),
        Status.SUSPECT: ca.logic_or(
            ca.logic_and(stays, verdict["suspect"]), mu * (1 - 2 * relative) > MAX_TYRE_FRICTION
        ),
    }
    return {
        "mu": mu,
        "mu_std": relative * mu,
        "M_z_predicted": output["M_z_predicted"] * own["scale"],
        "mu_eff": output["mu_eff"] * grown,
        "mu_eff_std": relative * output["mu_eff"] * grown,
        "M_slide": output["M_slide"] * grown,
        "nis": output["nis"],
        "status": sum(ca.if_else(holds, int(flag), 0) for flag, holds in flags.items()),
    }


def supervision_symbols(gear: bool) -> dict[str, ca.MX]:
    """Inputs of a sample of the supervision, while friction is acquired and afterwards."""
    return symbols(
        ca.MX, search=search_layout(gear).size, verdict=len(VERDICT), own=len(OWN), output=len(OUTPUT),
        psi=1, M_z=1, interval=1, added=1, tyre=3, limits=len(SETTINGS), friction=1,
        **gear_friction_input_sizes(gear),
    )  # fmt: skip


@cache
def build_acquisition_step(patch: EquivalentPatch, measurement_model: MeasurementModel) -> ca.Function:
    """A sample while friction is acquired, from the torque to what is handed over.

    Inputs of `supervision_symbols` -> (search, verdict, own, handover, output).
    """
    gear = has_gear_friction(measurement_model)
    inputs = supervision_symbols(gear)
    search, verdict, own, output, psi, M_z, _, added, tyre, limits, friction, *dry = inputs.values()
    numbers = named(OWN, own)
    search, verdict, share, counted = build_hypothesis_search_step(gear)(
        search, verdict, numbers["phase"], len(RATIOS), psi, numbers["F_N"],
        ca.vertcat(numbers["load"], numbers["load_at_rest"]), M_z, added, tyre, limits, *dry,
    )  # fmt: skip
    track = named(TRACK, search_layout(gear).split(search)["track"])
    path = (track["widest"], track["count"])
    conclude = build_acquisition_decision(patch, measurement_model)
    results = conclude(own, verdict, output, *path, counted, share, M_z, added, tyre, limits, friction)
    return ca.Function("acquire", [*inputs.values()], [search, verdict, *results])
