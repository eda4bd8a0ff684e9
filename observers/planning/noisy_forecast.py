"""Forecasts with white noise of the torque: after which sample most of several runs know friction.

Without noise a path may end just behind the sample at which no flag stands any more, which noise moves.
"""

import numpy as np

from observers.estimators.model_observer import ModelObserver
from observers.planning.forecast import ForecastCase, Forecaster
from observers.planning.steering_path import SteeringPath
from observers.tuning import REFERENCE_STEP
from symbolic import full_slide_torque

RUNS, ENOUGH = 20, 18
"""Runs with noise on each ground, and how many of them have to reach the target."""
SEED = 1
MOST_NOISE = 0.01
"""Greatest noise over full slide at mu = 1 that counts where the rig declares none [1]."""


def assumed_noise(observer: ModelObserver, F_N: float) -> float:
    """White noise of the torque that a plan reckons with at a load [N], of a sample in 10 ms [N m]."""
    rig, slide = observer.rig, float(full_slide_torque(F_N, observer.rig.a))
    return min(observer.tuning.noise, MOST_NOISE) * slide if rig.noise is None else rig.noise


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
        std = assumed_noise(forecaster.observer, F_N) * max(1.0, REFERENCE_STEP / dt) ** 0.5
        self.enough = ENOUGH
        self.noise = std * np.random.default_rng(SEED).standard_normal((RUNS, samples))
        if quiet:
            self.enough, self.noise = 1, np.zeros((1, samples))

    def reached(
        self, path: SteeringPath, case: ForecastCase, last: int, *, every: bool = False
    ) -> list[int]:
        """Sorted samples, up to about the `last`, at which runs reach the target.

        Ends where too few do, except that every run is to be counted.
        """
        reached: list[int] = []
        for i, noise in enumerate(self.noise):
            at, _ = self.forecaster.forecast_until_target(
                path, case, self.F_N, self.target, self.most_torque, last, noise
            )
            if at is not None:
                reached.append(at)
            if not every and i - len(reached) >= len(self.noise) - self.enough:
                break
        return sorted(reached)

    def reach(self, path: SteeringPath, case: ForecastCase, last: int) -> tuple[int | None, float]:
        """First sample at which enough runs have reached the target, and it is met without noise too.

        Else None. With it the deviation there; where too few runs reach the target, less than that, the
        less the more do.
        """
        reached = self.reached(path, case, last)
        if len(reached) >= self.enough:
            return self.forecaster.forecast_until_target(
                path, case, self.F_N, self.target, self.most_torque, last,
                first=reached[self.enough - 1],
            )  # fmt: skip
        return None, self.target * (1 - len(reached) / len(self.noise))
