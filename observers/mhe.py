"""Moving-horizon estimator for mu and, as measured, torque zero, stiffness, angle and rate.

It believes what the filter believes, of the same states, but fits those of the last N samples at once:
what a sample says is judged anew at the states that later samples lead to, where the filter judged it
once; and samples that were not believed count again when the ground turns out to have changed. Samples
older than the window are summed up in its arrival, mean and covariance, which a filter takes along
behind the window, linearised at what the window made of them. On a linear problem with Gaussian noise
every window gives the Kalman filter. Huber's loss differs: here a residual is what the fitted states
leave, there what the filter had expected, less what it could not yet know. `observers.mhe_step` has the
cost and its sources.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from observers.base import ModelObserver
from observers.compiled_step import build_stretch
from observers.layout import Layout, ObserverState
from observers.measurement_model import CLEAN, MeasurementModel
from observers.mhe_step import build_window_step, layout
from observers.mhe_terms import ROWS
from observers.protocol import Sample
from symbolic import SIGNALS, InvalidInputError, Model, compiled


@dataclass(frozen=True, kw_only=True)
class Mhe(ModelObserver):
    """The estimator: settings as of `ModelObserver`, and those of its window.

    Attributes:
        window: samples fitted at once, N.
        iterations: Gauss-Newton steps a sample; the window begins where the last sample left it.

    Parts of its state: what the patch remembers, see `observers.patch_history`; `samples` (9, N), oldest
    first, dt = 0 in empty places; `x` (n, N), the states at each in the order of `states`; `mean` (n,)
    and `factor` (n, n), the arrival; `P_newest` (n, n), covariance of the newest x; `counts`; `said`.
    """

    window: int = 50
    iterations: int = 1

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        for name in ("window", "iterations"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 1):
                raise InvalidInputError(f"{name} must be a whole number of at least 1, got {value}")

    def init(self, first: Sample) -> ObserverState:
        """The state before the first sample: an empty window, the patch at rest at its angle."""
        start = self._start(first)
        empty = np.zeros((len(ROWS), 1))
        empty[: len(CLEAN)] = start["last"]
        seen = dict.fromkeys(SIGNALS, 0.0) | {"psi": first.psi, "F_N": first.F_N}
        values = self.layout.pack({
            **start,
            "turned": np.array([[first.psi], [0.0]]),
            "seen": np.array([[seen[name]] for name in SIGNALS]),
            "samples": empty,
            "mean": start["x"],
            "P_newest": start["factor"],
        })  # fmt: skip
        return ObserverState(values, self.layout)

    @property
    def layout(self) -> Layout:
        """The parts of a state."""
        return layout(self.model, self.measurement_model, self.window)

    @property
    def function(self) -> ca.Function:
        """One sample, compiled; see `ModelObserver.function`."""
        return _compiled_step(self.model, self.measurement_model, self.window, self.iterations)

    @property
    def stretch(self) -> ca.Function:
        """Many samples, compiled; see `ModelObserver.stretch`."""
        return _compiled_stretch(self.model, self.measurement_model, self.window, self.iterations)


@cache
def _compiled_step(
    model: Model, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    return compiled(build_window_step(model, measurement_model, window, iterations))


@cache
def _compiled_stretch(
    model: Model, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    return compiled(build_stretch(build_window_step(model, measurement_model, window, iterations)))
