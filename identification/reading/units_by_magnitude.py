"""Unit and sign of channels that may be columns, by the numbers in them: for a map that is proposed."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from identification.reading.signal_map import SignalSource
from identification.reading.units import UNITS
from symbolic.float_array_type import Array
from symbolic.signal_plausibility_limits import (
    MAX_PLAUSIBLE_PERIOD,
    MAX_RETURNED_WORK,
    MAX_STEERING_ANGLE,
    MIN_SIGN_TRAVEL,
    MIN_WHEEL_LOAD,
)

MAX_HANDWHEEL_ANGLE = 4 * np.pi
"""Largest angle of a steering wheel [rad]."""
MAX_LEVER_ARM = 0.8
"""Largest torque per load that a ground can hold [m]."""


def time_unit_by_period(period: float) -> str:
    """The largest unit of time in which samples so far apart can follow a wheel, as `ms`."""
    units = sorted(((factor, unit) for unit, factor in UNITS["t"].items()), reverse=True)
    plausible = (unit for factor, unit in units if factor * period < MAX_PLAUSIBLE_PERIOD)
    return next(plausible, units[-1][1])


@np.errstate(over="ignore", invalid="ignore")  # a column of anything may hold what overflows
def infer_units_and_sign(
    sources: Mapping[str, SignalSource], values: Mapping[str, Array], geared: set[str], certain: set[str]
) -> tuple[dict[str, SignalSource], set[str]]:
    """The sources with inferred units and torque sign, and the columns that need a steering ratio.

    Values are in SI where the unit is known; columns may lack. Of `geared` columns the channel is the
    steering wheel's by its name; of `certain` ones the unit stays.
    """
    found, geared = dict(sources), set(geared)
    known = {c: v for c, v in values.items() if np.isfinite(v).any()}

    def convert(column: str, unit: str, factor: float) -> None:
        if column not in certain:
            found[column] = replace(found[column], unit=unit)
            known[column] = factor * known[column]

    largest = {c: float(np.nanmax(np.abs(v))) for c, v in known.items()}
    periods = np.nan_to_num(np.diff(known.get("t", np.zeros(2))))
    if periods.size and np.median(periods) >= MAX_PLAUSIBLE_PERIOD:
        unit = time_unit_by_period(float(np.median(periods)))
        convert("t", unit, UNITS["t"][unit])
    if largest.get("psi", 0.0) > (MAX_HANDWHEEL_ANGLE if "psi" in geared else MAX_STEERING_ANGLE):
        convert("psi", "deg", np.pi / 180)
    if (
        "psi" in known
        and abs(found["psi"].factor) == 1
        and np.nanmax(np.abs(known["psi"])) > MAX_STEERING_ANGLE
    ):
        geared.add("psi")
    if 0 < largest.get("F_N", 0.0) < MIN_WHEEL_LOAD:
        convert("F_N", "kN", 1e3)
    torque = "M_z" if "M_z" in known else "M"
    if {torque, "F_N"} <= {*known} and largest[torque] > MAX_LEVER_ARM * np.nanmedian(known["F_N"]):
        convert(torque, "mNm", 1e-3)
    if {torque, "psi"} <= {*known} and known[torque].size == known["psi"].size:
        turn, middle = np.diff(known["psi"]), (known[torque][1:] + known[torque][:-1]) / 2
        work = middle * turn * (1 if torque == "M_z" else -1)
        if np.nansum(np.abs(turn)) >= MIN_SIGN_TRAVEL:
            against = np.nansum(work) / max(float(np.nansum(np.abs(work))), 1e-300)
            if abs(against) > MAX_RETURNED_WORK:
                found[torque] = replace(found[torque], factor=-1.0 if against > 0 else 1.0)
    return found, geared
