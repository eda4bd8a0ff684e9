"""The torque's scale beside friction by direction, which does not check it.

The search for friction with one value for both directions finds the scale also where they differ.
"""

from dataclasses import replace

import numpy as np

from observers import AligningTorque, DirectionalFriction, Ekf, Estimates, Mhe, Observer, Status

UNCHECKED = int(Status.ACQUIRING | Status.SUSPECT)
"""Flags with which no estimate is informed."""


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
