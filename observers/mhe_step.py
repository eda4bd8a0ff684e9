"""One sample of the moving-horizon estimator as a casadi Function.

The window holds the last N samples, the states x_i at each of them, what the model remembers, and mean
and covariance of x_1 from all samples that have left (the arrival). Gauss-Newton steps reduce

    |x_1 - mean|^2 / P  +  sum_i |x_{i+1} - f_i(x_i)|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (y_i - h_i(x_i)) / R_i^(1/2),

with the motion f, the measurement y and their noises of `observers.measurement_model`, and no r_i where
y_i is missing or not believed; mu is projected on its bounds after each step. rho is Huber's
function, quadratic up to an error of ordinary size. Where the ground has changed, Q_i of mu holds the
variance of the prior too, and the samples that were not believed before count again.

What the patch remembers is kept with every sample, see `observers.patch_history`.

An empty place, before the window is full, has dt = 0: nothing moves, nothing is measured, nothing turns.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from functools import cache

import casadi as ca

from observers.base import (
    SAID,
    constants_size,
    flags,
    on_bound,
    prior_variance,
    projected,
    says,
    split_constants,
)
from observers.innovation_gate import COUNTS, build_gate
from observers.layout import Layout
from observers.linearisation import build_clean, build_reading
from observers.measurement_model import CLEAN, MeasurementModel
from observers.mhe_solver import build_smoother
from observers.mhe_terms import ROWS, Horizon
from observers.patch_history import Recall
from observers.patch_update import carries
from observers.protocol import SAMPLE
from symbolic import Model


@cache
def layout(model: Model, measurement_model: MeasurementModel, window: int) -> Layout:
    """The parts of the estimator's state."""
    n = len(measurement_model.states)
    return Layout(
        (
            *Recall(model=model, measurement_model=measurement_model, window=window).fields,
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
def build_window_step(
    model: Model, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    """One sample of the estimator: (state, sample, constants) -> (state_next, said)."""
    parts = layout(model, measurement_model, window)
    state, sample = ca.MX.sym("state", parts.size), ca.MX.sym("sample", len(SAMPLE))
    constants = ca.MX.sym("constants", constants_size(model))
    before = parts.split(state)
    recall = Recall(model=model, measurement_model=measurement_model, window=window)
    horizon = Horizon(recall, *split_constants(model, constants))
    beliefs = horizon.beliefs
    now, held = build_clean(measurement_model)(sample, before["samples"][: len(CLEAN), -1])
    samples = ca.horzcat(before["samples"], ca.vertcat(now, 1, 0))
    mean, factor = horizon.leave(before, samples)
    newest, P, share = horizon.predict(before, samples)
    x, samples = ca.horzcat(before["x"][:, 1:], newest), samples[:, 1:]
    # Where the angle is measured the patch follows it when it is corrected; else it is what is measured.
    history = (
        recall.without_oldest(before)
        if measurement_model.turns
        else horizon.enter(before, share, now, newest)
    )
    M_z, slopes = horizon.torques(history, x)
    read = build_reading(measurement_model)(newest, M_z[-1], slopes[:, -1], now, horizon.rig, beliefs)
    innovation, H, weight, expected, ordinary = read
    verdict = build_gate()(innovation, ca.dot(H, P @ H), weight, ordinary, before["counts"], beliefs)
    believed, reset, run, counts = verdict
    # A memory made under the old friction does not fit samples of the new ground: then they stay out.
    again = 1 if carries(model, measurement_model) else run
    samples = _believe(samples, believed, reset, again, beliefs)
    # Nothing comes before the window's oldest sample: a change there comes in with the arrival.
    factor[0, 0] += ca.if_else(again >= window, reset * prior_variance(beliefs), 0)
    for i in range(iterations):
        last = x
        M_z, slopes = horizon.torques(history, x) if i > 0 else (M_z, slopes)
        terms = horizon.terms(samples, x, M_z, slopes)
        x, P = build_smoother(len(measurement_model.states), window)(mean, factor, *terms)
        x = projected(measurement_model, x, beliefs)
    if measurement_model.turns:
        history = horizon.enter(before, share, now, x[:, -1])
        expected, _ = horizon.of_newest(history, x)
    status = flags(
        missing=weight <= 0, held=held, rejected=ca.logic_not(believed), reset=reset,
        bound=on_bound(x[0, -1], beliefs), unsettled=(x[0, -1] - last[0, -1]) ** 2 > P[0, 0],
    )  # fmt: skip
    said = ca.vertcat(says(x[0, -1], P[0, 0]), expected, status)
    made = {
        **horizon.forgotten(history, reset, before["P_newest"]), "samples": samples, "x": x,
        "mean": mean, "factor": factor, "P_newest": P, "counts": counts, "said": said,
    }  # fmt: skip
    return ca.Function(
        "mhe_step",
        [state, sample, constants],
        [parts.join(made), said],
        ["state", "sample", "constants"],
        ["state_next", "said"],
    )


def _believe(samples: ca.MX, believed: ca.MX, reset: ca.MX, run: ca.MX | int, beliefs: ca.MX) -> ca.MX:
    """The window with the verdict on its newest; after a change of the ground, `run` count again."""
    window = samples.shape[1]
    age = ca.DM(range(window - 1, -1, -1)).T
    counts, jump = samples[ROWS.index("believed"), :], samples[ROWS.index("jump"), :]
    counts = ca.if_else(age == 0, believed, counts)
    counts = ca.if_else(ca.logic_and(reset, age < run), 1, counts)
    # A run longer than the window began before it: its oldest sample stands for the first.
    first = age == ca.fmin(run, window) - 1
    jump = ca.if_else(ca.logic_and(reset, first), prior_variance(beliefs), jump)
    return ca.vertcat(samples[: len(CLEAN), :], counts, jump)
