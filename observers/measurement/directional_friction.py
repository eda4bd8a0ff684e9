"""Friction that differs by direction: ln mu of the direction that slides, and of the other one.

    M_z = h(history of the angle, mu) + M_0,    mu = mu_forward while psi grows, else mu_backward

A band that is pulled at one end, or a tread with a bias, grips in one direction otherwise than in the
other, and each may change by itself. `log_mu` is of the direction that loads the patch now; the state
`log_mu_other` is of the opposite one. Both walk. They are exchanged where the torque changes sign: until
then a patch that has turned back is unloaded, and bears what the old direction gave it. The patch has
one friction at a time. So for a moment after the exchange bristles that still are deformed the old way
have the limit of the new one.

A direction that has not slid yet is known from the other one alone: their priors differ by `ASYMMETRY`.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from observers.layout import Expression, Parts
from observers.measurement.measurement_model import AligningTorque, Moments
from observers.measurement.torque_error import JITTER, is_known
from observers.tuning import REFERENCE_STEP
from symbolic.float_array_type import Array

OTHER = "log_mu_other"
"""The state of the direction that does not load the patch."""
ASYMMETRY = 0.3
"""Standard deviation of ln mu of one direction about that of the other, where only one is known [1]."""
FOLLOWED, SIDE, EXCHANGED, EVIDENCE, WALKED, WALKED_OTHER = (
    *("gear_angle", "slip", "dry", "dry_std", "M_age", "M"),
)  # fmt: skip
"""Places of a cleaned sample that belong to a steering torque and hold here: the angle less play [rad];
the direction that loads the patch, 1, -1 or 0 for none yet; 1 where it is exchanged; after its test, the
log-likelihood ratio by which the innovations say that friction is changing [1]; what that has added to
the walk of this stroke, and of the last one the other way, as a time of the usual walk [s]."""
WIDENING = 3.0
"""What a log-likelihood ratio of 1 adds to the walk of the direction that slides, in walks [1]."""
SLOW_TURN = 0.1
"""Yaw rate up to which a walk is widened by the turn, not by the time [rad/s]: the usual one."""
BETWEEN = JITTER * REFERENCE_STEP
"""Time since a torque up to which the next one is awaited, as torques may be the slower [s]."""
CHANGING = 1.0
"""Log-likelihood ratio from which on friction that is changing is not usable [1]."""


@dataclass(frozen=True, kw_only=True)
class DirectionalFriction(AligningTorque):
    """The aligning torque is measured; states mu, mu of the other direction, and as chosen.

    Friction is not acquired: the hypotheses have one friction for both directions, see `ModelObserver`.
    So nothing checks the scale of the torque, which friction is proportional to. What its zero may be
    off by is part of the deviation of mu, unless it is a state.

    Attributes:
        zero: the zero of the torque channel is a state too [N m]; sliding tells it from a difference
            between the directions by the prior alone.
        slack: play of the angle's noise, either way [rad].
        at_reversal: exchanged where the angle turns back, not where the torque changes sign; an observer
            sets it whose model has an `asymmetric_friction`, the limit of which changes there.
    """

    zero: bool = False
    slack: float = 2e-4
    at_reversal: bool = False

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return (*super().states, OTHER)

    def prior(self, tuning: Parts, first: Parts, slide_torque: Expression) -> dict[str, Moments]:
        """Mean and variance of every state."""
        prior = super().prior(tuning, first, slide_torque)
        mean, variance = prior["log_mu"]
        return prior | {OTHER: (mean, variance + ASYMMETRY**2)}

    def clean(self, sample: Parts, last: Parts) -> tuple[Parts, Expression]:
        """As where friction has no direction, with the direction that loads the patch."""
        now, imputed = super().clean(sample, last)
        before, side = last[FOLLOWED], last[SIDE]
        between = now["interval"] < BETWEEN
        followed, side_next = self._next_angle_and_direction(
            now["psi"], now["M_z"], between, before, side
        )
        exchanged = side_next * side < 0
        # At rest and without a torque nothing tells of a change, and none is assumed.
        turned = ca.fmin(now["interval"], now["travel"] / SLOW_TURN) * is_known(now["M_z"])
        walked = last[WALKED] + ((1 + WIDENING * last[EVIDENCE]) ** 2 - 1) * turned
        here, other = ca.if_else(exchanged, 0, walked), ca.if_else(exchanged, walked, last[WALKED_OTHER])
        own = {FOLLOWED: followed, SIDE: side_next, EXCHANGED: exchanged}
        return {**now, **own, WALKED: here, WALKED_OTHER: other}, imputed

    def directions(self, t: Array, psi: Array, M_z: Array) -> Array:
        """The direction whose friction mu is at every sample: 1 to positive psi, -1, 0 for none yet.

        Args:
            t: time [s], shape (n,).
            psi: yaw angle [rad], shape (n,).
            M_z: aligning torque, NaN where none was measured [N m], shape (n,).
        """
        last, now = ca.SX.sym("last", 2), ca.SX.sym("now", 3)
        after = ca.vertcat(*self._next_angle_and_direction(*ca.vertsplit(now), *ca.vertsplit(last)))
        follow = ca.Function("follow", [last, now], [after]).mapaccum(psi.size)
        since = t - np.maximum.accumulate(np.where(np.isfinite(M_z), t, t[0]))
        path = follow([psi[0], 0.0], np.stack([psi, M_z, since < BETWEEN]))
        return np.array(path[1, :], dtype=float).ravel()

    def _next_angle_and_direction(
        self, psi: Expression, M_z: Expression, between: Expression, before: Expression, side: Expression
    ) -> tuple[Expression, Expression]:
        """The angle less play, and the direction, from those before; between torques it waits."""
        followed = ca.fmax(psi - self.slack, ca.fmin(psi + self.slack, before))
        way, known = ca.sign(followed - before), is_known(M_z)
        takes_over = way != 0
        if not self.at_reversal:
            # Where the torque opposes its motion; at once where no torque has been known for long.
            alone = ca.logic_not(ca.logic_or(known, between))
            opposed = ca.logic_or(alone, way * ca.if_else(known, M_z, 0) < 0)
            takes_over = ca.logic_and(takes_over, opposed)
        return followed, ca.if_else(takes_over, way, side)

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """All states are random walks; those of the directions are exchanged first.

        Friction that is changing walks further: a filter of a constant walk lags behind a ramp. What was
        added so to the last stroke this way is added once more where the next one begins.
        """
        after, variance = super().motion(x, M_z, last, now, rig, tuning)
        # An empty place of a window has dt = 0: nothing happens there.
        exchanged = ca.logic_and(now[EXCHANGED], now["dt"] > 0)
        here, other = x["log_mu"], x[OTHER]
        pair = {"log_mu": ca.if_else(exchanged, other, here), OTHER: ca.if_else(exchanged, here, other)}
        walk = variance["log_mu"]
        added = ca.if_else(exchanged, last[WALKED_OTHER], now[WALKED] - last[WALKED])
        widened = walk + added * (now["dt"] > 0) * tuning["mu_walk"] ** 2
        return {**after, **pair}, {**variance, "log_mu": widened, OTHER: walk}
