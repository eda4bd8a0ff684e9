"""A vehicle from tables, as the parser of TOML returns them; SI units throughout."""

import re
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from symbolic.errors import InvalidInputError
from symbolic.tables.rig_from_tables import SIGNALS, refuse_unknown_sections
from symbolic.tables.toml_and_json_parsing import (
    absolute_tolerance,
    excerpt,
    quoted_value,
    require_number,
)
from symbolic.vehicle.vehicle import Vehicle, VehicleTolerances

VEHICLE = "vehicle"
"""Section of a vehicle file."""
REQUIRED = ("front_axle_load", "tyre", "pressure", "wheelbase", "track")
"""Keys that a vehicle file must have."""
FULL_ASPECT, DEFLECTION, INCH = 82, 0.2, 0.0254
"""Height over width of a tyre whose size does not say [%]; share of the height by which it is squeezed
under its load [1]; an inch [m]."""
_TYRE = re.compile(
    r"\s*(?:P|LT)?(?P<width>\d{3})\s*(?:/\s*(?P<aspect>\d{2}))?\s*(?:Z?R|-|B)?\s*F?\s*(?P<rim>\d{2}).*",
    re.IGNORECASE,
)
TOLERANCE_ALONE = ("geometry", "force_scale")
"""Tolerances without a value, as shares."""
RATIO_TABLE = "rack_by_handwheel"
"""The steering's ratio as pairs."""
_KEYS = tuple(field.name for field in fields(Vehicle) if field.name not in ("tolerances", "tyre_width"))
TOLERATED_BY = {"front_axle_load": "load"} | {
    field.name: field.name for field in fields(VehicleTolerances) if field.name in _KEYS
}
"""Tolerance of each key that may be declared with one, `{ value = ..., tolerance = ... }`."""


def vehicle_from_tables(document: Mapping[str, object]) -> Vehicle:
    """A vehicle from ``[vehicle]``.

    ``tyre = "195/65 R15"`` gives the nominal width. `half_length`, `stiffness`, `front_axle_load`,
    `slide_factor`, `gear_friction` and `damping` may be tables ``{ value = 0.06, tolerance = 0.009 }``;
    ``geometry = { tolerance = 0.03 }`` is that of all lengths and ratios of the steering, as a share;
    ``force_scale`` likewise that of the measured force's scale. ``rack_by_handwheel = [[1.5, 0.012],
    [6.0, 0.055]]`` has angles of the handwheel and ways of the rack.

    Raises:
        InvalidInputError: a key is missing or unknown, or a value is out of its range.
    """
    refuse_unknown_sections(document, (VEHICLE, SIGNALS))
    section = document.get(VEHICLE)
    if not isinstance(section, dict):
        raise InvalidInputError(
            f"section [{VEHICLE}] missing; a vehicle file needs {', '.join(REQUIRED)}"
        )
    allowed = ("tyre", *_KEYS, *TOLERANCE_ALONE)
    if unknown := [name for name in section if name not in allowed]:
        raise InvalidInputError(
            f"[{VEHICLE}] unknown key {excerpt(unknown[0])}; allowed: {', '.join(allowed)}"
        )
    if {RATIO_TABLE, "steering_ratio"} <= set(section):
        raise InvalidInputError(
            f"[{VEHICLE}] {RATIO_TABLE} stands in place of steering_ratio: leave one"
        )
    if missing := [name for name in REQUIRED if name not in section]:
        raise InvalidInputError(f"[{VEHICLE}] {', '.join(missing)} missing")
    values: dict[str, Any] = dict(tyre_width_and_radius(section["tyre"]))
    tolerances: dict[str, float] = {}
    for name, entry in section.items():
        if name in TOLERANCE_ALONE:
            tolerances[name] = _tolerance(name, entry, ("tolerance",))
        elif isinstance(entry, dict) and name in TOLERATED_BY:
            tolerance = _tolerance(name, entry, ("value", "tolerance"))
            values[name] = _number(name, entry["value"])
            if not values[name] > 0:
                raise InvalidInputError(
                    f"[{VEHICLE}] {name} must be greater than 0, got {values[name]:g}"
                )
            tolerances[TOLERATED_BY[name]] = tolerance / values[name]
        elif name == "brakes":
            if not isinstance(entry, bool):
                raise InvalidInputError(
                    f"[{VEHICLE}] brakes must be true or false, got {quoted_value(entry)}"
                )
            values[name] = entry
        elif name == RATIO_TABLE:
            values[name] = _rack_by_handwheel_pairs(entry)
        elif name != "tyre":
            values[name] = _number(name, entry)
    try:
        return Vehicle(**values, tolerances=VehicleTolerances(**tolerances))
    except InvalidInputError as error:
        raise InvalidInputError(f"[{VEHICLE}] {error}") from None


def tyre_width_and_radius(size: object) -> dict[str, float]:
    """Nominal width and loaded radius of a tyre [m] by its size, as 195/65 R15; others are refused."""
    found = _TYRE.fullmatch(size) if isinstance(size, str) else None
    if found is None:
        raise InvalidInputError(
            f'[{VEHICLE}] tyre must be a size such as "195/65 R15", got {quoted_value(size)}'
        )
    width = int(found["width"]) / 1000
    height = width * int(found["aspect"] or FULL_ASPECT) / 100
    return {
        "tyre_width": width,
        "wheel_radius": int(found["rim"]) * INCH / 2 + (1 - DEFLECTION) * height,
    }


def _rack_by_handwheel_pairs(entry: object) -> tuple[tuple[float, ...], ...]:
    """Pairs of numbers, without that of the middle."""
    pairs = entry if isinstance(entry, list) else []
    if not pairs or not all(isinstance(p, list) and len(p) == 2 for p in pairs):
        raise InvalidInputError(
            f"[{VEHICLE}] {RATIO_TABLE}: write [[rad, m], ...], got {quoted_value(entry)}"
        )
    numbers = [tuple(_number(RATIO_TABLE, number) for number in pair) for pair in pairs]
    if not (beside := numbers[1:] if numbers[0] == (0.0, 0.0) else numbers):
        raise InvalidInputError(f"[{VEHICLE}] {RATIO_TABLE} has no pair beside the middle")
    return tuple(beside)


def _tolerance(name: str, entry: object, keys: tuple[str, ...]) -> float:
    if not isinstance(entry, dict) or set(entry) != set(keys):
        raise InvalidInputError(f"[{VEHICLE}] {name}: write {{ {' = ..., '.join(keys)} = ... }}")
    tolerance = absolute_tolerance(entry["tolerance"], entry.get("value", 1.0))
    return _number(f"{name}: its tolerance", tolerance)


def _number(name: str, value: object) -> float:
    require_number(f"[{VEHICLE}] {name}", value)
    try:
        return float(value)  # type: ignore[arg-type]
    except OverflowError:
        raise InvalidInputError(f"[{VEHICLE}] {name} is too large to compute with") from None
