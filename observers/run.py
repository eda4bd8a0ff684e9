"""Run any observer over a recording."""

import numpy as np
from numpy.typing import NDArray

from observers.protocol import Estimates, Observer
from observers.rate import causal_rate
from symbolic import InvalidInputError

Array = NDArray[np.float64]


def run(
    observer: Observer,
    t: Array,
    psi: Array,
    F_N: Array,
    M_z: Array,
    psi_dot: Array | None = None,
) -> Estimates:
    """Estimate mu sample by sample; a row depends on nothing later than its sample.

    Args:
        observer: the observer.
        t: time, increasing, shape (n,) with n >= 2 [s].
        psi: yaw angle, shape (n,) [rad].
        F_N: vertical load, shape (n,) [N].
        M_z: aligning torque, shape (n,), NaN where missing [N m].
        psi_dot: yaw rate where it is measured, shape (n,) [rad/s]; None takes it from the past of psi.

    Raises:
        InvalidInputError: shapes differ, time does not increase, or an angle or load is missing.
    """
    for name, array in (("psi", psi), ("F_N", F_N), ("M_z", M_z), ("psi_dot", psi_dot)):
        if array is None:
            continue
        if array.shape != t.shape or t.ndim != 1 or t.size < 2:
            raise InvalidInputError(
                f"{name} must have the shape of t, (n,) with n >= 2; got {array.shape} and {t.shape}"
            )
    if not (np.diff(t) > 0).all():
        raise InvalidInputError("t must increase from sample to sample")
    if psi_dot is not None and not np.isfinite(psi_dot).all():
        raise InvalidInputError("psi_dot must be finite throughout, or None to take it from psi")
    if not (np.isfinite(psi).all() and (F_N > 0).all() and np.isfinite(F_N).all()):
        raise InvalidInputError("psi must be finite and F_N finite and greater than 0 N throughout")
    dt = np.diff(t)
    steps = np.concatenate([dt[:1], dt])
    rate = causal_rate(t, psi) if psi_dot is None else psi_dot
    samples = np.vstack([psi, rate, F_N, steps, M_z])
    mu, mu_std, predicted, informed = observer.run_samples(samples)
    return Estimates(t=t, mu=mu, mu_std=mu_std, M_z_predicted=predicted, informed=informed.astype(bool))
