"""When friction of a recording is usable, on the last ground and on the one before it."""

import numpy as np
from numpy.typing import NDArray

from observers.estimates import Estimates
from observers.protocol import Status
from symbolic.float_array_type import Array

HOLD = 0.5
"""Time for which a usable friction is kept between torques, as the loop of a controller does [s]."""
CONTRADICTED = 3.0
"""Turn in inconsistent samples after the last usable one, over that in usable ones, beyond which
friction is not told [1]: what was usable for a moment, and does not explain the torque afterwards, was
wrong. A wheel at rest shows neither."""
LONGEST_CHANGE = 3.2
"""Time after which a change of the ground is noticed at the latest [s]; what the model does not explain
for longer is its own misfit."""


def last_usable(estimates: Estimates) -> int | None:
    """The last usable sample on the last ground, unless what follows contradicts it; None for none."""
    inconsistent = (estimates.status & Status.INCONSISTENT != 0) & estimates.has_measured_torque
    return last_uncontradicted(
        estimates.usable, inconsistent, last_ground_change_index(estimates), estimates.turn
    )


def last_ground_change_index(estimates: Estimates) -> int:
    """The sample at which the last ground was noticed, 0 if it never changed."""
    changes = np.flatnonzero(estimates.status & Status.RESET)
    return int(changes[-1]) if changes.size else 0


def last_uncontradicted(
    usable: NDArray[np.bool_], inconsistent: NDArray[np.bool_] | None, begin: int, turn: Array | None
) -> int | None:
    """The last usable sample from `begin` on; None for none, or if too much turn contradicts it."""
    known = begin + np.flatnonzero(usable[begin:])
    if not known.size:
        return None
    last = int(known[-1])
    turn = np.ones(usable.size) if turn is None else turn
    after = 0.0 if inconsistent is None else float(turn[last + 1 :] @ inconsistent[last + 1 :])
    return last if after <= CONTRADICTED * turn[known].sum() else None


def usable_held(estimates: Estimates) -> NDArray[np.bool_]:
    """Where friction is usable, between torques that come more slowly than angles too, as for `Loop`."""
    last = np.maximum.accumulate(np.where(estimates.has_measured_torque, np.arange(estimates.t.size), 0))
    return estimates.usable[last] & (estimates.t - estimates.t[last] <= HOLD)


def steadily_usable_index(t: Array, usable: NDArray[np.bool_], begin: int) -> int:
    """The sample from `begin` on since which a friction is usable without a gap of more than `HOLD`.

    Up to the last usable sample, of which there has to be one; usable as of
    `usable_held`.
    """
    told = begin + np.flatnonzero(usable[begin:])
    gaps = np.flatnonzero((np.diff(told) > 1) & (np.diff(t[told]) > HOLD))
    return int(told[gaps[-1] + 1 if gaps.size else 0])


def steadily_usable_since(estimates: Estimates) -> tuple[float, bool]:
    """Time from which on the last usable friction was steadily so [s]; whether it was before, too.

    Both of the last ground, with a usable sample on it.
    """
    begin = last_ground_change_index(estimates)
    held = usable_held(estimates)
    since = steadily_usable_index(estimates.t, held, begin)
    return float(estimates.t[since]), bool(held[begin:since].any())


def on_previous_ground(estimates: Estimates) -> Estimates | None:
    """The samples up to the last usable one before the last change of the ground; None without one."""
    before = _first_samples(estimates, last_ground_change_index(estimates))
    at = last_usable(before) if before.t.size else None
    return None if at is None else _first_samples(estimates, at + 1)


def _first_samples(estimates: Estimates, end: int) -> Estimates:
    return Estimates(**{name: values[:end] for name, values in vars(estimates).items()})


def unexplained_samples(estimates: Estimates) -> NDArray[np.bool_]:
    """Where model and stated error do not explain the torque, but for a change of the ground.

    That is inconsistent from a usable sample on, up to a `RESET` within `LONGEST_CHANGE`.
    """
    t, found = estimates.t, np.asarray(estimates.status & Status.INCONSISTENT != 0)
    for end in np.flatnonzero(estimates.status & Status.RESET):
        known = np.flatnonzero(estimates.usable[:end])
        if known.size and t[end] - t[known[-1]] <= LONGEST_CHANGE:
            found[known[-1] + 1 : end + 1] = False
    return found
