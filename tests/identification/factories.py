"""Recordings of the reference rig as they are read, with nominal parameters alone declared."""

from collections.abc import Sequence

import numpy as np

from identification import Recording
from reference_rig import Campaign, make_campaign
from rig_recordings import as_decay, as_read

__all__ = ["as_decay", "as_read", "read_campaign", "with_torque"]


def read_campaign(
    name: str | None, seed: int, recordings: int = 2, duration: float = 10.0
) -> tuple[Campaign, list[Recording]]:
    made = make_campaign(name, seed, recordings, duration=duration)
    return made, [as_read(recording, made.nominal) for recording in made.recordings]


def with_torque(recording: Recording, M_z: Sequence[float] | np.ndarray) -> Recording:
    return Recording(**{**vars(recording), "M_z": np.asarray(M_z, dtype=float)})
