"""Test of the innovation: outliers, and changes of the ground.

An innovation beyond the gate is rejected. After `Tuning.reset_after` in a row, all to one side, the
ground has changed: the variance that two grounds differ by is added to that of ln mu, and the samples
are accepted. What stays within the gate is watched by `observers.quality.slow_change_and_misfit_alarms`,
and friction by direction by `observers.quality.friction_change_by_stroke`.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
section 5.4 for the test of the innovation; Huber, Robust Statistics (1981), for the loss.
"""

from functools import cache

import casadi as ca

from observers.layout import Expression, Parts, named, outputs_of, symbols, symbols_of_inputs
from observers.measurement.directional_friction import EXCHANGED, OTHER
from observers.measurement.measurement_model import CLEAN, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import build_linearised_measurement, state_index
from observers.measurement.torque_error import JITTER
from observers.quality.friction_change_by_stroke import (
    AT_REST,
    STROKE_CHANGE,
    change_monitor_fields,
    has_friction_changed,
    predict_reference_friction,
    reset_reference_friction,
    update_change_statistic,
)
from observers.quality.slow_change_and_misfit_alarms import (
    CHANGE,
    MIN_SAMPLES,
    MONITOR,
    build_innovation_monitor,
)
from observers.tuning import REFERENCE_STEP, TUNING_FIELDS
from symbolic.named_and_buffered_functions import named_function

COUNTS = ("streak", "resets")
"""Innovations beyond the gate in a row, with the sign of their side; changes of the ground so far."""


@cache
def build_innovation_gate() -> ca.Function:
    """(innovation, H_P_H, weight, huber_scale, counts, tuning) -> (accepted, reset, run, counts_next).

    H_P_H is the part of the innovation's variance that the states cause; weight 0 where the measurement
    is missing; huber_scale as in `Measurement`. accepted and reset are 0 or 1; run is how many samples
    in a row, this one included, lie beyond the gate.
    """
    inputs = symbols(
        ca.SX, innovation=1, H_P_H=1, weight=1, huber_scale=1, counts=len(COUNTS),
        tuning=len(TUNING_FIELDS),
    )  # fmt: skip
    innovation, H_P_H, weight, huber_scale, counts, tuning = inputs.values()
    streak, resets = ca.vertsplit(counts)
    limits = named(TUNING_FIELDS, tuning)
    measured = weight > 0
    deviation = ca.sqrt(innovation_variance(H_P_H, weight, huber_scale))
    beyond = ca.logic_and(measured, ca.fabs(innovation) > limits["gate"] * deviation)
    side = ca.if_else(innovation > 0, 1, -1)
    run = ca.if_else(beyond, ca.fmax(streak * side, 0) + 1, 0)
    reset = run >= limits["reset_after"]
    accepted = ca.logic_or(ca.logic_not(beyond), reset)
    streak = ca.if_else(measured, ca.if_else(reset, 0, run * side), streak)
    counts_next = ca.vertcat(streak, resets + reset)
    outputs = {"accepted": accepted, "reset": reset, "run": run, "counts_next": counts_next}
    return named_function("gate", inputs, outputs)


@cache
def build_innovation_test(measurement_model: MeasurementModel) -> ca.Function:
    """The innovation of a sample at predicted states x (n,) of covariance P (n, n), and its test.

    (x, P, M_z, slopes, now, counts, monitor, rig, tuning) -> the outputs of
    `build_linearised_measurement`; H_P_H, the part of the innovation's variance that the states cause;
    nis, innovation^2 over `innovation_variance`, NaN where it is missing; missing; accepted: within the
    gate, or a reset; reset: the ground has changed; run, samples in a row beyond the gate, this one
    included, 1 at an alarm of the monitor, which is a reset too; counts_next as `COUNTS`; inconsistent:
    the model does not explain the torque; untested: too few independent samples to say so; evidence:
    log-likelihood ratio of a change that is no alarm yet; lag of ln mu behind friction that changes
    steadily; monitor_next as `change_monitor_fields`. What is a question is answered by 0 or 1.
    """
    measurement = build_linearised_measurement(measurement_model)
    n = len(measurement_model.states)
    given = symbols_of_inputs(measurement)
    x, M_z, slopes, now, rig, tuning = given.values()
    inputs = {"x": x, **symbols(ca.MX, P=(n, n)), "M_z": M_z, "slopes": slopes, "now": now}
    size = len(change_monitor_fields(measurement_model))
    inputs |= symbols(ca.MX, counts=len(COUNTS), monitor=size) | {"rig": rig, "tuning": tuning}
    results = outputs_of(measurement, *given.values())
    innovation, H, weight = (results[name] for name in ("innovation", "H", "weight"))
    huber_scale, independent = results["huber_scale"], results["independent"]
    change, interval = CHANGE, now[CLEAN.index("interval")]
    if OTHER in measurement_model.states:
        change, tuning = STROKE_CHANGE, _tuning_for_sample_interval(tuning, interval)
    H_P_H, missing = ca.dot(H, inputs["P"] @ H), weight <= 0
    accepted, reset, run, counts_next = build_innovation_gate()(
        innovation, H_P_H, weight, huber_scale, inputs["counts"], tuning
    )
    variance = innovation_variance(H_P_H, weight, huber_scale)
    at, monitor = state_index(measurement_model), inputs["monitor"]
    share, quiet = independent * ca.logic_not(missing), accepted * ca.logic_not(reset)
    # An outlier is one to the estimate; to the reference, a change would be one.
    weight_left = weight * accepted * huber_weight(innovation, huber_scale, H_P_H)
    correction, learnt = _log_mu_correction(inputs["P"][:, at], at, H, H_P_H, weight_left, innovation)
    alarm, inconsistent, monitor_next = build_innovation_monitor(change)(
        innovation, H[at], variance, share, quiet, ca.logic_not(reset) * correction,
        ca.fmax(reset, learnt), monitor[: len(MONITOR)], tuning,
    )  # fmt: skip
    if OTHER in measurement_model.states:
        kept = predict_reference_friction(monitor[len(MONITOR) :], x[at], inputs["P"][at, at], now)
        about = innovation + H[at] * (x[at] - kept["reference"])
        kept = update_change_statistic(kept, about, H[at], weight_left, share * accepted)
        alarm, monitor_next = _add_stroke_comparison_alarm(kept, now, alarm, reset, monitor_next, tuning)
    counts_next[COUNTS.index("resets")] += alarm
    results |= {
        "H_P_H": H_P_H,
        "nis": ca.if_else(missing, float("nan"), innovation**2 / variance),
        "missing": missing,
        "accepted": accepted,
        "reset": reset + alarm,
        "run": ca.fmax(run, alarm),
        "counts_next": counts_next,
        "inconsistent": inconsistent,
        "untested": monitor_next[MONITOR.index("samples")] < MIN_SAMPLES,
        "evidence": ca.fmax(monitor_next[0], monitor_next[1]),
        "lag": monitor_next[MONITOR.index("lag")],
        "monitor_next": monitor_next,
    }
    return named_function("innovation", inputs, results)


def _log_mu_correction(
    P: ca.MX, at: int, H: ca.MX, H_P_H: ca.MX, weight: ca.MX, innovation: ca.MX
) -> tuple[ca.MX, ca.MX]:
    """Correction of ln mu, by its column of P [1]; share of its variance that the sample takes."""
    along = ca.dot(P, H)
    gain = along * weight / (1 + H_P_H * weight)
    return gain * innovation, gain * along / P[at]


def _add_stroke_comparison_alarm(
    kept: Parts, now: ca.MX, alarm: ca.MX, reset: ca.MX, monitor: ca.MX, tuning: ca.MX
) -> tuple[ca.MX, ca.MX]:
    """The alarm and the monitor where friction has directions, with `REFERENCE` after the sample."""
    sample = named(CLEAN, now)
    turns = sample["travel"] > AT_REST * sample["interval"]
    alarm = ca.logic_or(alarm, ca.logic_and(turns, has_friction_changed(kept, tuning)))
    quiet, after = ca.logic_not(ca.logic_or(alarm, reset)), named(MONITOR, monitor)
    kept_on = {"rise": quiet, "fall": quiet, "lag": quiet * ca.logic_not(sample[EXCHANGED])}
    after |= {name: keeps * after[name] for name, keeps in kept_on.items()}
    return alarm, ca.MX(ca.vertcat(*after.values(), reset_reference_friction(kept, reset + alarm)))


def _tuning_for_sample_interval(tuning: ca.MX, interval: ca.MX) -> ca.MX:
    """The tuning with `reset_after` as long as so many samples of 10 ms at any rate above."""
    longer = ca.MX(tuning)
    longer[TUNING_FIELDS.index("reset_after")] *= ca.fmax(1, JITTER * REFERENCE_STEP / interval)
    return longer


def innovation_variance(
    H_P_H: Expression, inverse_variance: Expression, max_variance: Expression
) -> Expression:
    """Variance of one innovation, of that of its prediction and of an inverse variance of its error.

    A model error that lasts counts with its size, the greatest variance, not with its weight.
    """
    return H_P_H + ca.fmin(max_variance, 1 / ca.if_else(inverse_variance > 0, inverse_variance, 1))


def huber_weight(
    residual: Expression, huber_scale: Expression, prior_innovation_variance: Expression = 0
) -> Expression:
    """Share of the weight of a residual, at most 1, that makes its cost linear beyond Huber's scale.

    The variance H P H' of a residual at a predicted state widens the quadratic part.
    """
    return ca.fmin(1, ca.sqrt((huber_scale + prior_innovation_variance) / residual**2))
