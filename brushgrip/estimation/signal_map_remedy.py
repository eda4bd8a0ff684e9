"""The map of channels that mends a recording whose unit, gear or sign looks wrong."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brushgrip.wording.friction_in_words import LACKING
from identification import Recording
from identification.reading.signal_map import USUAL_RATIO, SignalSource, corrected_map_text
from identification.reading.units import factor_of
from identification.reading.units_by_magnitude import time_unit_by_period
from symbolic.patch_moment_by_zones import full_slide_arm

SURELY_DEGREES = 4 * math.pi
"""No steering wheel turns further [rad]; what is beyond is in degrees."""
USUAL_RATE = 100.0
"""Samples a second in a hint on a column that counts them [Hz]."""
MAX_ANGLE_DEGREES = 90.0
"""Largest steering angle of a wheel [deg]."""
UNITS = {"F_N looks like kN": ("F_N", "kN"), "the torque looks like N mm": ("", "mNm")}
"""Column and unit by the beginning of a suspected cause; the torque has no column of its own."""
SCALE = re.compile(r"the torque grows with the angle (\S+) times as k, a and F_N say")
MISSING_RATIO_SCALE, MIN_SCALE = 0.25, 0.03
"""Below the first a steering ratio may be missing, at the second the torque may be in kN m. The slope of
the stick phase tells no more: where the patch slides soon, a ratio of 15 shows as 0.14."""
OF_CAR = {
    "scale": "the vehicle file says: check units and ratios of the steering, stiffness, half_length and"
    " front_axle_load, or declare their tolerances",
    "psi looks": "the wheels would turn beyond a right angle: check steering_ratio, steering_arm and"
    " rack_travel, and the unit of rack or handwheel",
    "the torque looks": "the force on the rack is more than any ground holds: check the units of force"
    " and torques, motor_ratio, steering_arm and front_axle_load",
    "psi or the torque": "the force on the rack would turn the wheels: check the signs of its way, of"
    " the force and of the torques",
    "F_N looks": "friction is more than any ground has: check front_axle_load, half_length, force",
}
"""Fault of a car's recording, by the beginning of a suspected cause."""
OTHER_POUNDS = "F_N looks like lbf or kgf"
CLIPPED = "the torque is clipped or frozen"
IN_A_ROW = 5
"""Torques in a row at the greatest one, from which on it is clipped there."""
ANGLE, SIGN = "psi looks like degrees", "psi or the torque has the other sign"
TIME = "time looks like milliseconds"
FOR_K = (
    "; weigh the torque first: a k taken from this torque makes mu wrong by the same factor. A k"
    " measured by itself is declared with its tolerance, k = { value = ..., tolerance = ... } in [tyre]"
)
BESIDE = (
    "; where all of these are right, something takes torque beside the patch, as a spring does:"
    f" {LACKING}"
)


def causes_with_map(recording: Recording, causes: Sequence[str], torque: str) -> str:
    """The suspected causes in one line, with the whole map that mends them."""
    changed: dict[str, SignalSource] = {}
    ratio = ""
    if any(cause.startswith(ANGLE) for cause in causes):
        # An angle so large turns back at torques that say nothing of the sign.
        causes = [cause for cause in causes if not cause.startswith(SIGN)]
    for cause in causes:
        for beginning, (column, unit) in UNITS.items():
            if cause.startswith(beginning):
                source = _source(recording, column or torque)
                # A unit that the map gives, and that makes the torque too large, is the first to doubt.
                larger = not column and (factor_of(torque, source.unit or "") or 0) > 1
                changed[column or torque] = replace(source, unit="Nm" if larger else unit)
        if cause.startswith(SIGN):
            source = changed.get(torque, _source(recording, torque))
            changed[torque] = replace(source, factor=-source.factor)
        if cause.startswith(TIME):
            source = _source(recording, "t")
            in_its_unit = recording.t / (factor_of("t", source.unit or "") or 1.0)
            changed["t"] = replace(
                source, unit=time_unit_by_period(float(np.median(np.diff(in_its_unit))))
            )
        if recording.standstills is None and (scale := SCALE.match(cause)):
            ratio = _remedy_if_torque_is_scaled(recording, torque, float(scale[1])) + BESIDE
    why = "; ".join(causes if recording.standstills is None else map(_cause_in_vehicle_keys, causes))
    if recording.standstills is not None and not set(changed) <= {"t"}:
        return why
    counter = _map_if_t_counts_samples(recording) if "t" in changed else ""
    if any(cause.startswith(ANGLE) for cause in causes):
        changed["psi"], ratio = _angle_source_and_ratio_note(recording)
    elif changed:
        ratio = ""
    if recording.standstills is None and why.startswith(OTHER_POUNDS):
        load = _source(recording, "F_N")
        maps = (
            corrected_map_text(recording.sources, {"F_N": replace(load, unit=u)}) for u in ("kgf", "lbf")
        )
        return f"{why}: {' or '.join(maps)}"
    if recording.standstills is None and why.startswith(CLIPPED):
        why = _lower_bound_and_cause_text(recording, why)
    return (
        why
        + (f": {corrected_map_text(recording.sources, changed)}" if changed else "")
        + ratio
        + counter
    )


def _lower_bound_and_cause_text(recording: Recording, why: str) -> str:
    """The cause, behind the friction that there is at least where the torque is clipped, not frozen."""
    size = np.abs(recording.aligning_or_steering_torque)
    end, rig = float(np.nanmax(size)), recording.rig
    times = np.convolve(size == end, np.ones(IN_A_ROW), "valid")
    load = float(np.median(recording.F_N[recording.F_N > 0]))
    if times.max(initial=0) < IN_A_ROW or not load > 0:
        return why
    told = f"friction is above {end / (load * full_slide_arm(rig.a, rig.e)):.2f}: {why}"
    return told.replace(" or frozen: it stays", f" at {end:.2g} N m, where it stays")


def _remedy_if_torque_is_scaled(recording: Recording, torque: str, scale: float) -> str:
    """What may be wrong where the torque grows with the angle so many times as k, a and F_N say."""
    if scale >= MISSING_RATIO_SCALE:
        return FOR_K
    source, angle = _source(recording, torque), _source(recording, "psi")
    of_hand = f"if psi is the steering wheel's, without a ratio yet: --steering-ratio {USUAL_RATIO}; "
    shaft = corrected_map_text(recording.sources, {torque: source.geared_by_steering_ratio(torque)})
    told = (
        f"; {'' if source.ratio else of_hand}if the torque is of its shaft: {shaft}{source.ratio_hint}"
    )
    if scale >= MIN_SCALE:
        return told
    if angle.unit is None:
        degrees = {"psi": replace(angle, unit="deg")}
        told += f"; if psi is in degrees: {corrected_map_text(recording.sources, degrees)}"
    other = "N m" if source.unit else "kN m"
    entry = {torque: replace(source, unit=other.replace(" ", ""))}
    return f"{told}; if the torque is in {other}: {corrected_map_text(recording.sources, entry)}"


def name_channel_in_remedy(recording: Recording, text: str) -> str:
    """The text, with the channel of the file where it proposes to take M_z from the column M."""
    source = _source(recording, "M")
    turned = {"M_z": replace(source, factor=-source.factor)}
    others = {column: one for column, one in recording.sources.items() if column != "M"}
    return text.replace("--map M_z=-M", corrected_map_text(others, turned))


def _map_if_t_counts_samples(recording: Recording) -> str:
    """What to write where the time may be a count of samples; empty where it is none."""
    if (np.diff(recording.t) != 1).any():
        return ""
    source = _source(recording, "t")
    counted = replace(source, factor=source.factor / USUAL_RATE).map_option_text("t")
    return f"; if t counts samples, at {USUAL_RATE:g} Hz: {counted} in its place"


def _cause_in_vehicle_keys(cause: str) -> str:
    """The suspected cause, worded with the keys of the vehicle file."""
    if scale := SCALE.match(cause):
        return f"the force on the rack grows with its way {scale[1]} times as {OF_CAR['scale']}"
    return next((words for beginning, words in OF_CAR.items() if cause.startswith(beginning)), cause)


def _source(recording: Recording, column: str) -> SignalSource:
    return recording.sources.get(column, SignalSource(channel=column))


def _angle_source_and_ratio_note(recording: Recording) -> tuple[SignalSource, str]:
    """Where the angle comes from, and a note on the steering ratio."""
    source, largest = _source(recording, "psi"), float(np.abs(recording.psi).max())
    degrees = replace(source, unit="deg")
    if source.unit is not None:
        return source.geared_by_steering_ratio("psi"), source.ratio_hint
    if largest > MAX_ANGLE_DEGREES:
        return degrees.geared_by_steering_ratio("psi"), source.ratio_hint
    if largest > SURELY_DEGREES or source.ratio:
        return degrees, ""
    geared = source.geared_by_steering_ratio("psi").map_option_text("psi")
    return degrees, f", or {geared} if it is the steering wheel's{source.ratio_hint}"
