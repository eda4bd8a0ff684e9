"""One sample of a window as casadi Functions: prediction, elimination, substitution, acceptance.

`observers.estimators.mhe` maps them over the window in Python; generated C loops over the same
Functions, see `observers.embedded.estimators.compact_mhe`. The linear least-squares problem of the
window, which is solved along its chain, is to minimise over x_1 ... x_N

    |x_1 - mean|^2 / P  +  sum_i w_i (z_i - H_i' x_i)^2  +  sum_i |x_{i+1} - A_i x_i - b_i|^2 / Q_i

Forward elimination is the Kalman filter on UDU factors of the covariance, back substitution the smoother
of Bryson and Frazier. Together they give the solution of Rauch, Tung and Striebel without inverting a
covariance: states that are known exactly, or that are constant, are no special case. The work grows with
N, not with N^3.

Sources: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445; Bryson, Frazier, Smoothing for linear and
nonlinear dynamic systems, Proc. Optimum System Synthesis Conf. (1963).
"""

from functools import cache

import casadi as ca

from observers.estimators.ekf_mhe_step_terms import clip_to_bounds
from observers.layout import Expression, named, symbols, symbols_of_inputs
from observers.measurement.measurement_model import CLEAN, RIG, ROWS, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import (
    build_linearised_measurement,
    build_linearised_motion,
    slope_states,
    state_index,
)
from observers.quality.outlier_or_ground_change import huber_weight
from observers.tuning import TUNING_FIELDS
from observers.udu import predict_covariance, symbolic_covariance_from_udu, update_covariance
from symbolic.named_and_buffered_functions import named_function


@cache
def build_kalman_step(states: int) -> ca.Function:
    """One measurement and the motion to the next sample.

    (mean, factor, z, H, weight, A, b, Q) -> (mean_next, factor_next, x, P, K, score): mean and factor at
    the next sample; filtered mean x (n,) and covariance P (n, n) at this one; the gain, and the
    innovation over its variance. weight is the inverse variance of z, 0 where z is missing.
    """
    n = states
    inputs = symbols(ca.SX, mean=n, factor=(n, n), z=1, H=n, weight=1, A=(n, n), b=n, Q=n)
    mean, factor, z, H, weight, A, b, Q = inputs.values()
    updated, K, share = update_covariance(factor, H, weight)
    innovation = z - ca.dot(H, mean)
    x = mean + K * innovation
    outputs = {
        "mean_next": A @ x + b,
        "factor_next": predict_covariance(updated, A, Q),
        "x": x,
        "P": symbolic_covariance_from_udu(updated),
        "K": K,
        "score": share * innovation,
    }
    return named_function("kalman_update", inputs, outputs, cse=True)


@cache
def build_bryson_frazier_step(states: int) -> ca.Function:
    """(costate, x, P, H, K, score, A) -> (costate_before, smoothed).

    costate (n,) is that of the next sample, 0 at the newest; x to A as of `build_kalman_step` at this
    sample.
    """
    n = states
    inputs = symbols(ca.SX, costate=n, x=n, P=(n, n), H=n, K=n, score=1, A=(n, n))
    costate, x, P, H, K, score, A = inputs.values()
    propagated = A.T @ costate
    before = propagated - H * (ca.dot(K, propagated) + score)
    outputs = {"costate_before": before, "smoothed": x - P @ propagated}
    return named_function("back_substitution", inputs, outputs)


@cache
def build_state_prediction(measurement_model: MeasurementModel) -> ca.Function:
    """(x, P, M_z, slopes, last, now, rig, tuning) -> (x_next, P_next, Q): prediction to now."""
    motion = build_linearised_motion(measurement_model)
    n, given = len(measurement_model.states), symbols_of_inputs(motion)
    x_next, A, Q, _ = motion(*given.values())
    P = ca.MX.sym("P", n, n)
    outputs = {"x_next": x_next, "P_next": A @ P @ A.T + ca.diag(Q), "Q": Q}
    return named_function("prediction", {"x": given.pop("x"), "P": P, **given}, outputs)


@cache
def build_forward_elimination(measurement_model: MeasurementModel) -> ca.Function:
    """Forward elimination of one sample, linearised about x; results up to score as `build_kalman_step`.

    Rows are in the order of `ROWS`. The motion out of the newest sample does not matter: any row does
    for row_next.
    """
    n = len(measurement_model.states)
    inputs = symbols(
        ca.MX, mean=n, factor=(n, n), x=n, M_z=1, slopes=len(slope_states(measurement_model)),
        row=len(ROWS), row_next=len(ROWS), rig=len(RIG), tuning=len(TUNING_FIELDS),
    )  # fmt: skip
    mean, factor, x, M_z, slopes, row, row_next, rig, tuning = inputs.values()
    now, now_next = (vector[: len(CLEAN)] for vector in (row, row_next))
    innovation, H, weight, _, huber_scale, _ = build_linearised_measurement(measurement_model)(
        x, M_z, slopes, now, rig, tuning
    )
    weight = weight * huber_weight(innovation, huber_scale) * row[ROWS.index("accepted")]
    _, A, Q, b = build_linearised_motion(measurement_model)(x, M_z, slopes, now, now_next, rig, tuning)
    Q[state_index(measurement_model)] += row_next[ROWS.index("jump")]
    results = build_kalman_step(n)(mean, factor, innovation + ca.dot(H, x), H, weight, A, b, Q)
    names = ("mean_next", "factor_next", "filtered", "P", "K", "score", "H", "A")
    outputs = dict(zip(names, (*results, H, A), strict=True))
    return named_function("forward", inputs, outputs).expand("forward", {"cse": True})


@cache
def build_back_substitution(measurement_model: MeasurementModel) -> ca.Function:
    """Back substitution of one sample: the costate before it, and its states x within their bounds.

    costate is that of the next sample, 0 at the newest; the others come from
    `build_forward_elimination`.
    """
    n = len(measurement_model.states)
    inputs = symbols(
        ca.MX, costate=n, filtered=n, P=(n, n), K=n, score=1, H=n, A=(n, n), tuning=len(TUNING_FIELDS)
    )
    costate, filtered, P, K, score, H, A, tuning = inputs.values()
    before, smoothed = build_bryson_frazier_step(n)(costate, filtered, P, H, K, score, A)
    x = clip_to_bounds(measurement_model, smoothed, tuning)
    outputs = {"costate_before": before, "x": x}
    return named_function("backward", inputs, outputs).expand("backward", {"cse": True})


@cache
def build_acceptance_update() -> ca.Function:
    """(accepted, jump, age, test, variance) -> (accepted_next, jump_next) of a sample in the window.

    age is 0 for the newest sample; test is accepted, reset and run of the newest one, see
    `observers.quality.outlier_or_ground_change`; variance is that of ln mu on an unknown ground. After a
    change of the ground the whole run is accepted, and ln mu jumps before its first sample; where that
    is not behind the window's oldest sample see `arrival_variance_increment`.
    """
    inputs = symbols(ca.SX, accepted=1, jump=1, age=1, test=3, variance=1)
    accepted, jump, age, test, variance = inputs.values()
    newest, reset, run = named(("accepted", "reset", "run"), test).values()
    in_run = ca.logic_and(reset, age < run)
    first = ca.logic_and(reset, age == run - 1)
    accepted = ca.if_else(in_run, 1, ca.if_else(age == 0, newest, accepted))
    jump = ca.if_else(first, variance, jump)
    return named_function("acceptance", inputs, {"accepted_next": accepted, "jump_next": jump})


def arrival_variance_increment(
    window: int, reset: Expression, run: Expression, variance: Expression
) -> Expression:
    """Increment of the variance of ln mu in the arrival: a change before the window's oldest sample."""
    return ca.if_else(run >= window, reset * variance, 0)


def has_not_converged(
    measurement_model: MeasurementModel, x: Expression, before: Expression, P: Expression
) -> Expression:
    """True where the last Gauss-Newton step moved ln mu by more than its standard deviation."""
    at = state_index(measurement_model)
    return (x[at] - before[at]) ** 2 > P[at, at]
