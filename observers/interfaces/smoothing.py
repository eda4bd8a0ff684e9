"""Friction over a whole recording from all of its samples, for those who work offline.

The smoother of Rauch, Tung and Striebel on what the filter stored: from the last sample of a ground
back, what later samples say goes to the earlier ones through the motion between them. A ground begins
where the filter says `Status.RESET`. At its last sample the smoother is the filter, before it no less
sure of ln mu. Measurements stay linearised, weighted and accepted.

Source: Rauch, Tung, Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA Journal 3
(1965) 1445.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.compiled_step import compiled_stretch, first_sample, run_stretches
from observers.estimates import Estimates
from observers.estimators.ekf import Ekf
from observers.interfaces.run import run, samples_and_first_index
from observers.measurement.measurement_model import RIG
from observers.measurement.motion_and_torque_jacobians import build_linearised_motion, state_index
from observers.protocol import UNINFORMED, Status
from observers.udu import covariance_of
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

MOVED = 0.5
"""Part of what later samples move ln mu by, beyond chance, by which it may still be off [1]."""
DIFFERS = 2.0
"""Deviations of the filter beyond which what is smoothed contradicts it, and is not usable [1]."""


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
    of the filter. While friction is acquired, and before the first sample that has angle and load, a
    sample gets mu of the first afterwards on the same ground, with a deviation that grows as mu walks.
    Usable is what is usable of the filter, less what later samples contradict: nothing before the
    filter knows friction, though what is smoothed knows it. The observer is the filter, all other
    arguments are as for `observers.run`.

    Raises:
        InvalidInputError: the observer is no `Ekf`; else as for `observers.run`.
    """
    if not isinstance(observer, Ekf):
        raise InvalidInputError(
            f"smooth needs an Ekf, on whose stored states it works, got {type(observer).__name__}"
        )
    causal = run(observer, t, psi, F_N, M_z, psi_dot, M=M)
    samples, begins = samples_and_first_index(observer, t, psi, F_N, M_z, psi_dot, M)
    used = samples[:, begins:]
    stretch, start = compiled_stretch(observer.screened_step), observer.init(first_sample(used)).values
    states = run_stretches(stretch, start, used, observer.constants, result=0)
    mu, relative = _smoothed_friction(observer, causal, states)
    differs = np.abs(np.log(mu / causal.mu)) > DIFFERS * causal.mu_std / causal.mu
    # Effective friction is linear in mu, and the torque of full slide proportional to it.
    slope = causal.mu_eff_std / causal.mu_std
    mu_eff = causal.mu_eff + slope * (mu - causal.mu)
    return replace(
        causal,
        mu=mu,
        mu_std=relative * mu,
        informed=(relative < observer.informed_below) & (causal.status & UNINFORMED == 0),
        usable=causal.usable & ~differs,
        mu_eff=mu_eff,
        mu_eff_std=slope * relative * mu,
        M_slide=causal.M_slide * mu_eff / causal.mu_eff,
    )


def _smoothed_friction(observer: Ekf, causal: Estimates, states: Array) -> tuple[Array, Array]:
    """Friction and its relative deviation, (n,), of the states after the last samples, (s, m)."""
    mu, variance, end = causal.mu.copy(), (causal.mu_std / causal.mu) ** 2, 0
    begins, tuning = mu.size - states.shape[1], observer.effective_tuning
    for first, stop in _tracked_intervals(causal.status[begins:]):
        moved, filtered, smoothed = _rts_smooth_log_mu(observer, states[:, first:stop])
        at, before = slice(begins + first, begins + stop), slice(end, begins + first)
        mu[at] *= np.exp(moved)
        # What the filter states beside its variance stays: tolerances, and the scale of the torque.
        variance[at] = smoothed + np.maximum(variance[at] - filtered, 0.0)
        # Friction that later samples move further than chance does changes otherwise than it walks.
        variance[at] += MOVED**2 * np.maximum(moved**2 - (filtered - smoothed), 0.0)
        walked = tuning.mu_walk**2 * (causal.t[at.start] - causal.t[before])
        mu[before], variance[before], end = mu[at.start], variance[at.start] + walked, at.stop
    return np.clip(mu, tuning.least, tuning.greatest), np.sqrt(variance)


def _tracked_intervals(status: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """First and one past the last sample of each stretch that the filter tracks on one ground."""
    tracks, continues = (status & int(flag) == 0 for flag in (Status.ACQUIRING, Status.RESET))
    anew = ~tracks | ~continues | np.insert(~tracks[:-1], 0, True)
    for first, stop in pairwise([*np.flatnonzero(anew).tolist(), status.size]):
        if stop > first + 1:
            yield first, stop


def _rts_smooth_log_mu(observer: Ekf, states: Array) -> tuple[Array, Array, Array]:
    """Change of ln mu, and its variance before and after, (n,), of the filter's states (s, n)."""
    at = state_index(observer.measurement_model)
    x, factors = _part(observer, states, "x").T.copy(), _part(observer, states, "factor").T
    count, n = x.shape
    factors = factors.reshape(count, n, n).transpose(0, 2, 1)
    P = np.array([covariance_of(factor) for factor in factors])
    predicted, A, Q = _linearised_motions(observer, states)
    mean, filtered = x[:, at].copy(), P[:, at, at].copy()
    for i in range(count - 2, -1, -1):
        P_next = A[i] @ P[i] @ A[i].T + np.diag(Q[i])
        # States that are known exactly have no variance: they take part in nothing.
        scale = np.sqrt(np.where(np.diag(P_next) > 0, np.diag(P_next), 1.0))
        gain = P[i] @ A[i].T / scale @ np.linalg.pinv(P_next / np.outer(scale, scale), hermitian=True)
        gain = gain / scale
        x[i] += gain @ (x[i + 1] - predicted[i])
        P[i] += gain @ (P[i + 1] - P_next) @ gain.T
    # Rounding alone could make it larger.
    return x[:, at] - mean, filtered, np.minimum(P[:, at, at], filtered)


def _linearised_motions(observer: Ekf, states: Array) -> tuple[Array, Array, Array]:
    """Predicted states (n - 1, m), derivatives (n - 1, m, m) and variances (n - 1, m), a step each."""
    x, M_z, slopes, last = (_part(observer, states, name) for name in ("x", "M_z", "slopes", "last"))
    n, between = x.shape[0], states.shape[1] - 1
    at = len(observer.model.coordinate_names)
    rig, tuning = observer.constants[at : at + len(RIG)], observer.effective_tuning.vector
    numbers = [ca.repmat(ca.DM(part), 1, between) for part in (rig, tuning)]
    before = [ca.DM(part[:, :-1]) for part in (x, M_z, slopes, last)]
    results = build_linearised_motion(observer.measurement_model).map(between)(
        *before, ca.DM(last[:, 1:]), *numbers
    )
    predicted, A, Q = (result.full() for result in results[:3])
    return predicted.T, A.T.reshape(between, n, n).transpose(0, 2, 1), Q.T


def _part(observer: Ekf, states: Array, name: str) -> Array:
    """A part of every state, (rows * columns, n)."""
    return states[observer.layout.places[name][0]]
