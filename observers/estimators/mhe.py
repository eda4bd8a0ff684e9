"""Moving-horizon estimator for mu and, as measured, torque zero, stiffness, angle and rate.

States, noises and tuning are those of the filter, but the states of the last N samples are fitted at
once: every sample is linearised again at the states that later samples lead to, and samples that were
rejected are accepted when the ground turns out to have changed. Samples older than the window are summed
up in the arrival, mean and covariance, which a filter takes along behind the window, linearised at what
the window made of them. On a linear problem with Gaussian noise every window gives the Kalman filter.
Huber's loss differs: here the residual is that of the fitted states, there the innovation less its prior
variance.
`observers.estimators.mhe_step` has the cost and its references.
"""

from dataclasses import dataclass

import casadi as ca

from observers.estimators.mhe_step import build_window_step, layout
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout
from symbolic import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class Mhe(ModelObserver):
    """The estimator: settings as of `ModelObserver`, and those of its window.

    Attributes:
        window: samples fitted at once, N.
        iterations: Gauss-Newton steps a sample; the window begins where the last sample left it.

    Parts of its state: the memory of the patch, see `observers.patch.history`; `samples` (15, N), oldest
    first, dt = 0 in empty places; `x` (n, N), the states at each in the order of `states`; `mean` (n,)
    and `factor` (n, n), the arrival; `P_newest` (n, n), covariance of the newest x; `counts`; `monitor`;
    `output`.
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

    @property
    def kind(self) -> str:
        """Kind of the estimator, for its title."""
        return f"Moving-horizon estimator over {self.window} samples"

    @property
    def estimator_layout(self) -> Layout:
        """The parts of a state, less those of the supervision."""
        return layout(self.model, self.measurement_model, self.window)

    @property
    def estimator_step(self) -> ca.Function:
        """One sample, without the supervision."""
        return build_window_step(self.model, self.measurement_model, self.window, self.iterations)
