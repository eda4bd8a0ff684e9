"""One sample of the moving-horizon estimator as a casadi Function.

The window holds the last N samples, the states x_i at each of them, the memory of the patch, and mean
and covariance of x_1 given all samples that have left the window (the arrival). Gauss-Newton steps
minimise

    |x_1 - mean|^2 / P  +  sum_i |x_{i+1} - f_i(x_i)|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (y_i - h_i(x_i)) / R_i^(1/2),

with the motion f, the measurement y and their noises of the measurement model, and no r_i where y_i is
missing or rejected; mu is clipped to its bounds after each step. rho is Huber's function. Where the
ground has changed, Q_i of ln mu includes the variance between two grounds, and samples that were
rejected before are accepted again.

The memory of the patch is stored with every sample, see `observers.patch_history`.

An empty place, before the window is full, has dt = 0: no motion, no measurement, no turn.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import casadi as ca

from observers.innovation_gate import COUNTS, InnovationTest, build_innovation
from observers.innovation_monitor import MONITOR, change_variance
from observers.layout import Expression, Layout, Parts, build_function, named, outputs_of, symbols
from observers.linearisation import angle_is_state, build_clean, directions, state_index
from observers.measurement_model import CLEAN, RIG, ROWS, MeasurementModel
from observers.mhe_terms import (
    arrival_jump,
    build_acceptance,
    build_backward,
    build_forward,
    build_prediction,
    is_unsettled,
)
from observers.model_observer import clip_to_bounds, friction_output, step_output, step_symbols
from observers.patch_history import PatchHistory
from observers.patch_model import PatchModel, split_constants
from observers.patch_update import memory_depends_on_tyre, reset_retention, sensitivity_retention
from observers.protocol import OUTPUT
from observers.tuning import TUNING_FIELDS
from observers.udu import add_variance

Torques = Callable[[Parts, ca.MX], tuple[ca.MX, ca.MX]]


@cache
def layout(model: PatchModel, measurement_model: MeasurementModel, window: int) -> Layout:
    """The parts of the estimator's state."""
    n = len(measurement_model.states)
    return Layout(
        (
            *PatchHistory(model=model, measurement_model=measurement_model, window=window).fields,
            ("samples", len(ROWS), window),
            ("x", n, window),
            ("mean", n, 1),
            ("factor", n, n),
            ("P_newest", n, n),
            ("counts", len(COUNTS), 1),
            ("monitor", len(MONITOR), 1),
            ("output", len(OUTPUT), 1),
        )
    )


@cache
def build_smoother(measurement_model: MeasurementModel, window: int) -> ca.Function:
    """One Gauss-Newton step about x: minimiser over the window, covariance of its newest state.

    (mean, factor, x, M_z, slopes, samples, rig, tuning) -> (x_next, P_newest); inputs of all samples in
    columns, x (n, N).
    """
    forward, backward = build_forward(measurement_model), build_backward(measurement_model)
    n = len(measurement_model.states)
    inputs = symbols(
        ca.MX, mean=n, factor=(n, n), x=(n, window), M_z=(1, window),
        slopes=(len(directions(measurement_model)), window), samples=(len(ROWS), window),
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
    return build_function("smoother", inputs, {"x_next": smoothed[:, reverse], "P_newest": P[:, -n:]})


@dataclass(frozen=True, kw_only=True)
class _WindowSample:
    """What is given at a sample: both models, the cleaned sample, and the constants.

    torques(parts, x) is `PatchHistory.torques` with these constants.
    """

    patch: PatchHistory
    now: ca.MX
    theta: ca.MX
    rig: ca.MX
    tuning: ca.MX
    torques: Torques

    @property
    def change(self) -> Expression:
        """What a change of the ground adds to the variance of ln mu."""
        return change_variance(named(TUNING_FIELDS, self.tuning))


@dataclass(frozen=True, kw_only=True)
class _NewestPrediction:
    """States (n,) of the newest sample, their covariance, and the retention of the sensitivity."""

    x: ca.MX
    P: ca.MX
    retention: ca.MX


@dataclass(frozen=True, kw_only=True)
class _Window:
    """The problem of a window: arrival, states (n, N), samples, and the torques linearised at x."""

    mean: ca.MX
    factor: ca.MX
    x: ca.MX
    samples: ca.MX
    M_z: ca.MX
    slopes: ca.MX


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """States (n, N) of a window, the covariance of the newest, and whether they still move."""

    x: ca.MX
    P: ca.MX
    unsettled: ca.MX


@cache
def build_window_step(
    model: PatchModel, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    """One sample of the estimator: (state, sample, constants) -> (state_next, output)."""
    parts = layout(model, measurement_model, window)
    inputs = step_symbols(model, parts)
    before = parts.split(inputs["state"])
    theta, rig, tuning = split_constants(model, inputs["constants"])
    patch = PatchHistory(model=model, measurement_model=measurement_model, window=window)
    last = before["samples"][: len(CLEAN), -1]
    now, imputed = build_clean(measurement_model)(inputs["sample"], last)
    torques = partial(patch.torques, theta=theta, rig=rig)
    sample = _WindowSample(patch=patch, now=now, theta=theta, rig=rig, tuning=tuning, torques=torques)
    samples = ca.horzcat(before["samples"], ca.vertcat(now, 1, 0))
    mean, factor = _arrival(sample, before, samples)
    predicted = _predict(sample, before, last)
    append = partial(patch.append, before, predicted.retention, now, theta=theta, rig=rig)
    # A measured angle does not depend on the patch at the sample itself; a measured torque does.
    after_angle = angle_is_state(measurement_model)
    history = patch.without_oldest(before) if after_angle else append(x=predicted.x)
    x = ca.horzcat(before["x"][:, 1:], predicted.x)
    M_z, slopes = torques(history, x)
    test = _test(sample, before, predicted, M_z[-1], slopes[:, -1])
    # A memory that depends on the old friction does not fit samples of the new ground: they stay
    # rejected.
    run = 1 if memory_depends_on_tyre(model, measurement_model) else test.run
    samples = _accept(samples[:, 1:], ca.MX(ca.vertcat(test.accepted, test.reset, run)), sample.change)
    at = state_index(measurement_model)
    factor = add_variance(factor, at, arrival_jump(window, test.reset, run, sample.change))
    problem = _Window(mean=mean, factor=factor, x=x, samples=samples, M_z=M_z, slopes=slopes)
    fit = _correct(sample, problem, history, iterations)
    x_newest, M_z = fit.x[:, -1], test.expected
    if after_angle:
        history = append(x=x_newest)
        M_z, _ = torques(patch.newest(history), x_newest)
    old = reset_retention(test.reset, before["P_newest"][at, at], sample.change)
    memory = patch.newest(history)["memory"]
    friction = friction_output(model, x_newest, fit.P, memory, now, theta, rig, tuning, at=at)
    output = step_output(
        measurement_model, x_newest, friction, M_z, tuning, vars(test), held=imputed,
        unsettled=fit.unsettled,
    )  # fmt: skip
    state_next = {
        **patch.scale_newest_sensitivity(history, old), "samples": samples, "x": fit.x, "mean": mean,
        "factor": factor, "P_newest": fit.P, "counts": test.counts_next,
        "monitor": test.monitor_next, "output": output,
    }  # fmt: skip
    return build_function("mhe_step", inputs, {"state_next": parts.join(state_next), "output": output})


def _predict(sample: _WindowSample, before: Parts, last: ca.MX) -> _NewestPrediction:
    """The newest states, before the sample is measured."""
    measurement_model, x_last = sample.patch.measurement_model, before["x"][:, -1]
    x, P, Q = build_prediction(measurement_model)(
        x_last, before["P_newest"], *sample.torques(sample.patch.newest(before), x_last), last,
        sample.now, sample.rig, sample.tuning,
    )  # fmt: skip
    retention = sensitivity_retention(measurement_model, before["P_newest"], Q, x_last)
    return _NewestPrediction(x=x, P=P, retention=retention)


def _test(
    sample: _WindowSample, before: Parts, predicted: _NewestPrediction, M_z: ca.MX, slopes: ca.MX
) -> InnovationTest:
    """The innovation at the predicted states, and its test."""
    results = outputs_of(
        build_innovation(sample.patch.measurement_model), predicted.x, predicted.P, M_z, slopes,
        sample.now, before["counts"], before["monitor"], sample.rig, sample.tuning,
    )  # fmt: skip
    return InnovationTest(**results)


def _correct(sample: _WindowSample, problem: _Window, history: Parts, iterations: int) -> _Fit:
    """Gauss-Newton steps over the window."""
    measurement_model = sample.patch.measurement_model
    smoother = build_smoother(measurement_model, problem.x.shape[1])
    x, M_z, slopes = problem.x, problem.M_z, problem.slopes
    for i in range(iterations):
        M_z, slopes = sample.torques(history, x) if i > 0 else (M_z, slopes)
        previous = x[:, -1]
        x, P = smoother(
            problem.mean, problem.factor, x, M_z, slopes, problem.samples, sample.rig, sample.tuning
        )
    return _Fit(x=x, P=P, unsettled=is_unsettled(measurement_model, x[:, -1], previous, P))


def _arrival(sample: _WindowSample, before: Parts, samples: ca.MX) -> tuple[ca.MX, ca.MX]:
    """Mean and factor of the arrival after the oldest sample, linearised at its smoothed states."""
    measurement_model, oldest = sample.patch.measurement_model, before["x"][:, 0]
    mean, factor, *_ = build_forward(measurement_model)(
        before["mean"], before["factor"], oldest, *sample.torques(before, oldest), samples[:, 0],
        samples[:, 1], sample.rig, sample.tuning,
    )  # fmt: skip
    return clip_to_bounds(measurement_model, mean, sample.tuning), factor


def _accept(samples: ca.MX, test: ca.MX, variance: ca.MX) -> ca.MX:
    """The samples of the window after the newest one's test, see `build_acceptance`."""
    window, ages = samples.shape[1], ca.DM(range(samples.shape[1] - 1, -1, -1)).T
    rows = (samples[ROWS.index("accepted"), :], samples[ROWS.index("jump"), :])
    acceptance = build_acceptance().map(window) if window > 1 else build_acceptance()
    constant = [ca.repmat(vector, 1, window) for vector in (test, variance)]
    return ca.vertcat(samples[: len(CLEAN), :], *acceptance(*rows, ages, *constant))
