"""Friction by direction: of each one, and the torque's scale, which it does not check.

The search for friction with one value for both directions finds the scale also where they differ.
"""

from dataclasses import replace
from math import nan

import numpy as np
from numpy.typing import NDArray

from brushgrip.wording.friction import WAYS, last_usable, with_95_band
from observers import AligningTorque, DirectionalFriction, Ekf, Estimates, Mhe, Observer, Status

UNCHECKED = int(Status.ACQUIRING | Status.SUSPECT)
"""Flags with which no estimate is informed."""


DIRECTIONS = dict(zip(WAYS, (-1, 1), strict=True))
"""Sign of M_z while a direction loads the patch."""
OF_DIRECTIONS = tuple(f"{name}_{way}" for way in DIRECTIONS for name in ("mu_eff", "mu_eff_std"))
"""Columns of the friction of each direction."""


def friction_of_directions(
    estimates: Estimates, M_z: NDArray[np.float64]
) -> tuple[dict[str, float | str], str]:
    """The known ones of `OF_DIRECTIONS`, and a line, by the last usable sample of each direction.

    A sample counts for the direction that loads the patch, with more than half the torque of full slide.
    Beside them `direction`, that of mu_eff by the measured torque [N m], which exchanges them, and
    `weaker`, the share of mu_eff that the other one holds less, NaN while it is not known.
    """
    at = last_usable(estimates)
    if at is None:
        return {}, ""
    row: dict[str, float | str] = {}
    mu_of, told = dict.fromkeys(DIRECTIONS, nan), []
    begin = max(np.flatnonzero(estimates.status & Status.RESET), default=0)
    for way, sign in DIRECTIONS.items():
        loads = estimates.usable & (sign * estimates.M_z_predicted > estimates.M_slide / 2)
        own = np.flatnonzero(loads[begin : at + 1])
        if own.size:
            i = begin + int(own[-1])
            mu, std = float(estimates.mu_eff[i]), float(estimates.mu_eff_std[i])
            row |= {f"mu_eff_{way}": mu, f"mu_eff_std_{way}": std}
            mu_of[way] = mu
            told.append(f"{with_95_band(mu, std)} turning to {way} psi, at {estimates.t[i]:.4g} s")
        else:
            told.append(f"never usable turning to {way} psi")
    line = f"mu_eff by direction, last usable: {'; '.join(told)}" * bool(row)
    row["direction"] = max(DIRECTIONS, key=lambda way: DIRECTIONS[way] * M_z[at])
    # Not known where a direction is not.
    row["weaker"] = float(np.max([0.0, 1 - np.min([*mu_of.values()]) / estimates.mu_eff[at]]))
    return row, line


def single_friction(observer: Observer) -> Observer:
    """The observer with one friction for both directions, acquired; itself where it has one."""
    if isinstance(observer, Ekf | Mhe) and isinstance(observer.measurement_model, DirectionalFriction):
        return replace(observer, measurement_model=AligningTorque(), acquire=True)
    return observer


def with_checked_scale(estimates: Estimates, single: Estimates) -> Estimates:
    """Friction by direction, not informed before the one of `single` is, nor where that is suspect."""
    found = np.logical_or.accumulate(single.informed)
    status = estimates.status | np.where(found, 0, int(Status.ACQUIRING))
    status |= single.status & int(Status.SUSPECT)
    checked = status & UNCHECKED == 0
    informed, usable = estimates.informed & checked, estimates.usable & checked
    return replace(estimates, status=status, informed=informed, usable=usable)
