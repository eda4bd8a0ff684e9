"""The path with the least steering after which friction is known to a target, whatever it is.

A path rests, unless time is to be least, and swings to either side at a rate, evenly growing from a
first turning point to a farthest one. Its cost on a ground is the travel (or the time, or the greatest
angle) until the observer's own forecast is usable with a deviation within the target, in most of some
runs with noise; over a prior of mu, even in its logarithm, the worst or the mean counts.

The paths are a family that does not depend on the limits. A path counts up to where it exceeds one of
them, so that a wider limit only adds to what may be chosen: it never makes the plan worse. The best of
the family is found by trying all that may still be better: what is sought is the first sample at which
no flag stands, and a gradient says nothing of that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import Literal

import numpy as np

from observers.estimators.model_observer import ModelObserver
from observers.planning.forecast import (
    RUNS,
    Forecast,
    ForecastCase,
    Forecaster,
    NoisyForecaster,
    irreducible_mu_std,
    percent_text_beside_target,
    unreachable_target_text,
)
from observers.planning.plan_request_check import MUS, check_plan_request
from observers.planning.steering_limits_and_paths import (
    RAMP,
    SteeringLimits,
    SteeringPath,
    Swing,
    fastest_path,
    swings_within_limits,
)
from observers.planning.uncertainty_budget import largest_uncertainty_part
from observers.protocol import Status
from observers.tuning import NO_LIMIT
from symbolic.float_array_type import Array

Objective = Literal["travel", "time", "angle"]
Over = Literal["worst", "mean"]
REST = 0.5
"""Time before the first turn in which the torque tells its zero [s]."""
LEGS = 4
"""Turning points from the first to the farthest."""
NEVER = 1e3
"""Cost where the target is not reached, to which the least deviation is added."""
CLOSE, GOES_ON = 0.9, 0.1
"""Share of the target from which on what no steering lowers leaves little to the limits; travel beyond
that until the target is reached, over that [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A path, and what it tells on each ground.

    Attributes:
        path: angle over time, up to a tenth more travel than until the last of the grounds is known.
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
    def turning_points(self) -> Array:
        """Turning points, and where it ends [rad]."""
        return np.append(self.path.points[: self.path.leg[-1]], self.path.psi[-1])

    @property
    def travels_to_target(self) -> Array:
        """Travel until the forecast reaches it on each ground, NaN for never, shape (g,) [rad]."""
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
    coarse: bool = False,
    quiet: bool = False,
    progress: Callable[[str, int, int], None] = lambda *_: None,
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
        coarse: try a few of the paths only.
        quiet: without noise, for a start.
        progress: is told what is done, how many paths were tried, and how many there are.

    Returns:
        The plan; its `reasons` say what is not reached and why.

    Raises:
        InvalidInputError: a target, friction or load is out of range, the limits leave no rate, or no
            steering reaches the target on any ground.
    """
    check_plan_request(observer, target, limits, mus, dt, F_N)
    search = _PathSearch(
        Forecaster(observer), target, limits, F_N, tuple(mus), objective, over, dt, psi, quiet
    )
    floors = [hypot(*irreducible_mu_std(observer, mu, F_N).values()) for mu in mus]
    coarse = coarse or min(floors) > CLOSE * target
    for i, swing in enumerate(paths := swings_within_limits(limits, coarse=coarse)):
        progress("trying paths", i, len(paths))
        search.try_swing(swing)
    return search.best_plan()


class _PathSearch:
    """Costs of paths, and the best one so far."""

    def __init__(
        self, forecaster: Forecaster, target: float, limits: SteeringLimits, F_N: float,
        mus: tuple[float, ...], objective: Objective, over: Over, dt: float, psi: float, quiet: bool,
    ) -> None:  # fmt: skip
        """Begin without a path; arguments as of `plan`."""
        self.forecaster, self.target, self.limits, self.F_N = forecaster, target, limits, F_N
        self.mus, self.objective, self.over, self.dt, self.psi = mus, objective, over, dt, psi
        self.cases = forecaster.cases_at_rest(mus, psi, F_N, dt)
        self.least, self.found = (np.inf, np.inf), Swing(limits.rate, limits.angle, limits.angle)
        self.hopeless = {mu: unreachable_target_text(forecaster.observer, target, mu, F_N) for mu in mus}
        # The case that refused the last path comes first; what no steering reaches is not tried.
        self.order = [case for case in self.cases if not self.hopeless[case.mu]]
        self.straight: set[float] = set()
        samples = int(limits.time / dt) + 1
        self.noisy = NoisyForecaster(forecaster, F_N, target, limits.torque, dt, samples, quiet=quiet)

    def path(self, swing: Swing) -> SteeringPath:
        """The path of a swing, up to where it exceeds the angle or the time."""
        rate, first, farthest = swing
        angles = np.geomspace(first, farthest, LEGS)
        many = LEGS + int(self.limits.time * rate / angles[-1]) + 1
        angles = np.pad(angles, (0, many - LEGS), mode="edge")
        points = [self.psi, *(self.psi + angles * (-1.0) ** np.arange(many))]
        rest = REST * (self.objective != "time")
        path = fastest_path(points, rate, rate / RAMP, self.dt, self.limits.time, rest=rest)
        beyond = np.abs(path.psi - self.psi) > self.limits.angle * (1 + 1e-9)
        return path.first_samples(max(1, int(np.argmax(beyond)))) if beyond.any() else path

    def try_swing(self, swing: Swing) -> float:
        """Forecast a path as long as it may be better than the best one; the least cost so far."""
        path = self.path(swing)
        along, worst, costs = self.cost_along_path(path), 0.0, [0.0]
        last = min(int(np.searchsorted(along, self.least[0])), along.size - 1)
        if path.leg[last] == 0 and path.psi_dot[last] == swing.rate:
            # Up to there another one was the same.
            if swing.rate in self.straight:
                return self.least[0]
            self.straight.add(swing.rate)
        missed: set[float] = set()
        for reach in (self._forecast_until_target, self.noisy.at_target):
            costs = []
            for case in [case for case in self.order if case.mu not in missed]:
                bound = self.least[0]
                if self.over == "mean":
                    bound = bound * len(self.order) - sum(costs)
                last = int(np.searchsorted(along, bound))
                at, deviation = reach(path, case, last)
                if at is None:
                    missed.add(case.mu)
                    worst = max(worst, deviation)
                else:
                    costs.append(float(along[at]))
                mean = sum(costs) / len(self.order)
                cost = (max([0.0, *costs]) if self.over == "worst" else mean, mean)
                if missed:
                    cost = (len(missed) * NEVER + worst, mean)
                if cost > self.least:
                    self.order.remove(case)
                    self.order.insert(0, case)
                    return self.least[0]
        if cost < self.least:
            self.least, self.found = cost, swing
        return self.least[0]

    def _forecast_until_target(
        self, path: SteeringPath, case: ForecastCase, last: int
    ) -> tuple[int | None, float]:
        """`Forecaster.at_target` without noise."""
        return self.forecaster.at_target(path, case, self.F_N, self.target, self.limits.torque, last)

    def cost_along_path(self, path: SteeringPath) -> Array:
        """The cost up to each sample."""
        if self.objective == "angle":
            return np.maximum.accumulate(np.abs(path.psi - self.psi))
        return path.travel if self.objective == "travel" else path.t

    def best_plan(self) -> Plan:
        """The plan of the best path, cut soon after the last ground is known, or where it must end."""
        path = self.path(self.found)
        whole = [self.forecaster.forecast_whole(path, case, self.F_N) for case in self.cases]
        runs = [
            self.noisy.samples_at_target(path, case, path.psi.size, every=True) for case in self.cases
        ]
        enough = self.noisy.enough
        # The sigma/mu that is shown has no noise: it has to be within the target there too.
        reached = [
            one.first_within(self.target, self.limits.torque, of[enough - 1])
            if len(of) >= enough
            else None
            for one, of in zip(whole, runs, strict=True)
        ]
        last = max((at for at in reached if at is not None), default=0)
        end = min(one.samples_within_torque_limit(self.limits.torque) for one in whole)
        if None not in reached:
            end = min(end, int(np.searchsorted(path.travel, (1 + GOES_ON) * path.travel[last])) + 1)
        end = max(last + 1, end)
        reasons = [
            f"mu = {mu:.3g}: "
            + (self.hopeless[mu] or self.unreached_text(mu, path, one.first_samples(end + 1), len(of)))
            for mu, one, at, of in zip(self.mus, whole, reached, runs, strict=True)
            if at is None
        ]
        return Plan(
            path=path.first_samples(end), target=self.target, mus=self.mus, reached=tuple(reached),
            forecasts=tuple(one.first_samples(end) for one in whole), reasons=tuple(reasons),
        )  # fmt: skip

    def unreached_text(self, mu: float, path: SteeringPath, forecast: Forecast, count: int) -> str:
        """How far the best path comes at a friction, and which limits would have to be wider.

        count is that of the runs with noise that reach the target.
        """
        at = forecast.least_deviation_index(self.limits.torque)
        known = "never usable on the best path"
        if at is not None:
            best = percent_text_beside_target(float(forecast.deviation[at]), self.target)
            known = f"{best} at best, after {path.t[at]:.3g} s"
            cause, part, floor = largest_uncertainty_part(
                self.forecaster.observer, path, forecast, self.F_N, at
            )
            if forecast.deviation[at] <= self.target:
                known = known.replace("at best", "without noise", 1)
                known += f", but within {self.target:.1%} in {count} of {RUNS} runs with noise"
            else:
                known += f"; its largest part is {cause}, {part:.1%}"
            if floor > CLOSE * self.target:
                lowest = percent_text_beside_target(floor, self.target)
                return f"{known}; all that no measurement lowers is {lowest}: ask for well above that"
        allowed = forecast.samples_within_torque_limit(self.limits.torque)
        if is_limited := allowed < forecast.torque.size:
            known = f"{known}, beyond the limit of the torque from {path.t[allowed]:.3g} s on"
        if self.is_reached_with_wider_limits(mu):
            return f"{known}; another path reaches it: plan for this friction alone"
        wider = [
            name
            for name in ("angle", "time", "torque")
            if (limit := getattr(self.limits, name)) < NO_LIMIT
            and self.is_reached_with_wider_limits(mu, **{name: 2 * limit})
        ]
        if wider:
            return f"{known}; twice the limit of {' or '.join(wider)} would do"
        remedy = "" if is_limited else Status(int(forecast.status[-1])).remedy
        return f"{known}; no limit alone, twice as wide, would do" + f": {remedy}" * bool(remedy)

    def is_reached_with_wider_limits(self, mu: float, **wider: float) -> bool:
        """Whether the target is reached at a friction alone, with some limits wider."""
        limits = replace(self.limits, **wider)
        wide = _PathSearch(
            self.forecaster, self.target, limits, self.F_N, (mu,), self.objective, self.over, self.dt,
            self.psi, len(self.noisy.noise) == 1,
        )  # fmt: skip
        # The first path that reaches it will do.
        return any(wide.try_swing(swing) < NEVER for swing in swings_within_limits(limits, coarse=True))
