"""Forecast of an observer's estimates along a path, for each of several frictions.

The observer's own step runs on the torque that it expects itself at a friction: the filter without its
supervision, started at that friction, predicts it while no torque is measured. So the deviation forecast
is that of the observer by construction: hypotheses, tolerances of k, a, e, load and zero, its error
model, the yaw rate that it takes from the angle, and what makes it `usable`. White noise of the torque
may be added, and makes it acquire later, or not at all: without it a path may end just behind the sample
at which no flag stands any more. So would a k other than declared, which a forecast cannot know.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from observers.compiled_step import CompiledStretch, compiled_stretch
from observers.estimators.ekf import Ekf
from observers.estimators.ekf_mhe_step_terms import DRY_FRICTION
from observers.estimators.model_observer import ModelObserver
from observers.layout import ObserverState
from observers.measurement.directional_friction import OTHER
from observers.measurement.measurement_model import AligningTorque
from observers.planning.steering_limits_and_paths import SteeringPath
from observers.protocol import OUTPUT, SAMPLE, Sample
from observers.quality.acquisition import OWN
from observers.tuning import REFERENCE_STEP, mu_std_floor_by_cause
from symbolic import full_slide_torque
from symbolic.float_array_type import Array

SAMPLES_PER_CALL = 25
"""Samples of one compiled call; between two calls a forecast may end."""
RUNS, ENOUGH = 20, 18
"""Runs with noise on each ground, and how many of them have to reach the target."""
SEED = 1
MOST_NOISE = 0.01
"""Greatest noise over full slide at mu = 1 that counts where the rig declares none [1]."""
MU, STD, TORQUE, STATUS = (OUTPUT.index(n) for n in ("mu", "mu_std", "M_z_predicted", "status"))


@dataclass(frozen=True, kw_only=True, eq=False)
class ForecastCase:
    """A friction that the ground may have, and where wheel and observer begin."""

    mu: float  # That friction [1], at which the torque filter predicts the torque.
    torque_filter_state: Array
    torque_filter_constants: Array
    state: Array
    scale: float = 1.0  # That torque is multiplied by it, as the observer divides by it [1].


@dataclass(frozen=True, kw_only=True, eq=False)
class Forecast:
    """Estimates of the observer along the samples of a path, at one friction; arrays of shape (n,)."""

    mu: Array
    deviation: Array  # Standard deviation over the estimate [1].
    usable: NDArray[np.bool_]
    torque: Array  # That which is measured [N m].
    status: NDArray[np.int64]

    def first_samples(self, end: int) -> "Forecast":
        """Its first samples."""
        return Forecast(**{name: values[:end] for name, values in vars(self).items()})

    def first_within(self, target: float, most_torque: float = np.inf, first: int = 0) -> int | None:
        """First usable sample, from `first` on, within the target; none after too great a torque."""
        good = np.flatnonzero(self.deviations_or_inf(most_torque)[first:] <= target)
        return first + int(good[0]) if good.size else None

    def least_deviation_index(self, most_torque: float = np.inf) -> int | None:
        """Sample with the least of these deviations; None where none is usable."""
        least = self.deviations_or_inf(most_torque)
        return int(np.argmin(least)) if np.isfinite(least).any() else None

    def deviations_or_inf(self, most_torque: float) -> Array:
        """Deviations, infinite where they are not usable or the torque has been too great."""
        allowed = np.arange(self.torque.size) < self.samples_within_torque_limit(most_torque)
        return np.where(self.usable & allowed, self.deviation, np.inf)

    def samples_within_torque_limit(self, most_torque: float) -> int:
        """Number of samples until the torque is too great."""
        return int(np.argmax(np.append(np.abs(self.torque) > most_torque, True)))


class Forecaster:
    """Forecasts of an `Ekf` or `Mhe`; the filter costs about 10 microseconds a sample and friction."""

    def __init__(self, observer: ModelObserver) -> None:
        """Compile what it needs, or take it from the cache."""
        self.observer = observer
        turned = observer.measurement_model
        if observer.channel == "M":
            turned = AligningTorque(zero=False)
        self.torque_filter = Ekf(
            model=observer.model, values=observer.values, rig=observer.rig, tuning=observer.tuning,
            measurement_model=turned, acquire=False,
        )  # fmt: skip
        self._torque, self._step = (
            CompiledStretch(compiled_stretch(one.screened_step, SAMPLES_PER_CALL))
            for one in (self.torque_filter, observer)
        )

    def cases_at_rest(
        self, mus: Iterable[float], psi: float, F_N: float, dt: float
    ) -> list[ForecastCase]:
        """Cases of a wheel that has stood at psi since the observer began; mus are effective ones."""
        first = Sample(psi=psi, psi_dot=0.0, F_N=F_N, dt=dt)
        state, cases = self.observer.init(first).values, []
        stands = self.torque_filter.step(self.torque_filter.init(first), first)
        prior = self.torque_filter.estimate(stands)
        for mu in mus:
            own = mu * (prior.mu / prior.mu_eff)
            ground = replace(self.torque_filter, tuning=replace(self.observer.tuning, mu=own))
            cases.append(
                ForecastCase(
                    mu=mu, torque_filter_state=ground.init(first).values,
                    torque_filter_constants=ground.constants, state=state,
                )
            )  # fmt: skip
        return cases

    def cases_at_state(self, mus: Iterable[float], state: ObserverState) -> list[ForecastCase]:
        """Cases from the present state of the observer, which is a filter of an aligning torque."""
        ground = state.values[: self.torque_filter.layout.size]
        screen = state["screen"]
        at = self.torque_filter.layout.places["x"][0].start + self.torque_filter.states.index("log_mu")
        scale = float(state["own"][OWN.index("scale")]) if "own" in state.layout.places else 1.0
        cases = []
        for mu in mus:
            start = np.concatenate([ground, screen])
            start[at] = np.log(mu / scale)
            cases.append(
                ForecastCase(
                    mu=mu, torque_filter_state=start, state=state.values, scale=scale,
                    torque_filter_constants=self.torque_filter.constants,
                )
            )  # fmt: skip
        return cases

    def growing_forecasts(
        self, path: SteeringPath, case: ForecastCase, F_N: float, noise: Array | None = None
    ) -> Iterator[Forecast]:
        """Forecasts of a case from its first sample, each `SAMPLES_PER_CALL` samples longer.

        The noise of the measured torque has an element a sample at least [N m].
        """
        samples = np.full((len(SAMPLE), path.psi.size), np.nan)
        samples[0], samples[1], samples[2], samples[3] = path.psi, path.psi_dot, F_N, path.dt
        inertia = self._inertia_and_damping_torque(path)
        parts: list[Array] = []
        ground, state = case.torque_filter_state, case.state
        for first in range(0, path.psi.size, SAMPLES_PER_CALL):
            given = samples[:, first : first + SAMPLES_PER_CALL]
            count, end = given.shape[1], first + given.shape[1]
            given = np.pad(given, ((0, 0), (0, SAMPLES_PER_CALL - count)), mode="edge")
            states, expected = self._torque(ground, given, case.torque_filter_constants)
            ground = states[:, -1].copy()
            torque = case.scale * expected[TORQUE]
            if self.observer.channel == "M":
                torque = np.pad(inertia[first:end], (0, SAMPLES_PER_CALL - count)) - torque
            given[SAMPLE.index(self.observer.channel)] = torque
            if noise is not None:
                given[SAMPLE.index(self.observer.channel), :count] += noise[first:end]
            given[SAMPLE.index("psi_dot"), :count] = path.rate_from_past_angles[first:end]
            states, output = self._step(state, given, self.observer.constants)
            state = states[:, -1].copy()
            parts.append(np.vstack([output, torque])[:, :count])
            yield self._forecast(np.hstack(parts))

    def at_target(
        self, path: SteeringPath, case: ForecastCase, F_N: float,
        target: float, most_torque: float, last: int, noise: Array | None = None, first: int = 0,
    ) -> tuple[int | None, float]:  # fmt: skip
        """First sample, from `first` to about `last`, that reaches the target, and the deviation there.

        None where it is not, with the least deviation up to there, 1 at most.
        """
        deviation = 1.0
        for forecast in self.growing_forecasts(path, case, F_N, noise):
            at = forecast.first_within(target, most_torque, first)
            if at is not None:
                return at, float(forecast.deviation[at])
            deviation = min(1.0, float(forecast.deviations_or_inf(most_torque).min()))
            newest = np.abs(forecast.torque[-SAMPLES_PER_CALL:]).max()
            if forecast.mu.size > last or newest > most_torque:
                break
        return None, deviation

    def forecast_whole(self, path: SteeringPath, case: ForecastCase, F_N: float) -> Forecast:
        """The forecast of a case along the whole path."""
        *_, last = self.growing_forecasts(path, case, F_N)
        return last

    def _inertia_and_damping_torque(self, path: SteeringPath) -> Any:
        """Torque of inertia and damping [N m], where the steering torque is measured."""
        rig = self.observer.rig
        if self.observer.channel != "M":
            return None
        return (rig.J_A or 0.0) * np.gradient(path.psi_dot, path.dt) + (rig.b_t or 0.0) * path.psi_dot

    def _forecast(self, rows: Array) -> Forecast:
        deviation = rows[STD] / rows[MU]
        usable = (rows[STATUS] == 0) & (deviation < self.observer.informed_below)
        status = np.nan_to_num(rows[STATUS]).astype(int)
        return Forecast(mu=rows[MU], deviation=deviation, usable=usable, torque=rows[-1], status=status)


class NoisyForecaster:
    """Runs of a `Forecaster` with the noise that the rig declares, or else its tuning, but `MOST_NOISE`.

    The same runs serve every path: the noise of a sample does not depend on what was steered before.
    """

    def __init__(
        self, forecaster: Forecaster, F_N: float, target: float, most_torque: float, dt: float,
        samples: int, *, quiet: bool = False,
    ) -> None:  # fmt: skip
        """Draw the noise of so many samples, dt apart [s]; load [N], target [1], torque [N m].

        Quiet is one run without noise.
        """
        self.forecaster, self.F_N, self.target, self.most_torque = forecaster, F_N, target, most_torque
        std = assumed_torque_noise(forecaster.observer, F_N) * max(1.0, REFERENCE_STEP / dt) ** 0.5
        self.enough = ENOUGH
        self.noise = std * np.random.default_rng(SEED).standard_normal((RUNS, samples))
        if quiet:
            self.enough, self.noise = 1, np.zeros((1, samples))

    def samples_at_target(
        self, path: SteeringPath, case: ForecastCase, last: int, *, every: bool = False
    ) -> list[int]:
        """Sorted samples, up to about the `last`, at which runs reach the target.

        Ends where too few do, except that every run is to be counted.
        """
        reached: list[int] = []
        for i, noise in enumerate(self.noise):
            at, _ = self.forecaster.at_target(
                path, case, self.F_N, self.target, self.most_torque, last, noise
            )
            if at is not None:
                reached.append(at)
            if not every and i - len(reached) >= len(self.noise) - self.enough:
                break
        return sorted(reached)

    def at_target(self, path: SteeringPath, case: ForecastCase, last: int) -> tuple[int | None, float]:
        """First sample at which enough runs are at the target, as is one without noise; else None.

        With it the deviation there; where too few runs reach the target, less than that, the less the
        more do.
        """
        reached = self.samples_at_target(path, case, last)
        if len(reached) >= self.enough:
            return self.forecaster.at_target(
                path, case, self.F_N, self.target, self.most_torque, last,
                first=reached[self.enough - 1],
            )  # fmt: skip
        return None, self.target * (1 - len(reached) / len(self.noise))


def assumed_torque_noise(observer: ModelObserver, F_N: float) -> float:
    """White noise of the torque that a plan reckons with at a load [N], of a sample in 10 ms [N m]."""
    rig, slide = observer.rig, float(full_slide_torque(F_N, observer.rig.a))
    return min(observer.tuning.noise, MOST_NOISE) * slide if rig.noise is None else rig.noise


def irreducible_mu_std(observer: ModelObserver, mu: float, F_N: float) -> dict[str, float]:
    """Deviations that no steering lowers, by cause, as shares of mu [1]; they add in quadrature."""
    causes = mu_std_floor_by_cause(observer.tuning, observer.rig)
    slide = float(full_slide_torque(F_N, observer.rig.a))
    dry = observer.rig.dry_friction
    causes["dry friction"] = (DRY_FRICTION if dry is None else dry / slide) / mu
    states, zero = observer.measurement_model.states, observer.rig.zero_std
    if OTHER in states and "M_0" not in states:
        causes["zero of the torque"] = (observer.tuning.zero_std if zero is None else zero / slide) / mu
    return causes


def percent_text_beside_target(value: float, target: float) -> str:
    """A share in per cent, with the digits that tell it from a target."""
    told = (f"{value:.{n}%}" for n in range(1, 5) if f"{value:.{n}%}" != f"{target:.{n}%}")
    return next(told, f"{value:.1%}")


def unreachable_target_text(observer: ModelObserver, target: float, mu: float, F_N: float) -> str:
    """Why no steering at all reaches a target at a friction; empty where one may."""
    causes = irreducible_mu_std(observer, mu, F_N)
    floor, cause = hypot(*causes.values()), max(causes, key=lambda name: causes[name])
    if floor < target:
        return ""
    return (
        f"{target:.1%} cannot be reached by any steering: {cause} alone"
        f" {'leave' if cause[:10] == 'tolerances' else 'leaves'} {causes[cause]:.1%}, all that no"
        f" measurement lowers {percent_text_beside_target(floor, target)}"
    )
