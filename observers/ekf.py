"""Extended Kalman filter for mu and the zero of the torque channel, aligning torque measured.

State x = (mu, M_0): both random walks, mu of the ground and M_0 of the sensor. The measurement is
M_z = h(memory, mu) + M_0, where the memory of the patch is not a random state: given mu it is known. Its
derivative by mu is carried along exactly, so that d M_z / d mu holds the whole history, and a correction
of mu corrects the memory too. The filter knows nothing of tyres: h is the model's step.

Source: Jazwinski, Stochastic Processes and Filtering Theory (1970); the covariance in Joseph's form,
Bucy and Joseph (1968), which stays positive definite under rounding.
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
from observers.tuning import REFERENCE_STEP
from symbolic import Model, compiled, full_slide_torque, step_along

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class EkfState:
    """State of the filter.

    Attributes:
        memory: the model's memory, shape (m,).
        carried: its derivative by mu, shape (m, 1).
        x: mean in the order of `STATES`, shape (2,).
        P: covariance, shape (2, 2).
        M_z_predicted: torque expected at the last sample before it was measured [N m].
    """

    memory: Array
    carried: Array
    x: Array
    P: Array
    M_z_predicted: float


@dataclass(frozen=True, kw_only=True)
class Ekf(ModelSettings):
    """The filter; its settings are those of `ModelSettings`."""

    def init(self, first: Sample) -> EkfState:
        """The state before the first sample, the patch at rest at its angle."""
        memory, x, P = self._start(first)
        carried = np.zeros((memory.size, 1))
        return EkfState(memory=memory, carried=carried, x=x, P=P, M_z_predicted=float("nan"))

    def step(self, state: EkfState, sample: Sample) -> EkfState:
        """One sample: predict, then correct where M_z was measured."""
        column = np.array([sample.psi, sample.psi_dot, sample.F_N, sample.dt, sample.M_z])
        outputs = _step(self.model)(
            state.memory, state.carried, state.x, state.P, column,
            self._theta(), self._geometry(), self.tuning.beliefs,
        )  # fmt: skip
        memory, carried, x, P, predicted = (np.asarray(output) for output in outputs)
        return EkfState(
            memory=memory.ravel(),
            carried=carried,
            x=x.ravel(),
            P=P,
            M_z_predicted=float(predicted.item()),
        )

    def estimate(self, state: EkfState) -> Estimate:
        """Mean and standard deviation of mu."""
        std = float(np.sqrt(state.P[0, 0]))
        return Estimate(
            mu=float(state.x[0]),
            mu_std=std,
            M_z_predicted=state.M_z_predicted,
            informed=self.tuning.informed(std),
        )

    def run_samples(self, samples: Array) -> Sequence[Array]:
        """A whole recording, rows psi, psi_dot, F_N, dt, M_z; see `Observer.run_samples`."""
        first = self.init(first_sample(samples))
        state = (first.memory, first.carried, first.x, first.P)
        constant = (self._theta(), self._geometry(), self.tuning.beliefs)
        pieces = []
        for made in run_stretches(_stretch(self.model), state, samples, constant):
            mu, variance = made[2][0, :].full(), made[3][0, ::2].full()
            pieces.append(np.vstack([mu, variance, made[4].full().reshape(1, -1)]))
        mu, variance, predicted = np.hstack(pieces)[:, : samples.shape[1]]
        std = np.sqrt(variance)
        return mu, std, predicted, np.array([self.tuning.informed(s) for s in std])


@cache
def _step(model: Model) -> ca.Function:
    return compiled(build_step(model))


@cache
def _stretch(model: Model) -> ca.Function:
    return compiled(build_stretch(build_step(model), "ekf_stretch", 4))


@cache
def build_step(model: Model) -> ca.Function:
    """One sample of the filter as a casadi Function with named inputs and outputs.

    (memory, carried, x, P, sample, theta, geometry, beliefs) -> (memory, carried, x, P, M_z_predicted);
    sample holds psi, psi_dot, F_N, dt, M_z, with M_z NaN for prediction alone.
    """
    size, parameters = model.memory_size, len(model.parameters)
    memory, carried = ca.MX.sym("memory", size), ca.MX.sym("carried", size)
    x, P = ca.MX.sym("x", 2), ca.MX.sym("P", 2, 2)
    sample, beliefs = ca.MX.sym("sample", 5), ca.MX.sym("beliefs", 5)
    theta, geometry = ca.MX.sym("theta", parameters), ca.MX.sym("geometry", 2)
    believed = ca.vertcat(x[0], theta[1:])
    along = ca.DM.zeros(parameters)
    along[0] = 1
    after, carried_after, M_z, slope = step_along(model, 1)(
        memory, carried, sample[:4], believed, along, geometry
    )
    slide = full_slide_torque(sample[2], geometry[0])
    corrected = _correct(x, P, M_z, slope, sample[4], sample[3], slide, beliefs)
    x_after, P_after = corrected
    names = ["memory", "carried", "x", "P"]
    return ca.Function(
        "ekf_step",
        [memory, carried, x, P, sample, theta, geometry, beliefs],
        [after + carried_after * (x_after[0] - x[0]), carried_after, x_after, P_after, M_z + x[1]],
        [*names, "sample", "theta", "geometry", "beliefs"],
        [*(f"{name}_next" for name in names), "M_z_predicted"],
    )


def _correct(
    x: ca.MX,
    P: ca.MX,
    M_z: ca.MX,
    slope: ca.MX,
    measured: ca.MX,
    dt: ca.MX,
    slide: ca.MX,
    beliefs: ca.MX,
) -> tuple[ca.MX, ca.MX]:
    """Random walk over dt, then the correction by one torque measurement, NaN for none."""
    mu_walk, zero_walk, noise, least, greatest = ca.vertsplit(beliefs)
    P = P + dt * ca.diag(ca.vertcat(mu_walk, zero_walk * slide) ** 2)
    H = ca.horzcat(slope, 1)
    R = (noise * slide) ** 2 * REFERENCE_STEP / dt
    # casadi takes x == x for true; no comparison with NaN is.
    present = ca.fabs(measured) < ca.inf
    K = ca.if_else(present, 1, 0) * P @ H.T / (H @ P @ H.T + R)
    innovation = ca.if_else(present, measured, M_z + x[1]) - (M_z + x[1])
    x = x + K * innovation
    x = ca.vertcat(ca.fmax(least, ca.fmin(greatest, x[0])), x[1])
    keep = ca.MX.eye(2) - K @ H
    return x, keep @ P @ keep.T + K * R @ K.T
