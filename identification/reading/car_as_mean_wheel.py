"""Recordings of a car: rack or handwheel, force or torques, as those of its mean wheel.

| column | is |
|---|---|
| `rack` | way of the rack [m], or `handwheel`, angle of the handwheel [rad]; positive to the left |
| `F_rack` | force of the gear on the rack [N], or `T_bar`, torque of the torsion bar, with `T_motor` |
| | of the assistance's motor, if there is one [N m]; positive where they drive to the left |
| `brake` | 1 where the brakes hold the wheels, optional |
| `speed` | of the car [m/s], optional |
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.reading.car_units_and_signs import (
    rack_position_and_force,
    require_plausible_car,
    shares_at_extreme_values,
)
from identification.reading.channels_by_name import absent_rack_columns, map_hint, missing_channels_error
from identification.reading.checked_file_reading import read_bytes
from identification.reading.checked_sample_table import MIN_SAMPLES, Table
from identification.reading.readers import READERS, read_table
from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.yaw_rate_from_angle import smoothed_rate
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.tables.toml_and_json_parsing import MAX_TABLES_SIZE, parse_toml, prefix_errors
from symbolic.tables.vehicle_from_tables import vehicle_from_tables
from symbolic.vehicle.mean_wheel import wheel_from_rack
from symbolic.vehicle.rack_time_derivatives import differentiated_rack_signals
from symbolic.vehicle.vehicle import Vehicle


@dataclass(frozen=True, kw_only=True, eq=False)
class Standstills:
    """When a car stood, and whether its brakes held the wheels.

    Attributes:
        vehicle: the car.
        stretch: number of the standstill that a sample belongs to, -1 while the car rolls, shape (n,).
        brakes: of each standstill, whether the brakes held.
        brakes_recorded: whether a column says so, not the vehicle.
        speed_recorded: whether the speed is in a column; without it the car is taken to stand.
        at_limit: share of the samples in which the rack moves that are at the largest or the least
            value of a force or torque [1], by its column.
    """

    vehicle: Vehicle
    stretch: NDArray[np.int64]
    brakes: tuple[bool, ...]
    brakes_recorded: bool = False
    speed_recorded: bool = False
    at_limit: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class RackRecording:
    """Motion and force of a car's rack at standstill, without missing samples; arrays (n,)."""

    name: str
    t: Array  # Time [s].
    s: Array  # Way of the rack [m].
    force: Array  # Of the gear on the rack, inertia included [N].
    brakes: bool  # Whether they held the wheels in the first standstill.
    at_limit: Mapping[str, float] = field(default_factory=dict)  # As of `Standstills`.


def read_rack_recording(
    path: str | Path, vehicle: Vehicle, signals: SignalMap = NO_MAP
) -> RackRecording:
    """Read way and force of a car's rack."""
    path = Path(path)
    table = read_table(path, ("t",), READERS, signals)
    require_rack_travel_and_force(table, vehicle)
    require_plausible_car(table, vehicle)
    s, force = rack_position_and_force(table.columns, vehicle)
    standstills = standstills_of(table.columns, vehicle)
    known = np.isfinite(s) & np.isfinite(force) & (standstills.stretch >= 0)
    if known.sum() < MIN_SAMPLES:
        raise InvalidInputError(
            f"{path}: way and force are known in {known.sum()} samples at standstill"
        )
    t, s, force = (column[known] for column in (table.columns["t"], s, force))
    columns = {name: column[known] for name, column in table.columns.items()}
    return RackRecording(
        name=path.stem, t=t, s=s, force=force, brakes=standstills.brakes[0],
        at_limit=shares_at_extreme_values(columns, smoothed_rate(t, s)),
    )  # fmt: skip


def read_vehicle(path: str | Path) -> Vehicle:
    """Read the section ``[vehicle]`` of a vehicle file, see `vehicle_from_tables`.

    Raises:
        InvalidInputError: the file cannot be read or is no vehicle file; one line says what is wrong.
    """
    path = Path(path)
    content = read_bytes(path, MAX_TABLES_SIZE)
    with prefix_errors(path):
        return vehicle_from_tables(parse_toml(content))


def mean_wheel_table(table: Table, vehicle: Vehicle) -> tuple[Table, Standstills]:
    """The table of the mean wheel, columns t, psi, M_z and F_N, and the standstills.

    M_z is NaN while the car rolls. A change of the brakes begins another standstill: the wheels turn
    about another point.
    """
    require_rack_travel_and_force(table, vehicle)
    require_plausible_car(table, vehicle)
    columns, standstills = table.columns, standstills_of(table.columns, vehicle)
    stands = standstills.stretch >= 0
    if not stands.any():
        raise InvalidInputError(
            f"{table.path}: the car never stands for {MIN_SAMPLES} samples: speed stays above"
            f" {vehicle.standstill:g} m/s, or is not known"
        )
    s, force = rack_position_and_force(columns, vehicle)
    braked = np.append(standstills.brakes, False)[standstills.stretch]
    moved = differentiated_rack_signals(
        columns["t"], s, np.broadcast_to(force, s.shape), standstills.stretch
    )
    psi, M_z = np.where(braked, *(wheel_from_rack(vehicle, *moved, brakes=b) for b in (True, False)))
    of_wheel = {
        "t": columns["t"],
        "psi": psi,
        "M_z": np.where(stands, M_z, np.nan),
        "F_N": np.full(s.size, vehicle.wheel_load),
    }
    at_limit = shares_at_extreme_values(columns, np.where(stands, moved.speed, 0.0))
    return replace(table, columns=of_wheel), replace(standstills, at_limit=at_limit)


def require_rack_travel_and_force(table: Table, vehicle: Vehicle) -> None:
    """Refuse a table without way or force of the rack, or with a motor on one side alone."""
    columns, signals = table.columns, SignalMap(signals=table.sources)
    if absent := absent_rack_columns(columns):
        raise missing_channels_error(table.path, absent, table.names, signals)
    if "F_rack" in columns:
        if vehicle.handwheel_inertia:
            raise InvalidInputError(
                f"{table.path}: F_rack is measured below the handwheel, whose inertia is not in"
                " it: leave handwheel_inertia out of [vehicle], or 0"
            )
        return
    if ("T_motor" in columns) == (vehicle.motor_ratio > 0):
        if "T_motor" not in columns and vehicle.handwheel_inertia is None:
            raise InvalidInputError(
                f"{table.path}: T_bar alone may be the torque at the rim, which turns the handwheel too:"
                " declare handwheel_inertia in [vehicle], 0 where the torsion bar is measured, else"
                " usually 0.035 kg m^2"
            )
        return
    remedy = "declare motor_ratio in [vehicle]"
    if vehicle.motor_ratio > 0:
        remedy = "without assistance, leave motor_ratio out of [vehicle]"
        remedy += map_hint(["T_motor"], table.names, signals)
    raise InvalidInputError(
        f"{table.path}: the torque of the motor, T_motor, and motor_ratio of the vehicle go together,"
        f" with one alone the force on the rack is not known; {remedy}"
    )


def standstills_of(columns: Mapping[str, Array], vehicle: Vehicle) -> Standstills:
    """The standstills of a recording, by its speed and its brakes; shorter ones than that are none."""
    count = columns["t"].size
    # A speed that is measured, and not known yet, may be any.
    speed = hold_last_value(columns.get("speed", np.zeros(count)), np.inf)
    stands = np.abs(speed) <= vehicle.standstill
    brake = hold_last_value(columns.get("brake", np.full(count, np.nan)), float(vehicle.brakes)) > 0.5
    state = np.where(stands, brake.astype(int), -1)
    begins = np.flatnonzero(np.diff(state, prepend=-2))
    stretch, brakes = np.full(count, -1), list[bool]()
    for begin, end in zip(begins, [*begins[1:], count], strict=True):
        if state[begin] >= 0 and end - begin >= MIN_SAMPLES:
            stretch[begin:end] = len(brakes)
            brakes.append(bool(state[begin]))
    return Standstills(
        vehicle=vehicle, stretch=stretch, brakes=tuple(brakes), brakes_recorded="brake" in columns,
        speed_recorded="speed" in columns,
    )  # fmt: skip


def hold_last_value(values: Array, default: float) -> Array:
    """A signal with its last value where one is missing, a default before the first."""
    place = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))
    return np.where(place >= 0, values[place], default)
