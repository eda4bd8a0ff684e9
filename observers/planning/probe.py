"""The next angle for a steering controller, until friction is known: plans as it goes.

A `Probe` begins with the plan over its prior, see `observers.planning.plan`. Ten times a second it
forecasts from the observer's present state, on the frictions that this still holds for likely, what
remains of its path and a few changes of it: turn back now or sooner, go on further, swing wider or
narrower, faster or slower. It takes the one with the least mean travel until the target.

An estimate moves by no more than the deviation that it had: where one has, the observer's errors are not
what it takes them for, and the probe asks for a second value, half as much travel later.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle, islice
from math import exp, inf, isfinite, log, nan, sqrt

import numpy as np

from observers.estimators.ekf import Ekf
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.control_loop import Loop
from observers.layout import ObserverState
from observers.planning.advice_and_stop_reasons import (
    MAX_DEVIATION,
    VAGUE,
    Advice,
    irreducible_reason_text,
    time_limit_reason_text,
    unreached_friction_text,
)
from observers.planning.forecast import ForecastCase, Forecaster
from observers.planning.plan import NEVER, REST, Plan, plan
from observers.planning.plan_request_check import MUS, check_plan_request
from observers.planning.steering_limits_and_paths import (
    KINDS,
    PathPoint,
    SteeringLimits,
    SteeringPath,
    changed_path,
)
from observers.protocol import Estimate, Sample
from observers.quality.acquisition import OVER, OWN
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from symbolic import InvalidInputError

EVERY = 0.1
"""Time between two plans [s]."""
HORIZON = 3.0
"""Duration of a forecast [s]."""
CHANGES = 3
"""Changes of the path that are forecast at each plan, in turn."""
ASTRAY = (0.02, 0.3)
"""The wheel has left the path where it is off by more than an angle [rad] plus the turn of this time [s]
at the limit of the rate; the path then begins anew where the wheel is."""
MIN_SWING = 1e-3
"""Least distance of the bounds of the angle that leaves room to steer [rad]."""
_ACQUIRING, _EXCESS, _PHASE = map(OWN.index, ("acquiring", "excess", "phase"))
MOVES, AGAIN = 3.0, 1.5
"""Deviations by which an estimate has moved since it first was within the target if that deviation is
too small, and the travel at which it may then be believed, over that so far [1]."""
GAIN = 0.97
"""A changed path is taken where its cost is below this share of the present one [1]."""


class Probe:
    """Advises a steering controller, or a driver, sample by sample: `probe(sample, state)`.

    Call `prepare` before the loop: it takes seconds, and raises where this load keeps the target out of
    reach. A sample raises nothing: without a plan the advice is `stopped`, with its reason. Ten times a
    second a sample waits for a new plan: 15 ms in the median, above 85 ms in one of 100, up to 100 ms
    on one core of an AMD EPYC (Zen 4) at 2.6 GHz. Where samples cannot wait, call the probe in a thread
    or process of its own.

    Attributes:
        observer: an `Ekf` or `Mhe` of an aligning torque or a rack force.
        target: standard deviation of mu over mu that suffices [1].
        limits: what the wheel may do; angles count from the first sample's.
        mus: frictions that the ground may have [1].

    Raises:
        InvalidInputError: the observer has the steering torque measured, the target is no share, the
            limits leave no rate or no time, or no steering reaches the target, whatever the load.
    """

    def __init__(
        self, observer: ModelObserver, target: float, limits: SteeringLimits, *,
        mus: Sequence[float] = MUS, dt: float = 0.01,
    ) -> None:  # fmt: skip
        """Begin without a sample; dt is the time between samples of the forecasts [s]."""
        if observer.channel != "M_z":
            raise InvalidInputError(
                "a Probe needs an observer of M_z or of the rack, whose patch follows the measured"
                " angle; got one of the steering torque M"
            )
        check_plan_request(observer, target, limits, mus, dt)
        self.observer, self.target, self.limits = observer, target, limits
        self.mus, self.dt = tuple(mus), dt
        # The forecasts are those of a filter; beside another observer one runs along.
        of_filter = observer
        self._twin: Loop | None = None
        if not isinstance(observer, Ekf):
            shared = ("model", "values", "rig", "tuning", "measurement_model", "acquire")
            of_filter = Ekf(**{name: getattr(observer, name) for name in shared})
            self._twin = Loop(of_filter)
        self._forecaster = Forecaster(of_filter)
        self._horizon = int(HORIZON / dt)
        self._first: Plan | None = None
        self.reset()

    def prepare(self, F_N: float) -> Plan:
        """Compile, and make the first plan for a load [N], for which the first sample would wait.

        Its `reasons` say what the limits keep out of reach. It takes 2 s for the rig and 8 s for a car,
        on the same core, and the first time on a machine some ten more to compile.

        Raises:
            InvalidInputError: no steering reaches the target on any ground at this load.
        """
        self._first = plan(
            self._forecaster.observer, self.target, self.limits, F_N, mus=self.mus, dt=self.dt,
            coarse=True, quiet=True,
        )  # fmt: skip
        return self._first

    def reset(self) -> None:
        """Forget all samples."""
        self._start, self._bounds = nan, (nan, nan)
        self.restart_advice()

    def restart_advice(self) -> None:
        """Advise anew where friction is known no more; the bounds of the angle stay."""
        self._path: SteeringPath | None = None
        self._time = self._travel = self._since = self._farthest = 0.0
        self._due = REST + EVERY
        self._counted = self._left = nan
        self._second, self._within = 0.0, (-inf, inf)
        self._kinds = cycle(KINDS[1:])
        self._ended: Advice | None = None
        if self._twin is not None:
            self._twin.reset()

    def __call__(self, sample: Sample, state: ObserverState | None) -> Advice:
        """The advice after a sample and the observer's state with it; None before its start."""
        if self._twin is not None:
            self._twin(sample)
        if self._ended is not None:
            return self._ended
        waits = self._path is None and not sample.F_N > 0
        if state is None or not isfinite(sample.psi) or waits:
            estimate = self.observer.prior if state is None else self.observer.estimate(state)
            return self._advice(sample.psi, estimate, "")
        estimate = self.observer.estimate(state)
        reason = self._irreducible_reason_text(sample, estimate, state)
        if not reason:
            reason = self._update_progress(sample) or self._stop_reason_text(estimate)
        known = self._is_target_reached(estimate, state)
        if known or reason:
            self._ended = self._advice(sample.psi, estimate, "" if known else reason, ends=True)
            return self._ended
        assert self._path is not None
        if self._since >= self._due or self._since >= self._path.t[-1]:
            self._replan(sample, self._twin.state if self._twin else state)
        return self._advice(sample.psi, estimate, "", sample.dt)

    def _is_target_reached(self, estimate: Estimate, state: ObserverState) -> bool:
        """Whether the target is reached, the second time where the first one may not be believed."""
        deviation = estimate.mu_std / estimate.mu
        if state["own"][_ACQUIRING] or deviation > self.target:
            return False
        log_mu = log(estimate.mu)
        low, high = (log_mu + side * MOVES * deviation for side in (-1, 1))
        self._within = (max(self._within[0], low), min(self._within[1], high))
        if not estimate.usable or self._travel < self._second:
            return False
        if self._within[0] <= log_mu <= self._within[1]:
            return True
        self._second, self._within = AGAIN * self._travel, (low, high)
        return False

    def _update_progress(self, sample: Sample) -> str:
        """Time, travel and the bounds of the angle after a sample; the first plan at the first one.

        Why there is no plan; empty where there is one.
        """
        if self._path is None:
            try:
                self._first = self._first or self.prepare(sample.F_N)
            except InvalidInputError as refused:
                return str(refused)
            path = self._first.path
            self._path = replace(
                path, begin=sample.psi, psi=path.psi + sample.psi, points=path.points + sample.psi
            )
            self._left = float(np.nanmax([*self._first.travels_to_target, 0.0])) or nan
            self._counted = sample.psi
            if not isfinite(self._start):
                self._start = sample.psi
                self._bounds = (sample.psi - self.limits.angle, sample.psi + self.limits.angle)
            return ""
        self._farthest = max(self._farthest, abs(sample.psi - self._start))
        self._time, self._since = self._time + sample.dt, self._since + sample.dt
        turn = sample.psi - self._counted
        # Within the noise of the angle there is no turn.
        if abs(turn) > self.observer.tuning.psi_noise:
            self._travel, self._counted = self._travel + abs(turn), sample.psi
            self._left = max(self._left - abs(turn), 0.0)
        if abs(sample.M_z) > self.limits.torque:
            low, high = self._bounds
            outward = sample.psi > self._start
            self._bounds = (low, sample.psi) if outward else (sample.psi, high)
            self._due = min(self._due, self._since)
        return ""

    def _irreducible_reason_text(self, sample: Sample, estimate: Estimate, state: ObserverState) -> str:
        """Why no steering reaches the target; empty where one may."""
        # From the end of the search for the torque's scale on it stays.
        excess = float(state["own"][_EXCESS]) if state["own"][_PHASE] == OVER else 0.0
        return irreducible_reason_text(
            self.observer, self.target, estimate, sample.F_N, max(self.mus), excess
        )

    def _stop_reason_text(self, estimate: Estimate) -> str:
        """Why the steering has to end; empty where it may go on."""
        low, high = self._bounds
        held = high - low < 2 * self.limits.angle - MIN_SWING
        within = f"the torque's limit of {self.limits.torque:g} N m keeps the wheel within"
        within = f"{within} {low:.3f} to {high:.3f} rad" if held else ""
        assert self._first is not None
        if self._time >= self.limits.time:
            return time_limit_reason_text(self._first, estimate, self.limits, self._farthest, within)
        if high - low >= MIN_SWING:
            return ""
        return "; ".join(filter(None, (within, unreached_friction_text(self._first, estimate))))

    def _replan(self, sample: Sample, state: ObserverState) -> None:
        """Take the best of the present path and a few changes of it."""
        present, left = self._present_path_point(sample), max(self.limits.time - self._time, self.dt)
        cases = self._forecaster.cases_at_state(self._likely_frictions(state), state)
        best = np.inf
        for kind in (KINDS[0], *islice(self._kinds, CHANGES)):
            path = changed_path(present, kind, self.limits, self.dt, left)
            cost = self._cost(path, cases, sample.F_N, best)
            if cost < best * (1 if kind == KINDS[0] else GAIN):
                best, self._path = cost, path
        self._since, self._due = 0.0, EVERY
        self._left = max(best, self._second - self._travel) if best < NEVER else nan

    def _present_path_point(self, sample: Sample) -> PathPoint:
        """Where the path is; where the wheel is, if that has left it."""
        path = self._path
        assert path is not None
        psi, psi_dot = (float(np.interp(self._since, path.t, y)) for y in (path.psi, path.psi_dot))
        leg = path.leg[min(int(self._since / path.dt), path.leg.size - 1)]
        points = tuple(float(np.clip(point, *self._bounds)) for point in path.points[leg:])
        if abs(psi - sample.psi) > ASTRAY[0] + ASTRAY[1] * self.limits.rate:
            psi, psi_dot = sample.psi, 0.0
        speed = max(0.0, psi_dot * np.sign(points[0] - psi))
        return PathPoint(psi, points, path.rate, speed, self._bounds, self._start)

    def _likely_frictions(self, state: ObserverState) -> list[float]:
        """Frictions that the observer holds for likely, within the prior."""
        if state["own"][_ACQUIRING]:
            verdict = dict(zip(VERDICT, state["verdict"], strict=True))
            mean, std = verdict["log_mu"], sqrt(max(verdict["variance"], 0.0))
        else:
            known = self._forecaster.observer.estimate(state)
            mean, std = np.log(known.mu), known.mu_std / known.mu
        std = min(std, MAX_DEVIATION)
        sigmas = (0.0,) if std < VAGUE else (-1.0, 0.0, 1.0)
        low, high = min(self.mus), max(self.mus)
        likely = [min(max(exp(mean + sigma * std), low), high) for sigma in sigmas]
        return list(dict.fromkeys(likely))

    def _cost(self, path: SteeringPath, cases: Sequence[ForecastCase], F_N: float, best: float) -> float:
        """Mean travel until the target; stops early, with a value above the best so far."""
        cost, travel = 0.0, path.travel
        for case in cases:
            last = min(int(np.searchsorted(travel, best * len(cases) - cost)), self._horizon)
            at, deviation = self._forecaster.at_target(
                path, case, F_N, self.target, self.limits.torque, last
            )
            cost += NEVER + deviation if at is None else float(travel[at])
            if cost > best * len(cases):
                break
        return cost / len(cases)

    def _advice(
        self, psi: float, estimate: Estimate, reason: str, ahead: float = 0.0, *, ends: bool = False
    ) -> Advice:
        """The advice; ahead is the time until the next sample [s], ends where the wheel is to stay."""
        finished, rate, toward, left = ends and not reason, 0.0, psi, 0.0 if ends else self._left
        if self._path is not None and not ends and isfinite(psi):
            path, at = self._path, self._since + ahead
            leg = path.leg[min(int(at / path.dt), path.leg.size - 1)]
            psi, rate = (float(np.interp(at, path.t, y)) for y in (path.psi, path.psi_dot))
            toward = float(path.points[leg])
        return Advice(
            psi=psi, psi_dot=rate, toward=toward, finished=finished, stopped=bool(reason),
            reason=reason, travel=self._travel, left=left, estimate=estimate,
        )  # fmt: skip
