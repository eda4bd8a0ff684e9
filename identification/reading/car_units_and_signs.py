"""Columns of a car in other units or of other signs, by their sizes and by the work that they do."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from identification.reading.checked_sample_table import Table
from identification.reading.signal_map import SignalSource, corrected_map_text
from identification.reading.units import OF_SIZE, UNITS, car_unit_by_size
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.signal_plausibility_limits import MAX_RETURNED_WORK
from symbolic.vehicle.steering import (
    jacking_torque,
    mean_wheel_angle,
    pinion_angle,
    pinion_angle_from_rack,
    rack_and_gain,
    rack_force,
    rack_lever,
)
from symbolic.vehicle.vehicle import Vehicle

MIN_RACK_SPAN = 0.03
"""Way of the rack from end to end from which on force and signs are judged [m]: tyres that stand twisted
unwind within half of it, and give work."""
MAX_RACK_FORCE = 6e4
"""Largest force of the gear on a rack [N]."""
OPPOSED = -0.87
"""Correlation of torsion bar and motor by which one has the other sign [1]: an assistance follows the
bar, above 0.9; a handwheel that a motor drags along stays above -0.8."""
MOVING = 2e-3
"""Speed of a rack from which on it moves [m/s]."""
MAX_AT_LIMIT = 0.02
"""Share of the samples of a moving rack that may show the largest or least force to the last digit [1]:
up to 0.005 in steps of 10 N, from 0.024 on where it is clipped at 0.9 of the largest."""


def require_plausible_car(table: Table, vehicle: Vehicle) -> None:
    """Refuse columns that look like ones in other units, or of the other sign."""
    changed, reasons, columns = dict[str, SignalSource](), [], dict(table.columns)
    for column, unit in _units_other_than_si(columns, vehicle).items():
        changed[column] = replace(table.source(column), unit=unit.replace(" ", ""))
        reasons.append(f"{column} looks like {unit}")
        columns[column] = columns[column] * UNITS[column][unit]
    for column, reason in _reversed_sign_reasons(columns, vehicle).items():
        source = changed.get(column, table.source(column))
        changed[column] = replace(source, factor=-source.factor)
        reasons.append(reason)
    if changed:
        remedy = corrected_map_text(table.sources, changed)
        raise InvalidInputError(f"{table.path}: {'; '.join(reasons)}: {remedy}")


def rack_position_and_force(columns: Mapping[str, Array], vehicle: Vehicle) -> tuple[Array, Array]:
    """Way of the rack [m] and force on it [N], measured or from the handwheel's side."""
    bar = columns.get("T_bar", np.zeros_like(columns["t"]))
    s, force = columns.get("rack"), columns.get("F_rack")
    pinion = None
    if s is None:
        pinion = pinion_angle(vehicle, columns["handwheel"], np.nan_to_num(bar))
        s = rack_and_gain(vehicle, pinion)[0]
    if force is None:
        pinion = pinion_angle_from_rack(vehicle, s) if pinion is None else pinion
        force = rack_force(vehicle, bar, columns.get("T_motor", 0.0), pinion)
    return s, force


def shares_at_extreme_values(columns: Mapping[str, Array], speed: Array) -> dict[str, float]:
    """Share of the samples in which the rack moves that show the largest or the least value, by column.

    The greater share of the two [1], of the column that makes most of the force on the rack; empty where
    it never moves. A force that a sensor or a motor limits stays there to the last digit. So does a
    torsion bar beside a motor, which needs few of the steps in which it is shown.
    """
    column = next(name for name in ("F_rack", "T_motor", "T_bar") if name in columns)
    known = columns[column][np.isfinite(columns[column]) & (np.abs(speed) > MOVING)]
    if not known.size:
        return {}
    return {column: max(float(np.mean(known == end)) for end in (known.min(), known.max()))}


def require_unclipped(name: str, at_limit: Mapping[str, float], looks_like: str) -> None:
    """Refuse a recording that is clipped (`shares_at_extreme_values`) and looks like another."""
    for column, share in at_limit.items():
        if share > MAX_AT_LIMIT:
            raise InvalidInputError(
                f"{name}: {column} stays at its largest or least value in {100 * share:.1f} % of the"
                f" samples in which the rack moves; allowed: up to {100 * MAX_AT_LIMIT:.0f} %; a limit"
                f" of sensor or motor clips it, and looks like {looks_like}"
            )


def _units_other_than_si(columns: Mapping[str, Array], vehicle: Vehicle) -> dict[str, str]:
    """Units by column where they are not SI."""
    sizes = dict(columns)
    if "T_motor" in columns and vehicle.motor_ratio > 0:
        # What a motor gives depends on its gear.
        share = rack_force(vehicle, 0.0, columns["T_motor"], 0.0) / MAX_RACK_FORCE
        sizes["T_motor"] = share * OF_SIZE["T_motor"][0]
    units = {column: car_unit_by_size(column, values) for column, values in sizes.items()}
    way = "rack" if "rack" in columns else "handwheel"
    gain = UNITS[way].get(units[way], 1.0) * (1.0 if way == "rack" else vehicle.rack_gain)
    if "F_rack" in columns and not gain * _span(columns[way]) > MIN_RACK_SPAN:
        units["F_rack"] = ""
    return {column: unit for column, unit in units.items() if unit}


def _span(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size else 0.0


def _reversed_sign_reasons(columns: Mapping[str, Array], vehicle: Vehicle) -> dict[str, str]:
    """Columns that count the other way, and why."""
    s, force = rack_position_and_force(columns, vehicle)
    ds = np.diff(s, prepend=s[:1])
    if not _span(s) > MIN_RACK_SPAN:
        return {}
    bar, motor = columns.get("T_bar"), columns.get("T_motor")
    if "F_rack" not in columns and bar is not None and motor is not None:
        known = np.isfinite(bar) & np.isfinite(motor)
        bound = OPPOSED * np.linalg.norm(bar[known]) * np.linalg.norm(motor[known])
        if bar[known] @ motor[known] < bound < 0:
            wrong = "T_bar" if np.nansum(motor * ds) > 0 else "T_motor"
            return {wrong: "T_bar and T_motor act against each other"}
    # Without what lifts the body, tyres and gear only take work.
    work = (
        force - 2 * jacking_torque(vehicle, mean_wheel_angle(vehicle, s)) / rack_lever(vehicle, s)
    ) * ds
    if np.nansum(work) < -MAX_RETURNED_WORK * np.nansum(np.abs(work)):
        way = "rack" if "rack" in columns else "handwheel"
        against = "F_rack" if "F_rack" in columns else "the torques"
        return {way: f"{way} and {against} have opposite signs, the ground would turn the wheels"}
    return {}
