"""Moving-horizon estimator for mu and the zero of the torque channel, aligning torque measured.

It believes what the filter believes, of the same state, but fits mu and M_0 of the last N samples at
once: what a sample says is judged anew at the mu that later samples lead to, where the filter judged it
once.
Samples older than the window are summed up in its arrival mean and covariance, which a filter takes
along behind the window, linearised at what the window made of them. On a linear problem with Gaussian
noise every window gives the Kalman filter. `observers.window` has the cost and its sources.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.protocol import Estimate, Sample
from observers.settings import ModelSettings
from observers.stretches import build_stretch, first_sample, run_stretches
from observers.window import STATE, build_window_step
from symbolic import InvalidInputError, Model, compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class MheState:
    """State of the estimator, in the order of `observers.window.STATE`, and what it says.

    Attributes:
        memory: the model's memory before the oldest sample of the window, shape (m,).
        carried: its derivative by mu, shape (m, 1).
        held_at: the mu that memory stands for, shape (1,).
        mean: of x before the oldest sample, from all samples that left the window, shape (2,).
        P: its covariance, shape (2, 2).
        samples: rows psi, psi_dot, F_N, dt, M_z, oldest first, shape (5, N); dt = 0 in empty places.
        x: mu and M_0 at each sample, shape (2, N).
        P_newest: covariance of the newest x, shape (2, 2).
        M_z_predicted: torque expected at the newest sample before it was measured [N m].
    """

    memory: Array
    carried: Array
    held_at: Array
    mean: Array
    P: Array
    samples: Array
    x: Array
    P_newest: Array
    M_z_predicted: float

    @property
    def passed(self) -> tuple[Array, ...]:
        """What the next step needs, in the order of `observers.window.STATE`."""
        return tuple(getattr(self, name) for name in STATE)


@dataclass(frozen=True, kw_only=True)
class Mhe(ModelSettings):
    """The estimator: settings as of the filter, and those of its window.

    Attributes:
        window: samples fitted at once, N.
        iterations: Gauss-Newton steps a sample; the window begins where the last sample left it.
        huber: residual beyond which a sample counts less, in standard deviations of `tuning.noise`; None
            for least squares throughout.
    """

    window: int = 50
    iterations: int = 1
    huber: float | None = None

    def __post_init__(self) -> None:
        """Check the window."""
        for name in ("window", "iterations"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 1):
                raise InvalidInputError(f"{name} must be a whole number of at least 1, got {value}")
        if self.huber is not None and not self.huber > 0:
            raise InvalidInputError(f"huber must be greater than 0 or None, got {self.huber}")

    def init(self, first: Sample) -> MheState:
        """The state before the first sample: an empty window, the patch at rest at its angle."""
        memory, mean, P = self._start(first)
        empty = np.array([[first.psi], [0.0], [first.F_N], [0.0], [np.nan]])
        return MheState(
            memory=memory,
            carried=np.zeros((memory.size, 1)),
            held_at=mean[:1],
            mean=mean,
            P=P,
            samples=np.tile(empty, self.window),
            x=np.tile(mean.reshape(-1, 1), self.window),
            P_newest=P,
            M_z_predicted=float("nan"),
        )

    def step(self, state: MheState, sample: Sample) -> MheState:
        """One sample into the window, the oldest out of it, then the Gauss-Newton steps."""
        column = np.array([sample.psi, sample.psi_dot, sample.F_N, sample.dt, sample.M_z])
        made = _step(self.model, self.window, self.iterations)(*state.passed, column, *self._constant())
        memory, carried, held_at, mean, P, samples, x, P_newest, predicted = map(np.asarray, made)
        return MheState(
            memory=memory.ravel(),
            carried=carried,
            held_at=held_at.ravel(),
            mean=mean.ravel(),
            P=P,
            samples=samples,
            x=x,
            P_newest=P_newest,
            M_z_predicted=float(predicted.item()),
        )

    def estimate(self, state: MheState) -> Estimate:
        """Mean and standard deviation of mu at the newest sample."""
        std = float(np.sqrt(state.P_newest[0, 0]))
        return Estimate(
            mu=float(state.x[0, -1]),
            mu_std=std,
            M_z_predicted=state.M_z_predicted,
            informed=self.tuning.informed(std),
        )

    def run_samples(self, samples: Array) -> Sequence[Array]:
        """A whole recording, rows psi, psi_dot, F_N, dt, M_z; see `Observer.run_samples`."""
        state = self.init(first_sample(samples)).passed
        stretch = _stretch(self.model, self.window, self.iterations)
        pieces = []
        for made in run_stretches(stretch, state, samples, self._constant()):
            x, P_newest, predicted = made[-3:]
            newest = x[0, self.window - 1 :: self.window]
            pieces.append(np.vstack([newest.full(), P_newest[0, ::2].full(), predicted.full()]))
        mu, variance, predicted = np.hstack(pieces)[:, : samples.shape[1]]
        std = np.sqrt(variance)
        return mu, std, predicted, np.array([self.tuning.informed(s) for s in std])

    def _constant(self) -> tuple[Array, Array, Array]:
        huber = np.inf if self.huber is None else self.huber
        return self._theta(), self._geometry(), np.append(self.tuning.beliefs, huber)


@cache
def _step(model: Model, window: int, iterations: int) -> ca.Function:
    return compiled(build_window_step(model, window, iterations))


@cache
def _stretch(model: Model, window: int, iterations: int) -> ca.Function:
    step = build_window_step(model, window, iterations)
    return compiled(build_stretch(step, "mhe_stretch", len(STATE)))
