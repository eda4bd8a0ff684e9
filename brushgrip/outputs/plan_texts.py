"""A plan as a table, as rows of text and as a document."""

from typing import Any

import numpy as np

from brushgrip.wording.formatting import csv_text
from identification import SignalSource
from observers import Plan
from observers.planning.forecast import percent_text_beside_target
from symbolic import Vehicle
from symbolic.float_array_type import Array
from symbolic.vehicle.steering import mean_wheel_angle, pinion_angle_from_rack


def plan_csv(plan: Plan, vehicle: Vehicle | None, F_N: float) -> str:
    """The CSV of a path: angle, travel and load over time, and usable deviations for each friction."""
    path = plan.path
    columns = {"t": path.t, "psi": path.psi, "psi_dot": path.psi_dot, "travel": path.travel}
    if vehicle is None:
        columns["F_N"] = np.full(path.t.size, F_N)
    else:
        columns["handwheel"] = handwheel_angle(path.psi, vehicle)
    for mu, forecast in zip(plan.mus, plan.forecasts, strict=True):
        columns[f"deviation_{mu:g}"] = np.where(forecast.usable, forecast.deviation, np.nan)
    return csv_text(columns, digits=6)


def handwheel_angle(psi: Array, car: Vehicle) -> Array:
    """The angle of the handwheel [rad] at which the wheels of a car have an angle [rad]."""
    ways = np.linspace(-car.rack_travel, car.rack_travel, 2001)
    return pinion_angle_from_rack(car, np.interp(psi, mean_wheel_angle(car, ways), ways))


def turning_instruction(plan: Plan, vehicle: Vehicle | None, angle_source: SignalSource) -> str:
    """Where the wheel, and what is read or held in its place, turns back, and how fast it may turn."""
    turns = ", ".join(f"{turn:.3f}" for turn in plan.turning_points)
    turned = f"{turns} rad at {plan.path.rate:.3f} rad/s at most"
    channel, unit = f"channel {angle_source.channel}", angle_source.unit or "rad"
    if vehicle is not None:
        channel, unit = "the handwheel", "degrees"
        angles = np.degrees(handwheel_angle(plan.turning_points, vehicle))
    elif (scale := angle_source.factor_to_si("psi", "rad")) != 1:
        angles = plan.turning_points / scale
    else:
        return f"turn to {turned}"
    places = ", ".join(f"{at:.0f}" if unit[:3] == "deg" else f"{at:.3f}" for at in angles)
    return f"turn {channel} to {places} {unit}; that turns the wheel, as below, to {turned}"


def rows_by_ground(plan: Plan, vehicle: Vehicle | None) -> list[list[str]]:
    """Rows by ground, turns of the wheel [rad] or of a car's handwheel [deg]; a dash for never."""
    table, digits = [], dict(zip(_REACHED, (3, 3, 3) if vehicle is None else (0, 1, 0), strict=True))
    for row in plan_document(plan, vehicle)["grounds"]:
        reached = ("–" if row[n] is None else f"{row[n]:.{digits[n]}f}" for n in _REACHED)
        deviation, is_missed = row["deviation"], row["travel"] is None
        told = "–" if deviation is None else f"{deviation:.1%}"
        if is_missed and deviation is not None:
            told = percent_text_beside_target(deviation, plan.target)
        table.append([f"{row['mu']:g}", *reached, told])
    return table


_REACHED = ("travel", "time", "angle")


def plan_document(plan: Plan, vehicle: Vehicle | None = None) -> dict[str, Any]:
    """The plan as JSON values, turns of the wheel [rad] or of a handwheel [deg]; None for never."""
    path, grounds = plan.path, []
    turn = np.append(path.begin, path.psi)
    turn = turn if vehicle is None else np.degrees(handwheel_angle(turn, vehicle))
    travel, angle = np.cumsum(np.abs(np.diff(turn))), np.abs(turn[1:] - turn[0])
    for mu, at, forecast in zip(plan.mus, plan.reached, plan.forecasts, strict=True):
        reached = None if at is None else (travel[at], path.t[at], angle[: at + 1].max())
        ground = dict(zip(_REACHED, reached or (None,) * 3, strict=True))
        shown = forecast.least_deviation_index() if at is None else at
        deviation = None if shown is None else float(forecast.deviation[shown])
        grounds.append({"mu": mu, **ground, "deviation": deviation})
    return {
        "target": plan.target, "turns": plan.turning_points.tolist(), "rate": path.rate,
        "grounds": grounds, "unreached": list(plan.reasons),
    }  # fmt: skip
