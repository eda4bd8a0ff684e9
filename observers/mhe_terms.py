"""The terms of a window: what each sample measures and how the states move on, about given states.

`observers.mhe_step` solves them linearised, in real time; `observers.reference` as they are.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.base import prior_variance, projected
from observers.innovation_gate import huber_share
from observers.linearisation import build_motion, build_reading, directions
from observers.measurement_model import CLEAN, MeasurementModel
from observers.mhe_solver import build_update
from observers.patch_history import Kept, Recall
from observers.patch_update import kept_share

ROWS = (*CLEAN, "believed", "jump")
"""Rows of the window's samples: a cleaned sample, whether it counts, and what a change of the ground
adds to the variance of ln mu before it."""


@dataclass(frozen=True)
class Horizon:
    """A recall and the constants of a run; all casadi expressions."""

    recall: Recall
    theta: ca.MX
    rig: ca.MX
    beliefs: ca.MX

    @property
    def measurement_model(self) -> MeasurementModel:
        """What is measured."""
        return self.recall.measurement_model

    def leave(self, before: Kept, samples: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Arrival without the oldest sample, which is measured once more, now for good."""
        oldest = before["x"][:, 0]
        M_z, slopes = self.recall.torques(before, oldest, self.theta, self.rig)
        terms = self.terms(samples[:, :2], oldest, M_z, slopes)
        update = build_update(len(self.measurement_model.states))
        mean, factor, *_ = update(before["mean"], before["factor"], *terms)
        return projected(self.measurement_model, mean, self.beliefs), factor

    def predict(self, before: Kept, samples: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """The states where the motion takes the newest, their covariance, and what its walk leaves."""
        x, P = before["x"][:, -1], before["P_newest"]
        M_z, slopes = self.of_newest(before, before["x"])
        clean = samples[: len(CLEAN), :]
        motion = build_motion(self.measurement_model)
        newest, A, Q, _ = motion(x, M_z, slopes, clean[:, -2], clean[:, -1], self.rig, self.beliefs)
        share = kept_share(self.measurement_model, P, Q, x)
        return projected(self.measurement_model, newest, self.beliefs), A @ P @ A.T + ca.diag(Q), share

    def enter(self, before: Kept, share: ca.MX, now: ca.MX, x: ca.MX) -> Kept:
        """What is kept with the new sample, which the patch meets at x."""
        return self.recall.enter(before, share, now, x, self.theta, self.rig)

    def of_newest(self, history: Kept, x: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z and slopes of the newest sample kept, at the last column of x."""
        return self.recall.torques(self.recall.newest(history), x[:, -1], self.theta, self.rig)

    def torques(self, history: Kept, x: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z and slopes through the window; 0 at the newest where the patch has yet to meet it."""
        if not self.measurement_model.turns:
            return self.recall.torques(history, x, self.theta, self.rig)
        zero = ca.MX.zeros(len(directions(self.measurement_model)))
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
        count = x.shape[1]
        if samples.shape[1] == count:
            samples = ca.horzcat(samples, samples[:, -1])
        clean, constant = (
            samples[: len(CLEAN), :],
            [ca.repmat(v, 1, count) for v in (self.rig, self.beliefs)],
        )
        read, move = _along(self.measurement_model, count)
        z, H, weight = read(x, M_z, slopes, samples[:, :count], *constant)
        _, A, Q, b = move(x, M_z, slopes, clean[:, :count], clean[:, 1:], *constant)
        jumps = samples[ROWS.index("jump"), 1:]
        return [z, H, weight, A, b, ca.vertcat(Q[0, :] + jumps, Q[1:, :])]


@cache
def build_counted(measurement_model: MeasurementModel) -> ca.Function:
    """(x, M_z, slopes, row, rig, beliefs) -> (z, H, weight): what counts of one sample, linear in x."""
    read = build_reading(measurement_model)
    row = ca.MX.sym("row", len(ROWS))
    x, M_z, slopes, _, rig, beliefs = (ca.MX.sym(n, *read.size_in(n)) for n in read.name_in())
    innovation, H, weight, _, ordinary = read(x, M_z, slopes, row[: len(CLEAN)], rig, beliefs)
    weight = weight * huber_share(innovation, ordinary) * row[ROWS.index("believed")]
    return ca.Function(
        "counted", [x, M_z, slopes, row, rig, beliefs], [innovation + ca.dot(H, x), H, weight]
    )


@cache
def _along(measurement_model: MeasurementModel, count: int) -> tuple[ca.Function, ca.Function]:
    """Readings and motions of so many samples; one pair for all, so that its code is made once."""
    read, move = build_counted(measurement_model), build_motion(measurement_model)
    return (read.map(count), move.map(count)) if count > 1 else (read, move)
