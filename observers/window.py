"""One sample of the moving-horizon estimator as a casadi Function.

The window holds the last N samples, the states x_i at each of them, what the model remembers, and mean
and covariance of x_1 from all samples that have left (the arrival). Gauss-Newton steps reduce

    |x_1 - mean|^2 / P  +  sum_i |x_{i+1} - f_i(x_i)|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (y_i - h_i(x_i)) / R_i^(1/2),

with the motion f, the measurement y and their noises of `observers.sensing`, and no r_i where y_i is
missing or not believed; mu is projected on its bounds after each step. rho is Huber's
function, quadratic up to an error of ordinary size. Where the ground has changed, Q_i of mu holds the
variance of the prior too, and the samples that were not believed before count again.

What the patch remembers is kept with every sample, see `observers.recall`.

An empty place, before the window is full, has dt = 0: nothing moves, nothing is measured, nothing turns.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.gate import COUNTS, build_gate, huber_share
from observers.layout import Layout
from observers.linear import build_clean, build_motion, build_reading, directions
from observers.meeting import kept_share
from observers.protocol import SAMPLE
from observers.recall import Kept, Recall
from observers.sensing import CLEAN, Sensing
from observers.settings import (
    SAID,
    constants_size,
    flags,
    on_bound,
    prior_variance,
    projected,
    says,
    split_constants,
)
from observers.smoother import build_smoother, build_update
from symbolic import Model

ROWS = (*CLEAN, "believed", "jump")
"""Rows of the window's samples: a cleaned sample, whether it counts, and what a change of the ground
adds to the variance of ln mu before it."""


@cache
def layout(model: Model, sensing: Sensing, window: int) -> Layout:
    """The parts of the estimator's state."""
    n = len(sensing.states)
    return Layout(
        (
            *Recall(model=model, sensing=sensing, window=window).fields,
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
    parts = layout(model, sensing, window)
    state, sample = ca.MX.sym("state", parts.size), ca.MX.sym("sample", len(SAMPLE))
    constants = ca.MX.sym("constants", constants_size(model))
    before = parts.split(state)
    recall = Recall(model=model, sensing=sensing, window=window)
    horizon = _Horizon(recall, *split_constants(model, constants))
    beliefs = horizon.beliefs
    now, held = build_clean(sensing)(sample, before["samples"][: len(CLEAN), -1])
    samples = ca.horzcat(before["samples"], ca.vertcat(now, 1, 0))
    mean, factor = horizon.leave(before, samples)
    newest, P, share = horizon.predict(before, samples)
    x, samples = ca.horzcat(before["x"][:, 1:], newest), samples[:, 1:]
    # Where the angle is measured the patch follows it when it is corrected; else it is what is measured.
    history = (
        recall.without_oldest(before) if sensing.turns else horizon.enter(before, share, now, newest)
    )
    M_z, slopes = horizon.torques(history, x)
    read = build_reading(sensing)(newest, M_z[-1], slopes[:, -1], now, horizon.rig, beliefs)
    innovation, H, weight, expected, ordinary = read
    verdict = build_gate()(innovation, ca.dot(H, P @ H), weight, ordinary, before["counts"], beliefs)
    believed, reset, run, counts = verdict
    samples = _believe(samples, believed, reset, run, beliefs)
    for i in range(iterations):
        last = x
        M_z, slopes = horizon.torques(history, x) if i > 0 else (M_z, slopes)
        terms = horizon.terms(samples, x, M_z, slopes)
        x, P = build_smoother(len(sensing.states), window)(mean, factor, *terms)
        x = projected(sensing, x, beliefs)
    if sensing.turns:
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


@dataclass(frozen=True)
class _Horizon:
    """A recall and the constants of a run; all casadi expressions."""

    recall: Recall
    theta: ca.MX
    rig: ca.MX
    beliefs: ca.MX

    @property
    def sensing(self) -> Sensing:
        return self.recall.sensing

    def leave(self, before: Kept, samples: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Arrival without the oldest sample, which is measured once more, now for good."""
        oldest = before["x"][:, 0]
        M_z, slopes = self.recall.torques(before, oldest, self.theta, self.rig)
        terms = self.terms(samples[:, :2], oldest, M_z, slopes)
        update = build_update(len(self.sensing.states))
        mean, factor, *_ = update(before["mean"], before["factor"], *terms)
        return projected(self.sensing, mean, self.beliefs), factor

    def predict(self, before: Kept, samples: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """The states where the motion takes the newest, their covariance, and what its walk leaves."""
        x, P = before["x"][:, -1], before["P_newest"]
        M_z, slopes = self.of_newest(before, before["x"])
        clean = samples[: len(CLEAN), :]
        motion = build_motion(self.sensing)
        newest, A, Q = motion(x, M_z, slopes, clean[:, -2], clean[:, -1], self.rig, self.beliefs)
        share = kept_share(self.sensing, P, Q, x)
        return projected(self.sensing, newest, self.beliefs), A @ P @ A.T + ca.diag(Q), share

    def enter(self, before: Kept, share: ca.MX, now: ca.MX, x: ca.MX) -> Kept:
        """What is kept with the new sample, which the patch meets at x."""
        return self.recall.enter(before, share, now, x, self.theta, self.rig)

    def of_newest(self, history: Kept, x: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z and slopes of the newest sample kept, at the last column of x."""
        return self.recall.torques(self.recall.newest(history), x[:, -1], self.theta, self.rig)

    def torques(self, history: Kept, x: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z and slopes through the window; 0 at the newest where the patch has yet to meet it."""
        if not self.sensing.turns:
            return self.recall.torques(history, x, self.theta, self.rig)
        zero = ca.MX.zeros(len(directions(self.sensing)))
        if x.shape[1] == 1:
            return ca.MX(0), zero
        M_z, slopes = self.recall.torques(history, x[:, :-1], self.theta, self.rig)
        return ca.horzcat(M_z, 0), ca.horzcat(slopes, zero)

    def forgotten(self, history: Kept, reset: ca.MX, P: ca.MX) -> Kept:
        """What is kept after a reset: what the old ground did says nothing of the new one."""
        if "carried" not in history:
            return history
        share = ca.if_else(reset, P[0, 0] / (P[0, 0] + prior_variance(self.beliefs)), 1)
        carried, count = history["carried"], history["held_at"].shape[0]
        return {**history, "carried": ca.horzcat(carried[:, :-count], share * carried[:, -count:])}

    def terms(self, samples: ca.MX, x: ca.MX, M_z: ca.MX, slopes: ca.MX) -> list[ca.MX]:
        """z, H, weight, A, b and Q of a Gauss-Newton step about x, as `build_update` wants them.

        samples may have one column more than x; without it the motion out of the last is of no use.
        """
        count, n = x.shape[1], len(self.sensing.states)
        if samples.shape[1] == count:
            samples = ca.horzcat(samples, samples[:, -1])
        clean, constant = (
            samples[: len(CLEAN), :],
            [ca.repmat(v, 1, count) for v in (self.rig, self.beliefs)],
        )
        read, move = _build_readings(self.sensing), build_motion(self.sensing)
        if count > 1:
            read, move = read.map(count), move.map(count)
        z, H, weight = read(x, M_z, slopes, samples[:, :count], *constant)
        x_next, A, Q = move(x, M_z, slopes, clean[:, :count], clean[:, 1:], *constant)
        b = x_next - ca.horzcat(*(A[:, n * i : n * (i + 1)] @ x[:, i] for i in range(count)))
        jumps = samples[ROWS.index("jump"), 1:]
        return [z, H, weight, A, b, ca.vertcat(Q[0, :] + jumps, Q[1:, :])]


def _believe(samples: ca.MX, believed: ca.MX, reset: ca.MX, run: ca.MX, beliefs: ca.MX) -> ca.MX:
    """The window with the verdict on its newest sample, and after a change of the ground on its run."""
    window = samples.shape[1]
    age = ca.DM(range(window - 1, -1, -1)).T
    counts, jump = samples[ROWS.index("believed"), :], samples[ROWS.index("jump"), :]
    counts = ca.if_else(age == 0, believed, counts)
    counts = ca.if_else(ca.logic_and(reset, age < run), 1, counts)
    # A run longer than the window began before it: its oldest sample stands for the first.
    first = age == ca.fmin(run, window) - 1
    jump = ca.if_else(ca.logic_and(reset, first), prior_variance(beliefs), jump)
    return ca.vertcat(samples[: len(CLEAN), :], counts, jump)


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
