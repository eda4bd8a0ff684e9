"""Torques beyond the declared range of their sensor are left out: its end looks like full slide."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.reading.recordings import Recording
from symbolic.float_array_type import Array
from symbolic.patch_moment_by_zones import full_slide_arm


def drop_torques_beyond_range(recording: Recording) -> Recording:
    """The recording without the torques beyond the range of their sensor; its angle and load stay."""
    used = {}
    for name, torque in (("M_z", recording.M_z), ("M", recording.M)):
        if torque is not None and (beyond := _beyond(recording, torque)).any():
            used[name] = np.where(beyond, np.nan, torque)
    return replace(recording, **used) if used else recording  # type: ignore[arg-type]


def counts_beyond_range(recording: Recording) -> tuple[int, int]:
    """How many aligning, or else steering torques are beyond their sensor's range, and of how many."""
    torque = recording.aligning_or_steering_torque
    return int(_beyond(recording, torque).sum()), int(np.isfinite(torque).sum())


def share_beyond_range(recording: Recording) -> float:
    """Share of its torques that are beyond the range of their sensor [1]."""
    beyond, known = counts_beyond_range(recording)
    return beyond / max(known, 1)


def torque_beyond_range_note(recordings: Sequence[Recording]) -> str:
    """In how many samples that is so, in words; empty for none."""
    counts = {one.name: counts_beyond_range(one) for one in recordings}
    told = [f"{name} {count} of {size} samples" for name, (count, size) in counts.items() if count]
    return f"torque at its sensor's range, left out: {', '.join(told)}" if told else ""


def max_measurable_friction(recording: Recording) -> float:
    """Friction whose full slide is at the end of the used range, at the median load [1]."""
    load = float(np.median(recording.F_N[recording.F_N > 0]))
    return float(
        recording.rig.sensor_torque_limit / (load * full_slide_arm(recording.rig.a, recording.rig.e))
    )


def _beyond(recording: Recording, torque: Array) -> NDArray[np.bool_]:
    beyond: NDArray[np.bool_] = np.abs(torque) >= recording.rig.sensor_torque_limit
    return beyond
