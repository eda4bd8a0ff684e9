"""One sample of a window as casadi Functions: prediction, elimination, substitution, acceptance.

`observers.mhe_step` maps them over the window in Python; generated C loops over the same Functions, see
`observers.embedded.estimators`.
"""

from functools import cache
from typing import Any

import casadi as ca

from observers.innovation_gate import huber_weight
from observers.linearisation import build_measurement, build_motion, state_index
from observers.measurement_model import CLEAN, ROWS, MeasurementModel
from observers.model_observer import clip_to_bounds
from observers.tuning import TUNING_FIELDS
from observers.window_least_squares import build_back_substitution, build_window_update

Expression = Any


@cache
def build_prediction(measurement_model: MeasurementModel) -> ca.Function:
    """(x, P, M_z, slopes, last, now, rig, tuning) -> (x_next, P_next, Q): prediction to now."""
    motion = build_motion(measurement_model)
    x, M_z, slopes, last, now, rig, tuning = (
        ca.MX.sym(name, *motion.size_in(name)) for name in motion.name_in()
    )
    P = ca.MX.sym("P", x.numel(), x.numel())
    x_next, A, Q, _ = motion(x, M_z, slopes, last, now, rig, tuning)
    return ca.Function(
        "prediction",
        [x, P, M_z, slopes, last, now, rig, tuning],
        [x_next, A @ P @ A.T + ca.diag(Q), Q],
        ["x", "P", "M_z", "slopes", "last", "now", "rig", "tuning"],
        ["x_next", "P_next", "Q"],
    )


@cache
def build_forward(measurement_model: MeasurementModel) -> ca.Function:
    """Forward elimination of one sample, linearised about x.

    (mean, factor, x, M_z, slopes, row, row_next, rig, tuning) -> (mean_next, factor_next, filtered, P,
    K, score, H, A), as of `build_window_update`; rows in the order of `ROWS`. The motion out of the
    newest sample does not matter: any row does for row_next.
    """
    measurement, motion = build_measurement(measurement_model), build_motion(measurement_model)
    update = build_window_update(len(measurement_model.states))
    x, M_z, slopes, _, rig, tuning = (
        ca.MX.sym(name, *measurement.size_in(name)) for name in measurement.name_in()
    )
    mean, factor = (ca.MX.sym(name, *update.size_in(name)) for name in ("mean", "factor"))
    row, row_next = ca.MX.sym("row", len(ROWS)), ca.MX.sym("row_next", len(ROWS))
    now, now_next = (vector[: len(CLEAN)] for vector in (row, row_next))
    innovation, H, weight, _, huber_scale, _ = measurement(x, M_z, slopes, now, rig, tuning)
    weight = weight * huber_weight(innovation, huber_scale) * row[ROWS.index("accepted")]
    _, A, Q, b = motion(x, M_z, slopes, now, now_next, rig, tuning)
    Q[state_index(measurement_model)] += row_next[ROWS.index("jump")]
    mean_next, factor_next, filtered, P, K, score = update(
        mean, factor, innovation + ca.dot(H, x), H, weight, A, b, Q
    )
    return ca.Function(
        "forward",
        [mean, factor, x, M_z, slopes, row, row_next, rig, tuning],
        [mean_next, factor_next, filtered, P, K, score, H, A],
        ["mean", "factor", "x", "M_z", "slopes", "row", "row_next", "rig", "tuning"],
        ["mean_next", "factor_next", "filtered", "P", "K", "score", "H", "A"],
    ).expand("forward", {"cse": True})


@cache
def build_backward(measurement_model: MeasurementModel) -> ca.Function:
    """Back substitution of one sample.

    (costate, filtered, P, K, score, H, A, tuning) -> (costate_before, x).

    costate is that of the next sample, 0 at the newest; the others come from `build_forward`. x is
    within its bounds.
    """
    back = build_back_substitution(len(measurement_model.states))
    costate, filtered, P, H, K, score, A = (
        ca.MX.sym(name, *back.size_in(name)) for name in back.name_in()
    )
    tuning = ca.MX.sym("tuning", len(TUNING_FIELDS))
    before, smoothed = back(costate, filtered, P, H, K, score, A)
    return ca.Function(
        "backward",
        [costate, filtered, P, K, score, H, A, tuning],
        [before, clip_to_bounds(measurement_model, smoothed, tuning)],
        ["costate", "filtered", "P", "K", "score", "H", "A", "tuning"],
        ["costate_before", "x"],
    ).expand("backward", {"cse": True})


@cache
def build_acceptance() -> ca.Function:
    """(accepted, jump, age, test, variance) -> (accepted_next, jump_next) of a sample in the window.

    age is 0 for the newest sample; test is accepted, reset and run of the newest one, see
    `observers.innovation_gate`; variance is that of ln mu on an unknown ground. After a change of the
    ground the whole run is accepted, and ln mu jumps before its first sample; where that is not behind
    the window's oldest sample see `arrival_jump`.
    """
    names = ["accepted", "jump", "age", "test", "variance"]
    accepted, jump, age, test, variance = inputs = [
        ca.SX.sym(name, 3 if name == "test" else 1) for name in names
    ]
    newest, reset, run = ca.vertsplit(test)
    in_run = ca.logic_and(reset, age < run)
    first = ca.logic_and(reset, age == run - 1)
    accepted = ca.if_else(in_run, 1, ca.if_else(age == 0, newest, accepted))
    jump = ca.if_else(first, variance, jump)
    return ca.Function("acceptance", inputs, [accepted, jump], names, ["accepted_next", "jump_next"])


def arrival_jump(window: int, reset: Expression, run: Expression, variance: Expression) -> Expression:
    """Increment of the variance of ln mu in the arrival: a change before the window's oldest sample."""
    return ca.if_else(run >= window, reset * variance, 0)


def is_unsettled(
    measurement_model: MeasurementModel, x: Expression, before: Expression, P: Expression
) -> Expression:
    """True where the last Gauss-Newton step moved ln mu by more than its standard deviation."""
    at = state_index(measurement_model)
    return (x[at] - before[at]) ** 2 > P[at, at]
