"""Friction by direction: of each one, and the torque's scale, which it does not check.

The search for friction with one value for both directions finds the scale also where they differ.
"""

from dataclasses import replace
from math import nan

import numpy as np

from brushgrip.wording.friction_in_words import NARROWED_BY, OF_ZERO, WAYS, with_95_band
from observers import AligningTorque, DirectionalFriction, Ekf, Estimates, Mhe, Observer, Status
from observers.quality.when_usable import last_ground_change_index, last_usable
from symbolic.float_array_type import Array

UNCHECKED = int(Status.ACQUIRING | Status.SUSPECT)
"""Flags with which no estimate is informed."""


DIRECTIONS = dict(zip(WAYS, (1, -1), strict=True))
"""Sign of each direction of turning, that of psi."""
OF_DIRECTIONS = tuple(f"{name}_{way}" for way in DIRECTIONS for name in ("mu_eff", "mu_eff_std"))
"""Columns of the friction of each direction."""


def directional_friction_and_line(
    estimates: Estimates, psi: Array, M_z: Array, measurement_model: DirectionalFriction
) -> tuple[dict[str, float | str], str]:
    """The known ones of `OF_DIRECTIONS`, and a line, by the last usable sample of each direction.

    A sample counts for the direction of its mu, if that has more than half the torque of full slide; the
    last usable one counts in any case.
    Beside them `direction`, that of mu_eff, empty where none has loaded the patch yet, and `weaker`, the
    share of mu_eff that the weaker one holds less, NaN while one is not known. Takes the measured angle
    [rad] and torque [N m], shape (n,), and how the observer takes them.
    """
    at = last_usable(estimates)
    if at is None:
        return {}, ""
    row: dict[str, float | str] = {}
    mu_of, told = dict.fromkeys(DIRECTIONS, nan), []
    begin = last_ground_change_index(estimates)
    # The zero of the angle may jump where it is implausible.
    left_out = estimates.status & Status.IMPLAUSIBLE != 0
    steps = np.where(left_out[1:] | left_out[:-1], 0.0, np.diff(psi))
    side = measurement_model.directions(estimates.t, np.cumsum([0.0, *steps]), M_z)
    for way, sign in DIRECTIONS.items():
        loads = (side == sign) & (-sign * estimates.M_z_predicted > estimates.M_slide / 2)
        usable = loads & estimates.usable
        usable[at] = side[at] == sign  # What is told first is told here, too.
        own = np.flatnonzero(usable[begin : at + 1])
        if own.size:
            i = begin + int(own[-1])
            mu, std = float(estimates.mu_eff[i]), float(estimates.mu_eff_std[i])
            row |= {f"mu_eff_{way}": mu, f"mu_eff_std_{way}": std}
            mu_of[way] = mu
            told.append(f"{with_95_band(mu, std)} turning to {way} psi, at {estimates.t[i]:.4g} s")
        else:
            changed = f"not usable since the ground changed at {estimates.t[begin]:.4g} s,"
            told.append(f"{changed if usable[:begin].any() else 'never usable'} turning to {way} psi")
    line = f"mu_eff by direction, last usable: {'; '.join(told)}" * bool(row)
    row["direction"] = next((way for way, sign in DIRECTIONS.items() if side[at] == sign), "")
    # Not known where a direction is not.
    row["weaker"] = float(np.max([0.0, 1 - np.min([*mu_of.values()]) / estimates.mu_eff[at]]))
    return row, line


def hidden_by_torque_zero_note(observer: Observer, estimates: Estimates) -> str:
    """That a zero of the torque, not declared, hides friction by direction; empty if it does not."""
    if observer_with_single_friction(observer) is observer or not isinstance(observer, Ekf | Mhe):
        return ""
    zero, limit = observer.tuning.zero_std, observer.tuning.zero_std / observer.informed_below
    low = estimates.is_too_uncertain & (estimates.mu_eff < limit)
    if observer.rig.tolerances.zero is not None or not low.any():
        return ""
    return (
        f"by direction, nothing below {limit:.2f} is usable where the torque's zero is not declared: it"
        f" counts as {100 * zero:g} % of full slide at mu = 1; {NARROWED_BY[OF_ZERO]}, or leave"
        " --by-direction out"
    )


def observer_with_single_friction(observer: Observer) -> Observer:
    """The observer with one friction for both directions, acquired; itself where it has one."""
    if isinstance(observer, Ekf | Mhe) and isinstance(observer.measurement_model, DirectionalFriction):
        return replace(observer, measurement_model=AligningTorque(), acquire=True)
    return observer


def gated_by_single_friction(by_direction: Estimates, single_estimates: Estimates) -> Estimates:
    """Friction by direction, not informed before the single one is, nor where that is suspect."""
    found = np.logical_or.accumulate(single_estimates.informed)
    status = by_direction.status | np.where(found, 0, int(Status.ACQUIRING))
    status |= single_estimates.status & int(Status.SUSPECT)
    checked = status & UNCHECKED == 0
    informed, usable = by_direction.informed & checked, by_direction.usable & checked
    return replace(by_direction, status=status, informed=informed, usable=usable)
