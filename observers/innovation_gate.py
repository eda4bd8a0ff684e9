"""Test of the innovation: outliers, and changes of the ground.

An innovation beyond the gate is rejected. After `Tuning.reset_after` in a row, all to one side, the
ground has changed: the variance that two grounds differ by is added to that of ln mu, and the samples
are accepted. What stays within the gate is watched by `observers.innovation_monitor`.

Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
section 5.4 for the test of the innovation; Huber, Robust Statistics (1981), for the loss.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.innovation_monitor import MONITOR, build_monitor
from observers.layout import named
from observers.linearisation import build_measurement, state_index
from observers.measurement_model import MeasurementModel
from observers.tuning import TUNING_FIELDS

Expression = Any
COUNTS = ("streak", "resets")
"""Innovations beyond the gate in a row, with the sign of their side; changes of the ground so far."""


@cache
def build_gate() -> ca.Function:
    """(innovation, H_P_H, weight, huber_scale, counts, tuning) -> (accepted, reset, run, counts_next).

    H_P_H is the part of the innovation's variance that the states cause; weight 0 where the measurement
    is missing; huber_scale as in `Measurement`. accepted and reset are 0 or 1; run is how many samples
    in a row, this one included, lie beyond the gate.
    """
    names = ["innovation", "H_P_H", "weight", "huber_scale"]
    innovation, H_P_H, weight, huber_scale = symbols = [ca.SX.sym(name) for name in names]
    counts, tuning = ca.SX.sym("counts", len(COUNTS)), ca.SX.sym("tuning", len(TUNING_FIELDS))
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
    return ca.Function(
        "gate",
        [*symbols, counts, tuning],
        [accepted, reset, run, ca.vertcat(streak, resets + reset)],
        [*names, "counts", "tuning"],
        ["accepted", "reset", "run", "counts_next"],
    )


@cache
def build_innovation(measurement_model: MeasurementModel) -> ca.Function:
    """The innovation of a sample and its test, by name.

    (x, P, M_z, slopes, now, counts, monitor, rig, tuning) -> (innovation, H, weight, expected,
    huber_scale, independent, H_P_H, nis, missing, accepted, reset, run, counts_next, inconsistent,
    monitor_next), as of `build_measurement`, `build_gate` and `build_monitor`; x (n,) and P (n, n) are
    predicted. nis is innovation^2 over `innovation_variance`, NaN where it is missing. An alarm of the
    monitor is a reset with a run of this one sample.
    """
    measurement = build_measurement(measurement_model)
    symbols = {name: ca.MX.sym(name, *measurement.size_in(name)) for name in measurement.name_in()}
    P, counts = (
        ca.MX.sym("P", symbols["x"].numel(), symbols["x"].numel()),
        ca.MX.sym("counts", len(COUNTS)),
    )
    monitor = ca.MX.sym("monitor", len(MONITOR))
    innovation, H, weight, expected, huber_scale, independent = measurement(*symbols.values())
    H_P_H, missing = ca.dot(H, P @ H), weight <= 0
    accepted, reset, run, counts_next = build_gate()(
        innovation, H_P_H, weight, huber_scale, counts, symbols["tuning"]
    )
    variance = innovation_variance(H_P_H, weight, huber_scale)
    nis = ca.if_else(missing, float("nan"), innovation**2 / variance)
    alarm, inconsistent, monitor_next = build_monitor()(
        innovation, H[state_index(measurement_model)], variance, independent * ca.logic_not(missing),
        accepted * ca.logic_not(reset), monitor, symbols["tuning"],
    )  # fmt: skip
    counts_next[COUNTS.index("resets")] += alarm
    test = (accepted, reset + alarm, ca.fmax(run, alarm), counts_next, inconsistent, monitor_next)
    inputs = {"x": symbols.pop("x"), "P": P, **symbols, "counts": counts, "monitor": monitor}
    order = ["x", "P", "M_z", "slopes", "now", "counts", "monitor", "rig", "tuning"]
    return ca.Function(
        "innovation",
        [inputs[name] for name in order],
        [innovation, H, weight, expected, huber_scale, independent, H_P_H, nis, missing, *test],
        order,
        [
            *measurement.name_out(),
            "H_P_H",
            "nis",
            "missing",
            *build_gate().name_out(),
            "inconsistent",
            "monitor_next",
        ],
    )


def innovation_variance(H_P_H: Expression, weight: Expression, huber_scale: Expression) -> Expression:
    """Variance of one innovation; a model error that lasts counts with its size, not with its weight."""
    return H_P_H + ca.fmin(huber_scale, 1 / ca.if_else(weight > 0, weight, 1))


def huber_weight(
    residual: Expression, huber_scale: Expression, prior_innovation_variance: Expression = 0
) -> Expression:
    """Factor on the weight of a residual, 1 or less, that makes its cost linear beyond Huber's scale.

    The variance H P H' of a residual at a predicted state widens the quadratic part.
    """
    return ca.fmin(1, ca.sqrt((huber_scale + prior_innovation_variance) / residual**2))
