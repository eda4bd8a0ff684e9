"""Rig files and vehicle files with what was identified."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from identification import Decay, FreeDecay, ParameterEstimate, SignalMap, read_rig, read_signals
from identification.reading.checked_file_reading import read_bytes
from identification.reading.rigfile import rig_text, signals_section
from identification.reading.signal_map import toml_value
from identification.steering.gear_friction_on_plates import PlatesResult
from identification.steering.tyres_on_known_friction import TyresResult
from symbolic import InvalidInputError, Rig, Tyre
from symbolic.rig_and_tyre import EVEN
from symbolic.tables.toml_and_json_parsing import MAX_TABLES_SIZE, parse_toml
from symbolic.tables.vehicle_from_tables import VEHICLE
from symbolic.vehicle.steering import inclination_for_return_torque
from symbolic.vehicle.vehicle import STD_PER_TOLERANCE, Vehicle

Changes = Mapping[str, float | tuple[float, float]]
"""Values by key, with their tolerances where they have one."""
GEAR_FRICTION_VARIATION = 0.2
"""Tolerance of a gear's friction, as a share of it [1]: it varies from day to day, and plates may turn
less freely than is assumed."""
DAMPING_VARIATION = 0.25
"""Variation of the damping with speed and temperature, as a share of its value [1]."""
LOAD_CHANGE = 0.03
"""Change of the front axle's load since tyres were identified, by fuel and luggage, as a share [1]."""


def plate_changes(vehicle: Vehicle, result: PlatesResult) -> Changes:
    """Gear friction and damping with tolerances, inclination by the return torque, a large zero."""
    friction, damping, zero = result.gear_friction, result.damping, result.zero
    changes: dict[str, float | tuple[float, float]] = {
        "gear_friction": _with_tolerance(friction, GEAR_FRICTION_VARIATION),
        "inclination": inclination_for_return_torque(vehicle, result.return_torque.value),
    }
    # A drag that is not told from none may be as large as its deviation.
    std = damping.std or 0.0
    changes["damping"] = (
        0.0
        if damping.value < -2 * std
        else _with_tolerance(replace(damping, value=max(damping.value, std)), DAMPING_VARIATION)
    )
    if abs(zero.value) > vehicle.force_zero:
        changes["force_zero"] = abs(zero.value)
    return changes


def _with_tolerance(measured: ParameterEstimate, least: float) -> tuple[float, float]:
    """A value and its tolerance, at least this share of it and at most nine tenths."""
    tolerance = max((measured.std or 0.0) / STD_PER_TOLERANCE, least * measured.value)
    return _rounded(measured.value), _rounded(min(tolerance, 0.9 * measured.value))


def tyre_changes(vehicle: Vehicle, result: TyresResult) -> Changes:
    """Slide factor and stiffness; the tolerance of the load is what it may change by from now on.

    The load is written beside them as that at which they hold, with the half-length under it.
    """
    load, share = vehicle.front_axle_load, vehicle.tolerances.half_length
    tyres = {
        name: (_rounded(one.value), _rounded((one.std or 0.0) / STD_PER_TOLERANCE))
        for name, one in result.parameters.items()
    }
    length = {"half_length": (_rounded(vehicle.a), _rounded(share * vehicle.a))}
    return {
        "front_axle_load": (load, _rounded(LOAD_CHANGE * load)),
        **(length if vehicle.half_length and vehicle.load_change_since_slide else {}),
        **tyres,
        "slide_load": load,
    }


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def identified_vehicle_text(
    file: Path, vehicle: Vehicle, result: PlatesResult | TyresResult, comments: Mapping[str, str]
) -> str:
    """The vehicle file with what was identified, its [signals] as they were.

    Comments of the file are lost; `comments` are written, each behind the value of its key.
    """
    if isinstance(result, PlatesResult):
        changes = plate_changes(vehicle, result)
    else:
        changes = tyre_changes(vehicle, result)
    section = parse_toml(read_bytes(file, MAX_TABLES_SIZE))[VEHICLE]
    assert isinstance(section, dict)  # It was read as a vehicle file before.
    for name, new in changes.items():
        section[name] = {"value": new[0], "tolerance": new[1]} if isinstance(new, tuple) else new
    behind = {name: f"  # {comment}" for name, comment in comments.items()}
    values = (f"{name} = {toml_value(one)}{behind.get(name, '')}" for name, one in section.items())
    lines = [f"[{VEHICLE}]", *values, ""]
    return "\n".join(filter(None, ("\n".join(lines), signals_section(read_signals(file)))))


def declared_rig(decays: Sequence[Decay], rig: Path | None) -> tuple[Rig, Tyre]:
    """Rig and tyre to write k and b_t into: the rig file's, else those that all recordings declare."""
    if rig is not None:
        return read_rig(rig)
    first = decays[0]
    if any((decay.rig, decay.tyre) != (first.rig, first.tyre) for decay in decays):
        raise InvalidInputError(
            "--write-rig: the recordings declare different rigs; name the one to complete with --rig"
        )
    return first.rig, first.tyre


def identified_rig_text(rig: Rig, tyre: Tyre, file: Path | None, result: FreeDecay) -> str:
    """The rig file with k, its tolerance and b_t as identified, and [signals] of the one given."""
    tolerances = replace(rig.tolerances, k=result.k.std / EVEN)
    identified = replace(rig, b_t=result.b_t.value, tolerances=tolerances)
    completed = rig_text(identified, replace(tyre, k=result.k.value))
    signals = signals_section(SignalMap() if file is None else read_signals(file))
    return "\n".join(filter(None, (completed, signals)))
