"""Moving-horizon estimator for mu and, as measured, torque zero, stiffness, angle and rate.

States, noises and tuning are those of the filter, but the states of the last N samples are fitted at
once: every sample is linearised again at the states that later samples lead to, and samples that were
rejected are accepted when the ground turns out to have changed. Samples older than the window are summed
up in the arrival, mean and covariance, which a filter takes along behind the window, linearised at what
the window made of them. On a linear problem with Gaussian noise every window gives the Kalman filter.
Huber's loss differs: here the residual is that of the fitted states, there the innovation less its prior
variance.

Gauss-Newton steps minimise, over the states x_i at each of the last N samples,

    |x_1 - mean|^2 / P  +  sum_i |x_{i+1} - f_i(x_i)|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (y_i - h_i(x_i)) / R_i^(1/2),

with the mean and covariance P of the arrival, the motion f, the measurement y and their noises of the
measurement model, and no r_i where y_i is missing or rejected; mu is clipped to its bounds after each
step. rho is Huber's function. Where the ground has changed, Q_i of ln mu includes the variance between
two grounds. An empty place, before the window is full, has dt = 0: no motion, no measurement, no turn.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from dataclasses import dataclass
from functools import cache, partial

import casadi as ca

from observers.estimators.ekf_mhe_step_terms import StepSample, clip_to_bounds, step_symbols
from observers.estimators.mhe_recursions import (
    arrival_variance_increment,
    build_acceptance_update,
    build_back_substitution,
    build_forward_elimination,
    build_state_prediction,
    has_not_converged,
)
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout, Parts, symbols
from observers.measurement.measurement_model import CLEAN, RIG, ROWS, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import angle_is_state, slope_states
from observers.patch.patch_memory_over_window import PatchWindow
from observers.patch.patch_protocol import PatchModel
from observers.patch.update import memory_depends_on_tyre, reset_retention, sensitivity_retention
from observers.protocol import OUTPUT
from observers.quality.friction_change_by_stroke import change_monitor_fields
from observers.quality.outlier_or_ground_change import COUNTS
from observers.tuning import TUNING_FIELDS
from observers.udu import add_variance
from symbolic.named_and_buffered_functions import named_function


@dataclass(frozen=True, kw_only=True)
class Mhe(ModelObserver):
    """The estimator: settings as of `ModelObserver`, and those of its window.

    Attributes:
        window: samples fitted at once, N.
        iterations: Gauss-Newton steps a sample; the window begins where the last sample left it.

    Parts of its state: the memory of the patch, see `observers.patch.patch_memory_over_window`;
    `samples` (15, N), oldest first, dt = 0 in empty places; `x` (n, N), the states at each in the order
    of `states`; `mean` (n,) and `factor` (n, n), the arrival; `P_newest` (n, n), covariance of the
    newest x; `counts`; `monitor`; `output`.
    """

    window: int = 50
    iterations: int = 1

    @property
    def kind(self) -> str:
        """Kind of the estimator, for its title."""
        return f"Moving-horizon estimator over {self.window} samples"

    @property
    def estimator_layout(self) -> Layout:
        """The parts of a state, less those of the supervision."""
        return mhe_layout(self.model, self.measurement_model, self.window)

    @property
    def estimator_step(self) -> ca.Function:
        """One sample, without the supervision."""
        return build_mhe_step(self.model, self.measurement_model, self.window, self.iterations)


@cache
def mhe_layout(model: PatchModel, measurement_model: MeasurementModel, window: int) -> Layout:
    """The parts of the estimator's state."""
    n = len(measurement_model.states)
    return Layout.of(
        *PatchWindow(model=model, measurement_model=measurement_model, window=window).window_fields,
        samples=(len(ROWS), window), x=(n, window), mean=n, factor=(n, n), P_newest=(n, n),
        counts=len(COUNTS), monitor=len(change_monitor_fields(measurement_model)), output=len(OUTPUT),
    )  # fmt: skip


@cache
def build_window_smoother(measurement_model: MeasurementModel, window: int) -> ca.Function:
    """One Gauss-Newton step about x (n, N): minimiser over the window, covariance of its newest state.

    Inputs of all samples are in columns.
    """
    forward, backward = (
        build_forward_elimination(measurement_model),
        build_back_substitution(measurement_model),
    )
    n = len(measurement_model.states)
    inputs = symbols(
        ca.MX, mean=n, factor=(n, n), x=(n, window), M_z=(1, window),
        slopes=(len(slope_states(measurement_model)), window), samples=(len(ROWS), window),
        rig=len(RIG), tuning=len(TUNING_FIELDS),
    )  # fmt: skip
    mean, factor, x, M_z, slopes, samples, rig, tuning = inputs.values()
    constants = [ca.repmat(vector, 1, window) for vector in (rig, tuning)]
    onward = ca.horzcat(samples[:, 1:], samples[:, -1])
    _, _, filtered, P, K, score, H, A = forward.mapaccum("forward_window", window, 2, {})(
        mean, factor, x, M_z, slopes, samples, onward, *constants
    )
    reverse = list(range(window - 1, -1, -1))
    blocks = [n * i + j for i in reverse for j in range(n)]
    _, smoothed = backward.mapaccum("backward_window", window, 1, {})(
        ca.DM.zeros(n), filtered[:, reverse], P[:, blocks], K[:, reverse], score[:, reverse],
        H[:, reverse], A[:, blocks], constants[1],
    )  # fmt: skip
    return named_function("smoother", inputs, {"x_next": smoothed[:, reverse], "P_newest": P[:, -n:]})


@cache
def build_mhe_step(
    model: PatchModel, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    """One sample of the estimator: (state, sample, constants) -> (state_next, output)."""
    parts = mhe_layout(model, measurement_model, window)
    inputs = step_symbols(model, parts)
    before = parts.split(inputs["state"])
    last = before["samples"][: len(CLEAN), -1]
    sample = StepSample.of(model, measurement_model, inputs, last)
    patch = PatchWindow(model=model, measurement_model=measurement_model, window=window)
    torques = partial(patch.torques_and_slopes, theta=sample.theta, rig=sample.rig)
    # The oldest sample and the one after it, which in a window of one is the new one.
    oldest = ca.horzcat(before["samples"][:, : min(2, window)], ca.vertcat(sample.now, 1, 0))
    mean, factor = _update_arrival_cost(sample, before, oldest, torques(before, before["x"][:, 0]))
    torque = torques(patch.newest(before), before["x"][:, -1])
    predicted, P, retention = _predict(sample, before, last, torque)
    append = partial(patch.append, before, retention, sample.now, theta=sample.theta, rig=sample.rig)
    # A measured angle does not depend on the patch at the sample itself; a measured torque does.
    follows_angle = angle_is_state(measurement_model)
    history = patch.without_oldest(before) if follows_angle else append(x=predicted)
    x = ca.horzcat(before["x"][:, 1:], predicted)
    M_z, slopes = torques(history, x)
    test = sample.test_innovation(before, predicted, P, M_z[-1], slopes[:, -1])
    # A memory that depends on the old friction does not fit samples of the new ground: they stay
    # rejected.
    run = 1 if memory_depends_on_tyre(model, measurement_model) else test["run"]
    result, at = ca.MX(ca.vertcat(test["accepted"], test["reset"], run)), sample.mu_index
    samples = ca.horzcat(
        before["samples"][:, 1:], ca.vertcat(sample.sample_with_test_result(test), 1, 0)
    )
    samples = _update_acceptance(samples, result, sample.ground_change_variance)
    increment = arrival_variance_increment(window, test["reset"], run, sample.ground_change_variance)
    factor = add_variance(factor, at, increment)
    smoother = build_window_smoother(measurement_model, window)
    given = (samples, sample.rig, sample.tuning)
    for i in range(iterations):
        M_z, slopes = torques(history, x) if i > 0 else (M_z, slopes)
        previous = x[:, -1]
        x, P = smoother(mean, factor, x, M_z, slopes, *given)
    x_newest, M_z = x[:, -1], test["expected"]
    unsettled = has_not_converged(measurement_model, x_newest, previous, P)
    if follows_angle:
        history = append(x=x_newest)
        M_z, _ = torques(patch.newest(history), x_newest)
    old = reset_retention(test["reset"], before["P_newest"][at, at], sample.ground_change_variance)
    memory = patch.newest(history)["memory"]
    output = sample.output(x_newest, P, memory, M_z, test, unsettled=unsettled)
    state_next = {
        **patch.scale_newest_sensitivity(history, old), "samples": samples, "x": x, "mean": mean,
        "factor": factor, "P_newest": P, "counts": test["counts_next"],
        "monitor": test["monitor_next"], "output": output,
    }  # fmt: skip
    return named_function("mhe_step", inputs, {"state_next": parts.join(state_next), "output": output})


def _predict(
    sample: StepSample, before: Parts, last: ca.MX, torque: tuple[ca.MX, ca.MX]
) -> tuple[ca.MX, ca.MX, ca.MX]:
    """The newest states and their P before the sample is measured, and the sensitivity's retention."""
    x_last, P_last = before["x"][:, -1], before["P_newest"]
    x, P, Q = build_state_prediction(sample.measurement_model)(
        x_last, P_last, *torque, last, sample.now, sample.rig, sample.tuning
    )
    retention = sensitivity_retention(sample.measurement_model, P_last, Q, x_last, sample.now)
    return x, P, retention


def _update_arrival_cost(
    sample: StepSample, before: Parts, samples: ca.MX, torque: tuple[ca.MX, ca.MX]
) -> tuple[ca.MX, ca.MX]:
    """Mean and factor of the arrival after the oldest sample, linearised at its smoothed states."""
    mean, factor, *_ = build_forward_elimination(sample.measurement_model)(
        before["mean"], before["factor"], before["x"][:, 0], *torque, samples[:, 0], samples[:, 1],
        sample.rig, sample.tuning,
    )  # fmt: skip
    return clip_to_bounds(sample.measurement_model, mean, sample.tuning), factor


def _update_acceptance(samples: ca.MX, test: ca.MX, variance: ca.MX) -> ca.MX:
    """The samples of the window after the newest one's test, see `build_acceptance_update`."""
    window, ages = samples.shape[1], ca.DM(range(samples.shape[1] - 1, -1, -1)).T
    rows = (samples[ROWS.index("accepted"), :], samples[ROWS.index("jump"), :])
    constant = [ca.repmat(vector, 1, window) for vector in (test, variance)]
    acceptance = build_acceptance_update().map(window)(*rows, ages, *constant)
    return ca.vertcat(samples[: len(CLEAN), :], *acceptance)
