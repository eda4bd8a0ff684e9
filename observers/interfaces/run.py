"""Run any observer over a recording."""

from collections.abc import Mapping

import numpy as np

from observers.compiled_step import first_sample
from observers.estimates import Estimates
from observers.measurement.causal_yaw_rate import causal_rate
from observers.measurement.measurement_model import MIN_FIRST_LOAD
from observers.protocol import ESTIMATE, BatchObserver, Observer, Sample, Status
from observers.quality.sample_screening import beyond_limits, plausible_angles, sample_limits_of
from symbolic import InvalidInputError
from symbolic.float_array_type import Array


def run(
    observer: Observer | BatchObserver,
    t: Array,
    psi: Array,
    F_N: Array,
    M_z: Array | None = None,
    psi_dot: Array | None = None,
    *,
    M: Array | None = None,
    one_by_one: bool = False,
) -> Estimates:
    """Estimate mu sample by sample; a row depends on nothing later than its sample.

    Args:
        observer: the observer.
        t: time, increasing, shape (n,) with n >= 2 [s]; samples may be irregular.
        psi: yaw angle, shape (n,), NaN where missing [rad].
        F_N: vertical load, shape (n,), NaN where missing, or one number for all [N].
        M_z: aligning torque, shape (n,), NaN where missing [N m]; None where it is not measured.
        psi_dot: yaw rate where it is measured, shape (n,) [rad/s]; None takes it from the past of psi.
        M: steering torque, shape (n,), NaN where missing [N m]; None where it is not measured.
        one_by_one: hand over every sample in a call of its own, as a controller does, also where the
            observer could take all at once; the same result, slower.

    Raises:
        InvalidInputError: shapes differ, time does not increase, or nothing is known of the torque that
            the observer uses, of the angle or of the load.
    """
    samples, begins = samples_and_first_index(observer, t, psi, F_N, M_z, psi_dot, M)
    # The patch is at rest where it is first seen; until then the prior stands.
    prior = observer.estimate(observer.init(first_sample(samples[:, begins:])))
    rows = np.full((len(ESTIMATE), samples.shape[1]), np.nan)
    for name in ("mu", "mu_std"):
        rows[ESTIMATE.index(name), :begins] = getattr(prior, name)
    beyond = beyond_limits(samples[:, :begins], sample_limits_of(observer))
    rows[ESTIMATE.index("status"), :begins] = Status.MISSING + Status.IMPLAUSIBLE * beyond
    rows[:, begins:] = _estimate_rows(observer, samples[:, begins:], one_by_one)
    return as_estimates(np.asarray(t, dtype=float), rows, psi)


def samples_and_first_index(
    observer: Observer, t: Array, psi: Array, F_N: Array, M_z: Array | None, psi_dot: Array | None,
    M: Array | None,
) -> tuple[Array, int]:  # fmt: skip
    """A recording as samples, and the index of the first that an observer can start with.

    Samples are columns, rows in the order of `SAMPLE`, shape (6, n). Arguments and errors are as of
    `run`.
    """
    t, psi, F_N = (_require_float_array(n, c) for n, c in (("t", t), ("psi", psi), ("F_N", F_N)))
    optional = (("M_z", M_z), ("psi_dot", psi_dot), ("M", M))
    M_z, psi_dot, M = (None if c is None else _require_float_array(n, c) for n, c in optional)
    F_N = np.full(t.shape, F_N) if F_N.ndim == 0 else F_N
    _require_shape_of_t(t, {"psi": psi, "F_N": F_N, "M_z": M_z, "psi_dot": psi_dot, "M": M})
    torque = M if observer.channel == "M" else M_z
    if torque is None or not np.isfinite(torque).any():
        needed = "M, the steering torque" if observer.channel == "M" else "M_z, the aligning torque"
        raise InvalidInputError(f"this observer needs {needed}, in at least one sample")
    psi_limit, _, F_N_limit, *_ = limits = sample_limits_of(observer)
    known = (np.abs(psi) < psi_limit) & (F_N >= MIN_FIRST_LOAD) & (F_N_limit > F_N)
    if not known.any():
        raise InvalidInputError(
            "psi must be finite and F_N at least 0.001 N in at least one sample, both within the limits"
            " of the tuning"
        )
    begins, nothing = int(np.argmax(known)), np.full(t.size, np.nan)
    steps, torques = np.diff(t, prepend=2 * t[0] - t[1]), (nothing if a is None else a for a in (M_z, M))
    samples = np.vstack([psi, nothing if psi_dot is None else psi_dot, F_N, steps, *torques])
    if psi_dot is None:
        usable = np.where(np.abs(psi) < psi_limit, psi, np.nan)
        usable[begins:] = plausible_angles(samples[:, begins:], limits)
        samples[1] = _causal_yaw_rate(t, usable)
    return samples, begins


def as_estimates(t: Array, rows: Array, psi: Array) -> Estimates:
    """Rows as in `ESTIMATE`, one column a sample, by name; before anything is known they hold NaN."""
    known, turn = np.flatnonzero(np.isfinite(psi)), np.zeros(t.size)
    turn[known[1:]] = np.abs(np.diff(np.asarray(psi, dtype=float)[known]))
    arrays = dict(zip(ESTIMATE, rows, strict=True))
    informed, usable, status = (arrays.pop(name) for name in ("informed", "usable", "status"))
    return Estimates(
        t=t,
        **arrays,
        informed=informed == 1,
        usable=usable == 1,
        status=np.where(np.isfinite(status), status, int(Status.MISSING)).astype(int),
        turn=turn,
    )


def _require_float_array(name: str, channel: Array) -> Array:
    try:
        if np.iscomplexobj(channel):
            raise TypeError
        return np.asarray(channel, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} must hold numbers, NaN where one is missing") from None


def _require_shape_of_t(t: Array, channels: Mapping[str, Array | None]) -> None:
    for name, array in channels.items():
        if array is not None and (array.shape != t.shape or t.ndim != 1 or t.size < 2):
            raise InvalidInputError(
                f"{name} must have the shape of t, (n,) with n >= 2; got {array.shape} and {t.shape}"
            )
    if not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
        raise InvalidInputError("t must increase from sample to sample, and be finite")


def _causal_yaw_rate(t: Array, psi: Array) -> Array:
    """The causal rate from the angles that are known, the last one where one is missing."""
    known = np.flatnonzero(np.isfinite(psi))
    rate = causal_rate(t[known], psi[known])
    return rate[np.maximum(np.searchsorted(known, np.arange(t.size), side="right") - 1, 0)]


def _estimate_rows(observer: Observer | BatchObserver, samples: Array, one_by_one: bool) -> Array:
    """Rows as in `ESTIMATE`, sample by sample or all at once."""
    whole = None if one_by_one else getattr(observer, "run_samples", None)
    if whole is not None:
        return np.asarray(whole(samples))
    state, rows = None, []
    for psi, psi_dot, F_N, dt, M_z, M in samples.T.tolist():
        sample = Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, M_z=M_z, M=M)
        state = observer.step(observer.init(sample) if state is None else state, sample)
        rows.append(observer.estimate(state).numbers)
    return np.array(rows).T
