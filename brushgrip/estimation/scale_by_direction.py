"""Friction by direction: of each one, and the torque's scale, which it does not check.

The search for friction with one value for both directions finds the scale also where they differ.
"""

from dataclasses import replace
from math import nan

import numpy as np

from brushgrip.wording.friction import last_usable, with_95_band
from observers import AligningTorque, DirectionalFriction, Ekf, Estimates, Mhe, Observer, Status

UNCHECKED = int(Status.ACQUIRING | Status.SUSPECT)
"""Flags with which no estimate is informed."""


DIRECTIONS = {"positive": -1, "negative": 1}
"""Directions of turning, by the sign of psi, and the sign of M_z while they load the patch."""
OF_DIRECTIONS = tuple(f"mu_eff_{way}{of}" for way in DIRECTIONS for of in ("", "_std"))
"""Columns of the friction of each direction."""


def last_by_direction(estimates: Estimates) -> dict[str, int]:
    """The last usable sample of each direction that has one, up to that of `last_usable`.

    A sample counts for the direction that loads the patch, with more than half the torque of full slide.
    """
    at, changes = last_usable(estimates), np.flatnonzero(estimates.status & Status.RESET)
    if at is None:
        return {}
    begin = int(changes[-1]) if changes.size else 0
    loaded = {w: s * estimates.M_z_predicted > estimates.M_slide / 2 for w, s in DIRECTIONS.items()}
    own = {
        way: begin + np.flatnonzero((estimates.usable & of)[begin : at + 1])
        for way, of in loaded.items()
    }
    return {way: int(samples[-1]) for way, samples in own.items() if samples.size}


def friction_of_directions(estimates: Estimates) -> dict[str, float]:
    """`OF_DIRECTIONS` by the last usable sample of each; NaN where there is none."""
    known = last_by_direction(estimates)
    row = dict.fromkeys(OF_DIRECTIONS, nan)
    row |= {f"mu_eff_{way}": float(estimates.mu_eff[i]) for way, i in known.items()}
    return row | {f"mu_eff_{way}_std": float(estimates.mu_eff_std[i]) for way, i in known.items()}


def directions_in_words(estimates: Estimates) -> str:
    """Friction of each direction with its band, in one line; empty where no friction is known."""
    known = last_by_direction(estimates)
    told = [
        f"{with_95_band(float(estimates.mu_eff[i]), float(estimates.mu_eff_std[i]))} turning to {way}"
        f" psi, at {estimates.t[i]:.4g} s"
        for way, i in known.items()
    ]
    other = [f"not known turning to {way} psi" for way in DIRECTIONS if way not in known]
    return f"mu_eff by direction, last usable: {'; '.join(told + other)}" * bool(known)


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
    return replace(
        estimates,
        status=status,
        informed=estimates.informed & checked,
        usable=estimates.usable & checked,
    )
