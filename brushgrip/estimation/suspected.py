"""What looks wrong with a recording, in words: before it is estimated, or where no sample was usable."""

from collections.abc import Sequence
from itertools import islice

import numpy as np

from brushgrip.estimation.estimates import ObserverFactory, has_aligning_torque, samples_of
from brushgrip.estimation.map_correction import TIME, causes_with_map
from brushgrip.estimation.scale_by_direction import single_friction
from brushgrip.wording.friction import MIN_REPORTED_SHARE
from identification import FoundModel, Recording
from observers import Estimates, Loop, Status, suspicions_of
from observers.protocol import MAX_SAMPLE_PERIOD
from symbolic import InvalidInputError

MAX_REPLAYED_SAMPLES = 20_000
"""Samples that go through the observer once more, one by one."""


def require_plausible(recording: Recording) -> None:
    """Refuses a recording that looks like one in other units, or of the other sign."""
    for line in implausibility_lines([recording]):
        raise InvalidInputError(line)


def implausibility_lines(recordings: Sequence[Recording]) -> list[str]:
    """A line for each recording that looks like one in other units, or of the other sign."""
    return [f"{r.name}: {suspects}" for r in recordings if (suspects := _suspects(r))]


def _suspects(recording: Recording) -> str:
    channel = "M_z" if has_aligning_torque(recording) else "M"
    apart = float(np.median(np.diff(recording.t)))
    if apart > MAX_SAMPLE_PERIOD:
        return causes_with_map(recording, [f"{TIME} or less: samples are {apart:g} s apart"], channel)
    return causes_with_map(
        recording, suspicions_of(samples_of(recording), recording.rig, channel), channel
    )


def suspected_cause(
    factory: ObserverFactory, recording: Recording, found: FoundModel | None, estimates: Estimates
) -> str:
    """The cause of `Status.SUSPECT` with what mends it; empty where nothing is suspected."""
    flagged = np.flatnonzero(estimates.status[:MAX_REPLAYED_SAMPLES] & Status.SUSPECT)
    if flagged.size <= MIN_REPORTED_SHARE * estimates.t.size:
        return ""
    loop = Loop(single_friction(factory(recording, found)))
    for sample in islice(samples_of(recording), int(flagged[-1]) + 1):
        loop(sample)
    return causes_with_map(recording, loop.suspicions, "M_z" if has_aligning_torque(recording) else "M")
