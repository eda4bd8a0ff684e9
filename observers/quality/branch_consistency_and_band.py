"""What follows from a sample while the estimator tracks: consistency by branches, and the band.

The innovations are judged by branches, which takes less travel than
`observers.quality.slow_change_and_misfit_alarms` does. Until they can be judged, friction stays
`Status.ACQUIRING`; a model that was found wrong stays doubted until it has explained as much as it had
not. Where a model has explained the torque for long and then does not, the ground has changed: friction
is acquired anew.
"""

from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, symbols, vector_of
from observers.measurement.measurement_model import MeasurementModel, has_gear_friction
from observers.measurement.torque_error import SENSIBLE, forgetting_factor
from observers.protocol import OUTPUT, Status
from observers.quality.acquisition import (
    DOUBT_LIMIT,
    HOPELESS,
    OVER,
    OWN,
    PROVED,
    EquivalentPatch,
    leaky_unexplained_count,
)
from observers.quality.innovation_attribution import (
    IN_A_ROW,
    innovation_of,
    range_of_last_predictions,
    smoothed_innovation_test,
    torque_variance_from_stiffness,
    update_deviation_streak,
)
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.quality.mu_over_k_hypotheses import SETTINGS
from observers.quality.sample_screening import has_flag, with_flag
from observers.quality.slow_change_and_misfit_alarms import (
    FORGETTING_SAMPLES,
    MAX_NORMALISED_SQUARE,
    MIN_SAMPLES,
)
from observers.quality.wrong_units_or_signs import MAX_TYRE_FRICTION
from symbolic.named_and_buffered_functions import named_function

MIN_WHILE_LASTING = 3.0
"""Lower limit of the count of unexplained independent samples while an innovation lasts [1]."""
EXCESS = 1.5
"""Mean square of the innovations by branches, over `Tuning.explained`, that is too much [1]."""
SAMPLES_TO_PROVE = 10.0
"""Independent samples that a model explains after the handover, before it is right on its ground."""
DOUBT_LEFT = 0.5
"""Unexplained independent samples that may be left by then: after one change that lasted, the model has
to explain more before another is believed."""
NEW_GROUND = 3.5
"""Unexplained independent samples, while an innovation lasts, after which a model that was right stands
on another ground."""
MIN_SQUARE_DIVISOR = 1e-12
"""Least divisor that is the square of an innovation [N^2 m^2]."""
SCALED = ("mu", "mu_std", "M_z_predicted", "mu_eff", "mu_eff_std", "M_slide")
"""Outputs that are proportional to the torque."""


@cache
def build_tracking_consistency(
    patch: EquivalentPatch, measurement_model: MeasurementModel
) -> ca.Function:
    """A sample while the estimator tracks, its output in torques as measured.

    turn is the present branch's [rad], interval as in `CLEAN` [s], counted 1 after a search.
    """
    # M_z that is computed from the steering torque is compared with the predicted one. The friction and
    # the return torque of a steering gear last too.
    is_computed, gear = not measurement_model.scaled, has_gear_friction(measurement_model)
    inputs = symbols(
        ca.SX, own=len(OWN), verdict=len(VERDICT), output=len(OUTPUT), share=1, turn=1, interval=1,
        M_z=1, added=1, counted=1, tyre=3, limits=len(SETTINGS), friction=1,
    )  # fmt: skip
    own, output = named(OWN, inputs["own"]), named(OUTPUT, inputs["output"])
    limits, known = named(SETTINGS, inputs["limits"]), output["nis"] < SENSIBLE
    share = ca.if_else(known, inputs["share"], 0)
    older = forgetting_factor(share, FORGETTING_SAMPLES)
    nis, by_k, lasts, clear = output["nis"], ca.SX(0), ca.SX(0), ca.SX(1)
    if is_computed or patch.misfit > 0 or not gear:
        by_k = torque_variance_from_stiffness(inputs, own, output, patch, scaled=not is_computed)
    if patch.misfit > 0 and not is_computed:
        square = ca.fmax(innovation_of(inputs, own, output) ** 2, MIN_SQUARE_DIVISOR)
        nis = nis * square / (square + by_k * nis)
    predicted = output["M_z_predicted"] * own["scale"] + named(VERDICT, inputs["verdict"])["zero"]
    if not gear:
        predictions = range_of_last_predictions(own, predicted) if is_computed else None
        own["lasting"], lasts, clear = smoothed_innovation_test(inputs, own, output, by_k, predictions)
    squares = older * own["squares"] + share * ca.if_else(known, ca.fmin(nis, MAX_NORMALISED_SQUARE), 0)
    weight = older * own["weight"] + share
    much = (weight >= MIN_SAMPLES) * (squares > EXCESS * limits["explained"] * weight)
    too_much = ca.logic_or(much, lasts)
    if is_computed:
        own |= update_deviation_streak(inputs, own, predicted, by_k, limits["error"])
        too_much = ca.logic_or(too_much, own["streak"] > IN_A_ROW / 2)
    wrong = ca.logic_or(too_much, has_flag(output["status"], Status.INCONSISTENT))
    doubt = ca.fmax(leaky_unexplained_count(own["doubt"], share, wrong), MIN_WHILE_LASTING * lasts)
    doubted = ca.logic_or(too_much, doubt > DOUBT_LIMIT)
    early = ca.logic_or(weight < MIN_SAMPLES, (own["confirmed"] < 2) * (1 - clear) * (1 - doubted))
    # A change that is too small or too slow for an alarm shows in an innovation that lasts.
    lasted = own["streak"] >= IN_A_ROW if is_computed else lasts * (doubt > NEW_GROUND)
    changed = ca.logic_and(own["confirmed"] == PROVED, lasted)
    doubt = ca.fmax(doubt, NEW_GROUND * changed)
    status = with_flag(output["status"], Status.INCONSISTENT, doubted)
    # These flags no estimator sets, and an alarm ends tracking before this.
    status += int(Status.ACQUIRING) * early + int(Status.RESET) * changed
    result = vector_of(OUTPUT, _tracking_output(own, output, status, limits))
    confirmed = _raise_confirmed(own, weight, doubt, wrong, clear, gear=gear)
    over = ca.logic_or(own["phase"] == OVER, ca.logic_or(confirmed >= 2, doubted))
    phase = ca.if_else(over, OVER, ca.if_else(own["phase"] == 1, 0, inputs["counted"]))
    after = own | {
        "squares": squares, "weight": weight, "doubt": doubt, "confirmed": confirmed, "phase": phase
    }  # fmt: skip
    # Once, if the ground changed while friction was acquired: a model that is wrong explains no ground.
    hopeless = (doubt > HOPELESS) * ca.logic_not(ca.logic_or(own["again"], confirmed))
    after["lost"] = ca.logic_or(hopeless, changed)
    outputs = {"own_next": vector_of(OWN, after), "result": result}
    return named_function("follow_output", inputs, outputs, cse=True)


def _raise_confirmed(
    own: Parts, weight: Expression, doubt: Expression, wrong: Expression, clear: Expression, *,
    gear: bool,
) -> Expression:  # fmt: skip
    """`confirmed` after a sample; behind a gear nothing is proved."""
    confirmed = ca.fmax(own["confirmed"], (weight >= MIN_SAMPLES) * (1 - wrong) * (1 + clear))
    proven = (confirmed == PROVED - 1) * (weight >= SAMPLES_TO_PROVE) * (doubt <= DOUBT_LEFT)
    return confirmed + proven * (not gear)


def _tracking_output(own: Parts, output: Parts, status: Expression, limits: Parts) -> Parts:
    """The output in torques as they were measured, its band with what the scale may be off by."""
    results = {name: output[name] * own["scale"] for name in SCALED}
    mu = ca.fmax(limits["least"], ca.fmin(limits["greatest"], results["mu"]))
    grown = ca.sqrt(1 + (own["excess"] * output["mu"] / output["mu_std"]) ** 2)
    std = results["mu_std"] * grown
    return results | {
        "mu": mu,
        "mu_std": std,
        "mu_eff_std": results["mu_eff_std"] * grown,
        "nis": output["nis"],
        "status": status + int(Status.SUSPECT) * (mu - 2 * std > MAX_TYRE_FRICTION),
    }
