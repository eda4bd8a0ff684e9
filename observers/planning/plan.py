"""The path with the least steering after which friction is known to a target, whatever it is.

A path is a start direction, a rate and up to four turning points, of which the last one is turned to on
either side from then on. Its cost on a ground is the travel (or the time, or the greatest angle) until
the observer's own forecast is usable with a deviation within the target; over a prior of mu, even in
its logarithm, the worst or the mean counts.

The search is derivative-free: a set of starts, then [Nelder 1965] in the logarithms of rate and turning
points. The deviation after a given travel is piecewise smooth in the turning points, but what is sought
is the first sample at which no flag stands, and flags step: the scale verified, five independent samples
by branches confirmed. A gradient says nothing of either.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import hypot
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from observers.estimators.model_observer import ModelObserver
from observers.planning.forecast import Forecast, Forecaster, least_deviation
from observers.planning.path import SteeringLimits, SteeringPath, steer
from observers.protocol import Status
from observers.tuning import NO_LIMIT
from symbolic import InvalidInputError
from symbolic.parameters import FRICTION

Array = NDArray[np.float64]
Objective = Literal["travel", "time", "angle"]
Over = Literal["worst", "mean"]
MUS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2)
"""Prior of mu: a car's grounds from ice to dry asphalt [1]."""
STARTS = tuple(product((1.0, 0.4, 0.15), (0.05, 0.1, 0.2, 0.4, 1.0), (1.0, 1.5, 3.0)))
"""Starts of the search: rate over its limit, first turning point over that of the angle, and growth from
one turning point to the next [1]."""
LEGS = 4
"""Turning points that are free."""
NEVER = 1e3
"""Cost where the target is not reached, to which the deviation is added."""
TIE = 0.1
"""Weight of the mean beside the worst ground [1]."""
LEAST_TARGET = 1e-3
"""Least target that makes sense [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A path, and what it tells on each ground.

    Attributes:
        path: angle over time, up to where the last of the grounds is known.
        target: greatest standard deviation of mu over mu [1].
        mus: frictions of the prior, shape (g,).
        forecasts: of each friction along the path.
        reached: sample at which the target is reached, None for never, for each friction.
        reasons: for each friction where it is never reached, why.
    """

    path: SteeringPath
    target: float
    mus: tuple[float, ...]
    forecasts: tuple[Forecast, ...]
    reached: tuple[int | None, ...]
    reasons: tuple[str, ...]

    @property
    def turns(self) -> Array:
        """Turning points, and where it ends [rad]."""
        return np.append(self.path.points[: self.path.leg[-1]], self.path.psi[-1])

    @property
    def travels(self) -> Array:
        """Travel until the target is reached on each ground, NaN for never, shape (g,) [rad]."""
        return np.array([np.nan if at is None else self.path.travel[at] for at in self.reached])


def plan(
    observer: ModelObserver,
    target: float,
    limits: SteeringLimits,
    F_N: float,
    *,
    mus: Sequence[float] = MUS,
    objective: Objective = "travel",
    over: Over = "worst",
    dt: float = 0.01,
    psi: float = 0.0,
    starts: Sequence[tuple[float, float, float]] = STARTS,
    refinements: int = 80,
) -> Plan:
    """The path with the least travel, time or greatest angle until mu is known.

    Args:
        observer: an `Ekf` or `Mhe`, which will estimate along the path.
        target: standard deviation of mu over mu that suffices [1].
        limits: what the wheel may do.
        F_N: vertical load [N].
        mus: frictions that the ground may have [1].
        objective: what is least.
        over: the worst of the frictions or their mean; ties of the worst go by the mean.
        dt: between samples [s].
        psi: angle at which the wheel stands at first, its patch free of torque [rad].
        starts: of the search, as `STARTS`.
        refinements: paths that are tried from each of the two best starts.

    Returns:
        The plan; its `reasons` say what is not reached and why.

    Raises:
        InvalidInputError: a target, friction or load is out of range.
    """
    from scipy.optimize import minimize

    _check(target, mus, F_N)
    search = _Search(Forecaster(observer), target, limits, F_N, tuple(mus), objective, over, dt, psi)
    scored = sorted((search.score(x), tuple(x)) for x in map(_logarithms, starts))
    for _, start in scored[:2] if refinements else ():
        minimize(
            search.score,
            np.array(start),
            method="Nelder-Mead",
            options={"maxfev": refinements, "initial_simplex": _simplex(np.array(start))},
        )
    return search.best()


def _logarithms(start: tuple[float, float, float]) -> Array:
    """Logarithms of rate and turning points over their limits."""
    rate, share, growth = start
    return np.minimum(0.0, np.log([rate, *(share * growth**i for i in range(LEGS))]))


def _simplex(start: Array) -> Array:
    """The start, and beside it a quarter less, or more, in each direction."""
    steps = np.diag(np.where(start > -0.3, -0.3, 0.3))
    return np.vstack([start, start + steps])


class _Search:
    """Costs of paths, and the best one so far."""

    def __init__(
        self, forecaster: Forecaster, target: float, limits: SteeringLimits, F_N: float,
        mus: tuple[float, ...], objective: Objective, over: Over, dt: float, psi: float,
    ) -> None:  # fmt: skip
        """Begin without a path; arguments as of `plan`."""
        self.forecaster, self.target, self.limits, self.F_N = forecaster, target, limits, F_N
        self.mus, self.objective, self.over, self.dt, self.psi = mus, objective, over, dt, psi
        self.lanes = forecaster.at_rest(mus, psi, F_N, dt)
        self.least, self.found = np.inf, np.zeros(0)

    def path(self, x: Array) -> SteeringPath:
        """The path of the logarithms that are searched over."""
        rate, *shares = np.exp(np.minimum(x, 0.0))
        limits = self.limits
        rate = max(float(rate) * limits.rate, limits.slowest)
        angles = np.array(shares) * limits.angle
        # As many turns to either side as fit into the time.
        many = LEGS + int(limits.time * rate / max(angles[-1], 1e-4)) + 1
        angles = np.pad(angles, (0, many - LEGS), mode="edge")
        points = [self.psi, *(self.psi + angles * (-1.0) ** np.arange(many))]
        return steer(points, rate, limits.acceleration, self.dt, limits.time)

    def score(self, x: Array) -> float:
        """Cost of a path; where it exceeds the least one so far, something that is greater too."""
        path = self.path(np.asarray(x))
        along, costs, failed, worst = self.along(path), [0.0], 0, 0.0
        for lane in self.lanes:
            bound = self.least if self.over == "worst" else self.least * len(self.lanes) - sum(costs)
            last = int(np.searchsorted(along, bound))
            at, deviation = self.forecaster.reach(
                path, lane, self.F_N, self.target, self.limits.torque, last
            )
            if at is None:
                failed, worst = failed + 1, max(worst, deviation)
            else:
                costs.append(float(along[at]))
            if failed * NEVER > self.least:
                break
        if failed:
            score = failed * NEVER + worst
        else:
            mean = sum(costs) / len(self.lanes)
            score = max(costs) + TIE * mean if self.over == "worst" else mean
        if score < self.least:
            self.least, self.found = score, np.array(x)
        return score

    def along(self, path: SteeringPath) -> Array:
        """What is to be least, up to each sample."""
        if self.objective == "angle":
            return np.maximum.accumulate(np.abs(path.psi - self.psi))
        return path.travel if self.objective == "travel" else path.t

    def best(self) -> Plan:
        """The plan of the best path, cut where the last ground is known."""
        path = self.path(self.found)
        whole = [self.forecaster.whole(path, lane, self.F_N) for lane in self.lanes]
        reached = [one.reached(self.target, self.limits.torque) for one in whole]
        known = [at for at in reached if at is not None]
        end = max(known) + 1 if len(known) == len(whole) else path.psi.size
        reasons = [
            unreached(self.forecaster.observer, self.target, self.limits, mu, one, self.F_N)
            for mu, one, at in zip(self.mus, whole, reached, strict=True)
            if at is None
        ]
        path = path.upto(end)
        return Plan(
            path=path, target=self.target, mus=self.mus, reached=tuple(reached),
            forecasts=tuple(one.upto(end) for one in whole), reasons=tuple(reasons),
        )  # fmt: skip


def unreached(
    observer: ModelObserver, target: float, limits: SteeringLimits, mu: float, forecast: Forecast,
    F_N: float,
) -> str:  # fmt: skip
    """Why a target is not reached at a friction, along the whole of a path."""
    causes = least_deviation(observer, mu, F_N)
    floor, cause = hypot(*causes.values()), max(causes, key=lambda name: causes[name])
    if floor >= target:
        return (
            f"mu = {mu:.3g}: {target:.1%} cannot be reached by any steering: {cause} alone"
            f" {'leave' if cause[:10] == 'tolerances' else 'leaves'} {causes[cause]:.1%}, all that no"
            f" measurement lowers {floor:.1%}"
        )
    if (np.abs(forecast.torque) > limits.torque).any():
        return f"mu = {mu:.3g}: the torque exceeds its limit of {limits.torque:g} N m before"
    at = f"mu = {mu:.3g}: {forecast.deviation[-1]:.1%} after {limits.time:g} s"
    status = Status(int(forecast.status[-1]))
    return f"{at}, {status.remedy or 'which more time or a wider angle would lower'}"


def _check(target: float, mus: Sequence[float], F_N: float) -> None:
    if not LEAST_TARGET <= target < 1:
        raise InvalidInputError(
            f"target must be a share of mu from {LEAST_TARGET:g} to below 1, got {target:g}"
        )
    if not mus or not all(FRICTION[0] <= mu <= FRICTION[1] for mu in mus):
        raise InvalidInputError(
            f"frictions must be from {FRICTION[0]:g} to {FRICTION[1]:g}, got {list(mus)}"
        )
    if not 0 < F_N < NO_LIMIT:
        raise InvalidInputError(f"the load must be greater than 0 N, got {F_N:g}")
