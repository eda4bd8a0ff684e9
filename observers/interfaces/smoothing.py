"""Friction over a whole recording from all of its samples, for those who work offline.

The smoother of Rauch, Tung and Striebel on what the filter stored: from the last sample back, what
later samples say goes to the earlier ones through the motion between them. At the last sample it is the
filter, before it no less sure of ln mu. Measurements stay linearised, weighted and accepted.

Source: Rauch, Tung, Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA Journal 3
(1965) 1445.
"""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from observers.compiled_step import compiled_stretch, first_sample, run_stretches
from observers.estimates import Estimates
from observers.estimators.ekf import Ekf
from observers.interfaces.run import as_estimates, run, samples_and_start
from observers.layout import Layout
from observers.measurement.linearisation import build_motion, state_index
from observers.measurement.measurement_model import CLEAN, RIG
from observers.patch.effective_friction import build_effective_friction
from observers.protocol import ESTIMATE, OUTPUT
from observers.quality.innovation_gate import COUNTS
from observers.quality.innovation_monitor import variance_between_grounds
from observers.udu import covariance_of
from symbolic import GEOMETRY, InvalidInputError
from symbolic.array_alias import Array

MARGIN = 1e-6
"""Share by which a prior stays within the bounds of mu [1]."""


def smooth(
    observer: Ekf,
    t: Array,
    psi: Array,
    F_N: Array,
    M_z: Array | None = None,
    psi_dot: Array | None = None,
    *,
    M: Array | None = None,
) -> Estimates:
    """Estimate mu at every sample from the whole recording.

    mu, mu_std, informed and the effective friction are smoothed; M_z_predicted, nis and status are those
    of the filter. Where friction is acquired, the smoother begins about what the filter ends with.
    Samples before the first that has angle and load get its mu, with a deviation that grows as mu walks.

    Args:
        observer: the filter.
        t: time [s]; this and the following as for `observers.run`.
        psi: yaw angle [rad].
        F_N: vertical load [N].
        M_z: aligning torque [N m].
        psi_dot: yaw rate [rad/s].
        M: steering torque [N m].

    Raises:
        InvalidInputError: the observer is no `Ekf`; else as for `observers.run`.
    """
    if not isinstance(observer, Ekf):
        raise InvalidInputError(
            f"smooth needs an Ekf, on whose stored states it works, got {type(observer).__name__}"
        )
    if observer.acquire:
        return _about_what_was_acquired(observer, t, psi, F_N, M_z, psi_dot, M)
    samples, begins = samples_and_start(observer, t, psi, F_N, M_z, psi_dot, M)
    used = samples[:, begins:]
    start = observer.init(first_sample(used)).values
    stretch = compiled_stretch(observer.screened_step)
    states = run_stretches(stretch, start, used, observer.constants, result=0)
    mean, variance = smoothed_log_mu(observer, states)
    time = np.asarray(t, dtype=float)
    rows = np.full((len(ESTIMATE), time.size), np.nan)
    filtered = dict(zip(OUTPUT, _part(observer.layout, states, "output"), strict=True))
    friction = _friction(observer, states, mean, variance)
    for name, row in (filtered | friction).items():
        rows[ESTIMATE.index(name), begins:] = row
    tuning = observer.effective_tuning
    walk, floor = tuning.mu_walk**2, tuning.mu_floor**2
    walked = variance[0] + floor + walk * (time[begins] - time[:begins])
    rows[ESTIMATE.index("mu"), :begins] = friction["mu"][0]
    rows[ESTIMATE.index("mu_std"), :begins] = friction["mu"][0] * np.sqrt(walked)
    relative = rows[ESTIMATE.index("mu_std")] / rows[ESTIMATE.index("mu")]
    informed = relative < observer.informed_below
    rows[ESTIMATE.index("informed")] = informed
    rows[ESTIMATE.index("usable")] = informed & (rows[ESTIMATE.index("status")] == 0)
    return as_estimates(time, rows)


def _about_what_was_acquired(observer: Ekf, *recording: Any) -> Estimates:
    """The smoother alone, with the friction that the causal filter ends with as the prior's mean.

    The flags are those of the causal filter.
    """
    t, psi, F_N, M_z, psi_dot, M = recording
    causal = run(observer, t, psi, F_N, M_z, psi_dot, M=M)
    tuning = observer.tuning
    inside = (tuning.least * (1 + MARGIN), tuning.greatest * (1 - MARGIN))
    mu = float(np.clip(causal.mu[-1], *inside))
    prior = replace(tuning, mu=mu, mu_std=tuning.log_std * mu)
    smoothed = smooth(replace(observer, acquire=False, tuning=prior), t, psi, F_N, M_z, psi_dot, M=M)
    informed = smoothed.informed & causal.informed[-1]
    return replace(
        smoothed, informed=informed, usable=informed & causal.usable[-1], status=causal.status
    )


def smoothed_log_mu(observer: Ekf, states: Array) -> tuple[Array, Array]:
    """Mean and variance of ln mu at every sample, (n,), of the filter's states after each, (s, n)."""
    layout, at = observer.layout, state_index(observer.measurement_model)
    x = _part(layout, states, "x").T.copy()
    count, n = x.shape
    factors = _part(layout, states, "factor").T.reshape(count, n, n).transpose(0, 2, 1)
    P = np.array([covariance_of(factor) for factor in factors])
    predicted, A, Q = _motions(observer, states)
    filtered = P[:, at, at].copy()
    for i in range(count - 2, -1, -1):
        P_next = A[i] @ P[i] @ A[i].T + np.diag(Q[i])
        # States that are known exactly have no variance: they take part in nothing.
        scale = np.sqrt(np.where(np.diag(P_next) > 0, np.diag(P_next), 1.0))
        gain = P[i] @ A[i].T / scale @ np.linalg.pinv(P_next / np.outer(scale, scale), hermitian=True)
        gain = gain / scale
        x[i] += gain @ (x[i + 1] - predicted[i])
        P[i] += gain @ (P[i + 1] - P_next) @ gain.T
    # Rounding alone could make it larger.
    return x[:, at], np.minimum(P[:, at, at], filtered)


def _motions(observer: Ekf, states: Array) -> tuple[Array, Array, Array]:
    """Predicted states (n - 1, m), derivatives (n - 1, m, m) and variances (n - 1, m), a step each."""
    layout, measurement_model = observer.layout, observer.measurement_model
    between = states.shape[1] - 1
    x, M_z, slopes, last, counts = (
        _part(layout, states, name) for name in ("x", "M_z", "slopes", "last", "counts")
    )
    numbers = [
        ca.repmat(ca.DM(part), 1, between)
        for part in (_rig(observer), observer.constants[-observer.tuning.vector.size :])
    ]
    before = [ca.DM(part[:, :-1]) for part in (x, M_z, slopes, last)]
    results = build_motion(measurement_model).map(between)(*before, ca.DM(last[:, 1:]), *numbers)
    predicted, A, Q = (result.full() for result in results[:3])
    n = x.shape[0]
    resets = np.diff(counts[COUNTS.index("resets")])
    Q[state_index(measurement_model)] += resets * variance_between_grounds(vars(observer.tuning))
    return predicted.T, A.T.reshape(between, n, n).transpose(0, 2, 1), Q.T


def _friction(observer: Ekf, states: Array, mean: Array, variance: Array) -> dict[str, Array]:
    """Friction and effective friction, each with its deviation, and the torque of full slide."""
    tuning, count = observer.effective_tuning, mean.size
    mu = np.clip(np.exp(mean), tuning.least, tuning.greatest)
    std = mu * np.sqrt(variance + tuning.mu_floor**2)
    memory, last = (_part(observer.layout, states, name) for name in ("memory", "last"))
    slide = build_effective_friction(observer.model)
    theta = observer.constants[: len(observer.model.coordinates)]
    given = [mu[None], std[None], memory, last[CLEAN.index("F_N")][None]]
    fixed = [theta, _rig(observer)[: len(GEOMETRY)], np.array([observer.rig.slide_rate])]
    tiled = [np.tile(part.reshape(-1, 1), count) for part in fixed]
    results = slide.map(count)(*(ca.DM(part) for part in (*given, *tiled)))
    effective = (np.asarray(result).ravel() for result in results)
    return {"mu": mu, "mu_std": std, **dict(zip(slide.name_out(), effective, strict=True))}


def _rig(observer: Ekf) -> Array:
    at = len(observer.model.coordinates)
    return observer.constants[at : at + len(RIG)]


def _part(layout: Layout, states: Array, name: str) -> Array:
    """A part of every state, (rows * columns, n)."""
    return states[layout.places[name][0]]
