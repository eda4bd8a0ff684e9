"""One sample of the moving-horizon estimator as a casadi Function.

The window holds the last N samples, x_i = (mu_i, M_0,i) at each of them, the model's memory before the
oldest, and mean and covariance of x before it (the arrival). Gauss-Newton steps reduce, over the window,

    |x_1 - mean|^2 / (P + Q_1)  +  sum_i |x_i - x_{i-1}|^2 / Q_i  +  sum_i rho(r_i),
    r_i = (M_z,i - h_i(mu_i) - M_0,i) / noise_i,

with h_i the torque of the model [N m], Q_i the variances of the walk into sample i and no r_i where M_z
is missing; mu is projected on its bounds after each. rho(r) = r^2, or Huber's function, under which a
sample weighs min(1, huber / |r|).

For the declared model the memory does not depend on mu, and h_i on mu_i alone: the cost is exact. Where
effects make the memory depend on mu, its derivative is carried along and the memory is moved to first
order to the mu of the sample that it meets, so that h_i stands for a history at mu_i throughout.

An empty place, before the window is full, has dt = 0: nothing walks, nothing is measured, nothing turns.

Sources: Rao, Rawlings, Mayne, Constrained state estimation for nonlinear discrete-time systems, IEEE
Trans. Automatic Control 48 (2003) 246, with the arrival cost of a filter; Huber, Robust Statistics
(1981), for the weights.
"""

from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.smoother import build_smoother, build_update
from observers.tuning import REFERENCE_STEP, STATES
from symbolic import Model, full_slide_torque, step_along

STATE = ("memory", "carried", "held_at", "mean", "P", "samples", "x")
"""Order of the state: memory before the window, its derivative by mu, the mu that it stands for; mean
and covariance of the arrival; the samples of the window and x at each."""


@dataclass(frozen=True, kw_only=True)
class _Linear:
    """Terms of the linear problem, one column a sample; names as in `build_smoother`."""

    Q: ca.MX
    z: ca.MX
    H: ca.MX
    weight: ca.MX

    @property
    def all(self) -> tuple[ca.MX, ...]:
        return self.Q, self.z, self.H, self.weight


@cache
def build_window_step(model: Model, window: int, iterations: int) -> ca.Function:
    """One sample of the estimator, with named inputs and outputs.

    (*STATE, sample, theta, geometry, beliefs) -> (*STATE, P_newest, M_z_predicted); sample holds psi,
    psi_dot, F_N, dt, M_z, with M_z NaN where missing; beliefs are those of `Tuning` and Huber's
    threshold, inf for none.
    """
    size, states = model.memory_size, len(STATES)
    shapes = ((size,), (size,), (1,), (states,), (states, states), (5, window), (states, window))
    state = {name: ca.MX.sym(name, *shape) for name, shape in zip(STATE, shapes, strict=True)}
    sample, theta = ca.MX.sym("sample", 5), ca.MX.sym("theta", len(model.parameters))
    geometry, beliefs = ca.MX.sym("geometry", 2), ca.MX.sym("beliefs", 6)
    meet = _build_meeting(model)
    history = [state[name] for name in STATE[:3]]
    mean, P, samples, x = (state[name] for name in STATE[3:])

    *history, M_z, slope = meet(*history, samples[:, 0], x[0, 0], theta, geometry)
    terms = _linearised(samples[:, 0], M_z, slope, x[:, 0], geometry, beliefs)
    mean, P, *_ = build_update(states)(mean, P, *terms.all)
    mean = _projected(mean, beliefs)
    samples, x = ca.horzcat(samples[:, 1:], sample), ca.horzcat(x[:, 1:], x[:, -1])

    along, smooth = meet.mapaccum("mhe_window", window, 3, {}), build_smoother(states, window)
    predicted = []
    for _ in range(iterations):
        *_, M_z, slope = along(
            *history, samples, x[0, :], *(ca.repmat(v, 1, window) for v in (theta, geometry))
        )
        predicted.append(M_z[-1] + x[1, -1])
        terms = _linearised(samples, M_z, slope, x, geometry, beliefs)
        x, P_newest = smooth(mean, P, *terms.all)
        x = _projected(x, beliefs)
    inputs: list[ca.MX] = [*state.values(), sample, theta, geometry, beliefs]
    outputs: list[ca.MX] = [*history, mean, P, samples, x, P_newest, predicted[0]]
    return ca.Function(
        "mhe_step",
        inputs,
        outputs,
        [*STATE, "sample", "theta", "geometry", "beliefs"],
        [*(f"{name}_next" for name in STATE), "P_newest", "M_z_predicted"],
    )


def _build_meeting(model: Model) -> ca.Function:
    """The model meets a sample at mu: (*history, sample, mu, theta, geometry) -> (*history, M_z, slope).

    history is memory, its derivative by mu, and the mu that it stands for; slope is d M_z / d mu.
    """
    memory, carried = (ca.MX.sym(name, model.memory_size) for name in STATE[:2])
    held_at, mu, sample = ca.MX.sym("held_at"), ca.MX.sym("mu"), ca.MX.sym("sample", 5)
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    along = ca.DM.zeros(len(model.parameters))
    along[0] = 1
    moved = memory + carried * (mu - held_at)
    made = step_along(model, 1)(moved, carried, sample[:4], ca.vertcat(mu, theta[1:]), along, geometry)
    filled = sample[3] > 0
    after, carried_after = ca.if_else(filled, made[0], memory), ca.if_else(filled, made[1], carried)
    M_z, slope = ca.if_else(filled, made[2], 0), ca.if_else(filled, made[3], 0)
    return ca.Function(
        "meet",
        [memory, carried, held_at, sample, mu, theta, geometry],
        [after, carried_after, ca.if_else(filled, mu, held_at), M_z, slope],
        [*STATE[:3], "sample", "mu", "theta", "geometry"],
        [*(f"{name}_next" for name in STATE[:3]), "M_z", "slope"],
    )


def _linearised(
    samples: ca.MX, M_z: ca.MX, slope: ca.MX, x: ca.MX, geometry: ca.MX, beliefs: ca.MX
) -> _Linear:
    """The terms of a Gauss-Newton step about x, from torques M_z and slopes there."""
    mu_walk, zero_walk, noise, _, _, huber = ca.vertsplit(beliefs)
    _, _, F_N, dt, measured = ca.vertsplit(samples)
    slide = full_slide_torque(F_N, geometry[0])
    expected = M_z + x[1, :]
    # casadi takes x == x for true; no comparison with NaN is.
    present = ca.fabs(measured) < ca.inf
    residual = ca.if_else(present, measured - expected, 0)
    precision = dt / (REFERENCE_STEP * (noise * slide) ** 2)
    share = ca.fmin(1, huber / ca.sqrt(precision * residual**2))
    return _Linear(
        Q=ca.vertcat(dt * mu_walk**2, dt * (zero_walk * slide) ** 2),
        z=residual + slope * x[0, :] + x[1, :],
        H=ca.vertcat(slope, ca.MX.ones(1, slope.shape[1])),
        weight=ca.if_else(present, share, 0) * precision,
    )


def _projected(x: ca.MX, beliefs: ca.MX) -> ca.MX:
    least, greatest = beliefs[3], beliefs[4]
    return ca.vertcat(ca.fmax(least, ca.fmin(greatest, x[0, :])), x[1, :])
