"""Innovations of a run, their variance, and their log-likelihood."""

from dataclasses import dataclass

import numpy as np

from observers.estimates import Estimates
from symbolic import InvalidInputError
from symbolic.float_array import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Innovations:
    """Arrays of shape (n,), NaN where nothing was measured.

    Attributes:
        innovation: measured less predicted torque [N m].
        variance: of the innovation [N^2 m^2].
        log_likelihood: logarithm of its normal density [ln 1/(N m)], [Bar-Shalom 2001], section 5.4.
            Where the model's error lasts, samples are not independent, and their sum says too much.
    """

    innovation: Array
    variance: Array
    log_likelihood: Array


def innovations(estimates: Estimates, M_z: Array) -> Innovations:
    """The innovations of an observer of the aligning torque.

    Args:
        estimates: of `observers.run`.
        M_z: the aligning torque that it was given, shape (n,) [N m].

    Raises:
        InvalidInputError: M_z has another shape than the estimates.
    """
    M_z = np.asarray(M_z, dtype=float)
    if M_z.shape != estimates.t.shape:
        raise InvalidInputError(
            f"M_z must have the shape of the estimates, {estimates.t.shape}, got {M_z.shape}"
        )
    nis = np.where(estimates.nis > 0, estimates.nis, np.nan)
    innovation = np.where(np.isfinite(nis), M_z - estimates.M_z_predicted, np.nan)
    variance = innovation**2 / nis
    return Innovations(
        innovation=innovation,
        variance=variance,
        log_likelihood=-(np.log(2 * np.pi * variance) + nis) / 2,
    )
