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

from observers.layout import Expression, Parts
from observers.measurement.measurement_model import AligningTorque, Moments
from observers.measurement.torque_error import is_known

OTHER = "log_mu_other"
"""The state of the direction that does not load the patch."""
ASYMMETRY = 0.3
"""Standard deviation of ln mu of one direction about that of the other, where only one is known [1]."""
FOLLOWED, SIDE, EXCHANGED = "gear_angle", "slip", "dry"
"""Places of a cleaned sample that are a steering gear's and hold here: the angle less play [rad]; the
direction that loads the patch, 1, -1 or 0 for none yet; 1 where it is exchanged."""


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
    """

    zero: bool = False
    slack: float = 2e-4

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
        """As where friction has no direction, with the direction that loads the patch.

        A direction takes over where the torque opposes its motion; where no torque is known, at once.
        """
        now, imputed = super().clean(sample, last)
        before, side = last[FOLLOWED], last[SIDE]
        followed = ca.fmax(now["psi"] - self.slack, ca.fmin(now["psi"] + self.slack, before))
        way = ca.sign(followed - before)
        known = is_known(now["M_z"])
        opposed = ca.logic_or(ca.logic_not(known), way * ca.if_else(known, now["M_z"], 0) < 0)
        side_next = ca.if_else(ca.logic_and(way != 0, opposed), way, side)
        return {**now, FOLLOWED: followed, SIDE: side_next, EXCHANGED: side_next * side < 0}, imputed

    def motion(
        self, x: Parts, M_z: Expression, last: Parts, now: Parts, rig: Parts, tuning: Parts
    ) -> tuple[Parts, Parts]:
        """All states are random walks; those of the directions are exchanged first."""
        after, variance = super().motion(x, M_z, last, now, rig, tuning)
        # An empty place of a window has dt = 0: nothing happens there.
        exchanged = ca.logic_and(now[EXCHANGED], now["dt"] > 0)
        here, other = x["log_mu"], x[OTHER]
        pair = {"log_mu": ca.if_else(exchanged, other, here), OTHER: ca.if_else(exchanged, here, other)}
        return {**after, **pair}, {**variance, OTHER: variance["log_mu"]}
