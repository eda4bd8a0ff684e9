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

from functools import cache, partial

import casadi as ca

from observers.innovation_gate import COUNTS, build_innovation
from observers.innovation_monitor import MONITOR, change_variance
from observers.layout import Layout, named, outputs_of
from observers.linearisation import build_clean, state_index
from observers.measurement_model import CLEAN, ROWS, MeasurementModel
from observers.mhe_terms import (
    arrival_jump,
    build_acceptance,
    build_backward,
    build_forward,
    build_prediction,
    is_unsettled,
)
from observers.model_observer import (
    build_step_function,
    clip_to_bounds,
    friction_output,
    step_output,
    step_symbols,
)
from observers.patch_history import PatchHistory
from observers.patch_model import PatchModel, split_constants
from observers.patch_update import memory_depends_on_tyre, reset_retention, sensitivity_retention
from observers.protocol import OUTPUT
from observers.tuning import TUNING_FIELDS


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
    mean, factor, x, M_z, slopes, samples, _, rig, tuning = (
        ca.MX.sym(name, forward.size1_in(name), forward.size2_in(name) * columns)
        for name, columns in zip(forward.name_in(), [1, 1, *[window] * 5, 1, 1], strict=True)
    )
    constants = [ca.repmat(vector, 1, window) for vector in (rig, tuning)]
    onward = ca.horzcat(samples[:, 1:], samples[:, -1])
    _, _, filtered, P, K, score, H, A = forward.mapaccum("forward_window", window, 2, {})(
        mean, factor, x, M_z, slopes, samples, onward, *constants
    )
    n = len(measurement_model.states)
    reverse = list(range(window - 1, -1, -1))
    blocks = [n * i + j for i in reverse for j in range(n)]
    _, smoothed = backward.mapaccum("backward_window", window, 1, {})(
        ca.DM.zeros(n), filtered[:, reverse], P[:, blocks], K[:, reverse], score[:, reverse],
        H[:, reverse], A[:, blocks], constants[1],
    )  # fmt: skip
    return ca.Function(
        "smoother",
        [mean, factor, x, M_z, slopes, samples, rig, tuning],
        [smoothed[:, reverse], P[:, -n:]],
        ["mean", "factor", "x", "M_z", "slopes", "samples", "rig", "tuning"],
        ["x_next", "P_newest"],
    )


@cache
def build_window_step(
    model: PatchModel, measurement_model: MeasurementModel, window: int, iterations: int
) -> ca.Function:
    """One sample of the estimator: (state, sample, constants) -> (state_next, output)."""
    parts = layout(model, measurement_model, window)
    state, sample, constants = symbols = step_symbols(model, parts)
    before = parts.split(state)
    theta, rig, tuning = split_constants(model, constants)
    patch = PatchHistory(model=model, measurement_model=measurement_model, window=window)
    torques = partial(patch.torques, theta=theta, rig=rig)
    last = before["samples"][: len(CLEAN), -1]
    now, imputed = build_clean(measurement_model)(sample, last)
    samples = ca.horzcat(before["samples"], ca.vertcat(now, 1, 0))
    mean, factor = _arrival(measurement_model, before, samples, torques, rig, tuning)
    x_last, P = before["x"][:, -1], before["P_newest"]
    x_newest, P, Q = build_prediction(measurement_model)(
        x_last, P, *torques(patch.newest(before), x_last), last, now, rig, tuning
    )
    retention = sensitivity_retention(measurement_model, before["P_newest"], Q, x_last)
    append = partial(patch.append, before, retention, now, theta=theta, rig=rig)
    history = measurement_model.patch_before(patch.without_oldest(before), partial(append, x=x_newest))
    x, samples = ca.horzcat(before["x"][:, 1:], x_newest), samples[:, 1:]
    M_z, slopes = torques(history, x)
    test = outputs_of(
        build_innovation(measurement_model), x_newest, P, M_z[-1], slopes[:, -1], now,
        before["counts"], before["monitor"], rig, tuning,
    )  # fmt: skip
    # A memory that depends on the old friction does not fit samples of the new ground: they stay
    # rejected.
    run = 1 if memory_depends_on_tyre(model, measurement_model) else test["run"]
    unknown = change_variance(named(TUNING_FIELDS, tuning))
    samples = _accept(samples, ca.MX(ca.vertcat(test["accepted"], test["reset"], run)), unknown)
    at = state_index(measurement_model)
    factor[at, at] += arrival_jump(window, test["reset"], run, unknown)
    previous = x
    for i in range(iterations):
        previous = x
        M_z, slopes = torques(history, x) if i > 0 else (M_z, slopes)
        x, P = build_smoother(measurement_model, window)(
            mean, factor, x, M_z, slopes, samples, rig, tuning
        )
    x_newest = x[:, -1]

    def updated() -> tuple[dict[str, ca.MX], ca.MX]:
        added = append(x=x_newest)
        return added, torques(patch.newest(added), x_newest)[0]

    history, M_z = measurement_model.patch_after((history, test["expected"]), updated)
    old = reset_retention(test["reset"], before["P_newest"][at, at], unknown)
    memory = patch.newest(history)["memory"]
    friction = friction_output(model, x_newest, P, memory, now, theta, rig, tuning, at=at)
    unsettled = is_unsettled(measurement_model, x_newest, previous[:, -1], P)
    conditions = {"held": imputed, "unsettled": unsettled}
    output = step_output(measurement_model, x_newest, friction, M_z, tuning, test, **conditions)
    state_next = {
        **patch.scale_newest_sensitivity(history, old), "samples": samples, "x": x, "mean": mean,
        "factor": factor, "P_newest": P, "counts": test["counts_next"],
        "monitor": test["monitor_next"], "output": output,
    }  # fmt: skip
    return build_step_function("mhe_step", symbols, parts.join(state_next), output)


def _arrival(
    measurement_model: MeasurementModel,
    before: dict[str, ca.MX],
    samples: ca.MX,
    torques: partial[tuple[ca.MX, ca.MX]],
    rig: ca.MX,
    tuning: ca.MX,
) -> tuple[ca.MX, ca.MX]:
    """Mean and factor of the arrival after the oldest sample, linearised at its smoothed states."""
    oldest = before["x"][:, 0]
    mean, factor, *_ = build_forward(measurement_model)(
        before["mean"], before["factor"], oldest, *torques(before, oldest), samples[:, 0],
        samples[:, 1], rig, tuning,
    )  # fmt: skip
    return clip_to_bounds(measurement_model, mean, tuning), factor


def _accept(samples: ca.MX, test: ca.MX, variance: ca.MX) -> ca.MX:
    """The samples of the window after the newest one's test, see `build_acceptance`."""
    window, ages = samples.shape[1], ca.DM(range(samples.shape[1] - 1, -1, -1)).T
    rows = (samples[ROWS.index("accepted"), :], samples[ROWS.index("jump"), :])
    acceptance = build_acceptance().map(window) if window > 1 else build_acceptance()
    constant = [ca.repmat(vector, 1, window) for vector in (test, variance)]
    return ca.vertcat(samples[: len(CLEAN), :], *acceptance(*rows, ages, *constant))
