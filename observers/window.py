"""One sample of the moving-horizon estimator as a casadi Function.

The window holds the last N samples, the states x_i at each of them, what the model remembers, and mean
and covariance of x_1 from all samples that have left (the arrival). Gauss-Newton steps reduce

    |x_1 - mean|^2 / P  +  sum_i |x_{i+1} - f_i(x_i)|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (y_i - h_i(x_i)) / R_i^(1/2),

with the motion f, the measurement y and their noises of `observers.sensing`, and no r_i where y_i is
missing or not believed; mu is projected on its bounds after each step. rho is Huber's
function, quadratic up to an error of ordinary size. Where the ground has changed, Q_i of mu holds the
variance of the prior too, and the samples that were not believed before count again.

What the patch remembers, `observers.recall`, either does not depend on the states, then the cost is
exact and cheap; or it does, then it is followed through the window at the states, and its derivative by
the tyre's states up to the window's oldest sample is carried.

An empty place, before the window is full, has dt = 0: nothing moves, nothing is measured, nothing turns.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from functools import cache

import casadi as ca

from observers.gate import COUNTS, build_gate, huber_share
from observers.layout import Layout
from observers.linear import build_clean, build_motion, build_reading, directions
from observers.protocol import SAMPLE
from observers.recall import recall_of
from observers.sensing import CLEAN, Sensing
from observers.settings import SAID, constants_size, flags, on_bound, projected, split_constants
from observers.smoother import build_smoother, build_update
from observers.tuning import BELIEFS
from symbolic import Model

ROWS = (*CLEAN, "believed", "jump")
"""Rows of the window's samples: a cleaned sample, whether it counts, and what a change of the ground
adds to the variance of mu before it."""


@cache
def layout(model: Model, sensing: Sensing, window: int) -> Layout:
    """The parts of the estimator's state."""
    n = len(sensing.states)
    return Layout(
        (
            *recall_of(model, sensing, window).fields,
            ("samples", len(ROWS), window),
            ("x", n, window),
            ("mean", n, 1),
            ("factor", n, n),
            ("P_newest", n, n),
            ("counts", len(COUNTS), 1),
            ("said", len(SAID), 1),
        )
    )


@cache
def build_window_step(model: Model, sensing: Sensing, window: int, iterations: int) -> ca.Function:
    """One sample of the estimator: (state, sample, constants) -> (state_next, said)."""
    parts, recall = layout(model, sensing, window), recall_of(model, sensing, window)
    state, sample = ca.MX.sym("state", parts.size), ca.MX.sym("sample", len(SAMPLE))
    constants = ca.MX.sym("constants", constants_size(model))
    before = parts.split(state)
    theta, rig, beliefs = split_constants(model, constants)
    samples, x = before["samples"], before["x"]
    now, held = build_clean(sensing)(sample, samples[: len(CLEAN), -1])
    samples = ca.horzcat(samples, ca.vertcat(now, 1, 0))

    # The oldest sample leaves: it is measured once more, now for good, and moved to the next.
    history, M_z, slopes = recall.leave(before, samples[: len(CLEAN), 0], x[:, 0], theta, rig)
    terms = _terms(sensing, samples[:, :2], x[:, 0], M_z, slopes, rig, beliefs)
    mean, factor, *_ = build_update(len(sensing.states))(before["mean"], before["factor"], *terms)
    mean = projected(sensing, mean, beliefs)

    # The newest comes in where the motion takes it, and is believed or not.
    newest_M_z, newest_slopes = recall.newest(before)
    moving = (samples[: len(CLEAN), -2], now, rig, beliefs)
    expected_x, A, Q = build_motion(sensing)(x[:, -1], newest_M_z, newest_slopes, *moving)
    P = A @ before["P_newest"] @ A.T + ca.diag(Q)
    x, samples = ca.horzcat(x[:, 1:], projected(sensing, expected_x, beliefs)), samples[:, 1:]
    history = recall.enter(history, now, x[:, -1], theta, rig)
    M_z, slopes = recall.along(history, samples, x, theta, rig)
    read = build_reading(sensing)(x[:, -1], M_z[-1], slopes[:, -1], now, rig, beliefs)
    innovation, H, weight, expected, ordinary = read
    left_open = ca.dot(H, P @ H)
    verdict = build_gate()(innovation, left_open, weight, ordinary, before["counts"], beliefs)
    believed, reset, run, counts = verdict
    samples = _believe(samples, believed, reset, run, beliefs)

    for i in range(iterations):
        if i > 0:
            M_z, slopes = recall.along(history, samples, x, theta, rig)
        terms = _terms(sensing, samples, x, M_z, slopes, rig, beliefs)
        last = x
        x, P = build_smoother(len(sensing.states), window)(mean, factor, *terms)
        x = projected(sensing, x, beliefs)
    std = ca.sqrt(P[0, 0])
    status = flags(
        missing=weight <= 0, held=held, rejected=ca.logic_not(believed), reset=reset,
        bound=on_bound(x[0, -1], beliefs), unsettled=ca.fabs(x[0, -1] - last[0, -1]) > std,
    )  # fmt: skip
    if sensing.turns:
        expected = M_z[-1]
    said = ca.vertcat(x[0, -1], std, expected, status)
    # M_z is that of the last linearisation; the motion out of the newest sample wants it at x.
    turned = slopes[:, -1] * (_by_direction(sensing, x[:, -1]) - _by_direction(sensing, last[:, -1]))
    made = {
        **history, "M_z": M_z[-1] + ca.sum1(turned), "slopes": slopes[:, -1], "samples": samples, "x": x,
        "mean": mean, "factor": factor, "P_newest": P, "counts": counts, "said": said,
    }  # fmt: skip
    return ca.Function(
        "mhe_step",
        [state, sample, constants],
        [parts.join(made), said],
        ["state", "sample", "constants"],
        ["state_next", "said"],
    )


def _believe(samples: ca.MX, believed: ca.MX, reset: ca.MX, run: ca.MX, beliefs: ca.MX) -> ca.MX:
    """The window with the verdict on its newest sample, and after a change of the ground on its run."""
    window = samples.shape[1]
    age = ca.DM(range(window - 1, -1, -1)).T
    counts, jump = samples[ROWS.index("believed"), :], samples[ROWS.index("jump"), :]
    counts = ca.if_else(age == 0, believed, counts)
    counts = ca.if_else(ca.logic_and(reset, age < run), 1, counts)
    # A run longer than the window began before it: its oldest sample stands for the first.
    first = age == ca.fmin(run, window) - 1
    variance = beliefs[BELIEFS.index("mu_std")] ** 2
    jump = ca.if_else(ca.logic_and(reset, first), variance, jump)
    return ca.vertcat(samples[: len(CLEAN), :], counts, jump)


def _terms(
    sensing: Sensing, samples: ca.MX, x: ca.MX, M_z: ca.MX, slopes: ca.MX, rig: ca.MX, beliefs: ca.MX
) -> list[ca.MX]:
    """z, H, weight, A, b and Q of a Gauss-Newton step about x, as `build_update` wants them.

    samples may have one column more than x; without it the motion out of the last sample is of no use.
    """
    count, n = x.shape[1], len(sensing.states)
    clean = samples[: len(CLEAN), :]
    read = _build_readings(sensing).map(count) if count > 1 else _build_readings(sensing)
    z, H, weight = read(
        x, M_z, slopes, samples[:, :count], ca.repmat(rig, 1, count), ca.repmat(beliefs, 1, count)
    )
    onward = clean[:, 1:] if clean.shape[1] > count else ca.horzcat(clean[:, 1:], clean[:, -1])
    jumps = samples[-1, 1:] if clean.shape[1] > count else ca.horzcat(samples[-1, 1:], 0)
    move = build_motion(sensing).map(count) if count > 1 else build_motion(sensing)
    x_next, A, Q = move(
        x, M_z, slopes, clean[:, :count], onward, ca.repmat(rig, 1, count), ca.repmat(beliefs, 1, count)
    )
    b = x_next - ca.horzcat(*(A[:, n * i : n * (i + 1)] @ x[:, i] for i in range(count)))
    Q = ca.vertcat(Q[0, :] + jumps, Q[1:, :])
    return [z, H, weight, A, b, Q]


@cache
def _build_readings(sensing: Sensing) -> ca.Function:
    """(x, M_z, slopes, row, rig, beliefs) -> (z, H, weight): what counts of one sample, linear in x."""
    read = build_reading(sensing)
    row = ca.MX.sym("row", len(ROWS))
    x, M_z, slopes, _, rig, beliefs = (ca.MX.sym(n, *read.size_in(n)) for n in read.name_in())
    innovation, H, weight, _, ordinary = read(x, M_z, slopes, row[: len(CLEAN)], rig, beliefs)
    weight = weight * huber_share(innovation, ordinary) * row[ROWS.index("believed")]
    return ca.Function(
        "counted", [x, M_z, slopes, row, rig, beliefs], [innovation + ca.dot(H, x), H, weight]
    )


def _by_direction(sensing: Sensing, x: ca.MX) -> ca.MX:
    """The states that M_z depends on, in the order of its slopes."""
    return x[[sensing.states.index(name) for name in directions(sensing)]]
