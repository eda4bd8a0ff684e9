"""Seeded runs on the rig with faulty sensors, and by how much the faults make observers worse."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from reference_rig import (
    FOURTEEN_BIT_STEP,
    GroundRecording,
    SteeringRecording,
    add_outliers,
    constant_friction,
    drop_samples,
    jitter_instants,
    make_ground_recording,
    quantise,
    sample_instants,
)
from symbolic.float_array_type import Array
from tests.observers.monte_carlo import (
    Recording,
    drawn,
    errors,
    estimated,
    steered_by_hand,
    turned_by_hand,
)

RecordingFactory = Callable[[int], Recording]
SPREAD = 0.03
"""Jitter of the sampling instants [s]."""
CLEAN_WITH_FAULTS: dict[str, Any] = {"mu_walk": 0.005, "gate": 5.0}
"""Tuning: the sensor's own noise, mu free to walk a little, five times the noise not believed."""


@cache
def jittered(seed: int) -> GroundRecording:
    """The run of `turned_by_hand`, sampled by an uneven clock."""
    times = jitter_instants(seed, sample_instants(10.0, 100.0), spread=SPREAD)
    return make_ground_recording(seed, constant_friction(drawn(seed)), times=times)


def coarse(made: GroundRecording) -> GroundRecording:
    """The same seen by a 14-bit encoder."""
    return replace(made, psi=quantise(made.psi_true, FOURTEEN_BIT_STEP))


def with_outliers(seed: int, made: GroundRecording) -> GroundRecording:
    """One torque in a hundred is off by a whole range."""
    return replace(made, M_z=add_outliers(seed, made.M_z))


def with_lost(seed: int, made: Recording, channel: str) -> Recording:
    """A fifth of a channel is missing; not the same fifth in every channel."""
    own = 1000 * ("M_z", "psi", "F_N", "M").index(channel)
    return replace(made, **{channel: drop_samples(seed + own, getattr(made, channel))})


def everything(seed: int) -> GroundRecording:
    """Coarse, jittered, with outliers and with lost torques."""
    return with_lost(seed, with_outliers(seed, coarse(jittered(seed))), "M_z")


FAULTS: dict[str, RecordingFactory] = {
    "outliers": lambda seed: with_outliers(seed, turned_by_hand(seed)),
    "lost torque": lambda seed: with_lost(seed, turned_by_hand(seed), "M_z"),
    "lost angle": lambda seed: with_lost(seed, turned_by_hand(seed), "psi"),
    "lost load": lambda seed: with_lost(seed, turned_by_hand(seed), "F_N"),
    "14-bit encoder": lambda seed: coarse(turned_by_hand(seed)),
    "30 ms jitter": jittered,
    "all of these": lambda seed: with_lost(seed, with_lost(seed, everything(seed), "psi"), "F_N"),
}
"""Faults of the rig's recordings, the aligning torque measured."""


def held(signal: Array) -> Array:
    """A channel whose missing samples show the last one known."""
    known = np.isfinite(signal)
    return signal[np.maximum.accumulate(np.where(known, np.arange(signal.size), 0))]


def steered(seed: int) -> SteeringRecording:
    """6 s at 500 Hz, steering torque and 14-bit angle measured."""
    return steered_by_hand(seed, 6.0, 500.0)


def without_torque(seed: int) -> SteeringRecording:
    """A fifth of the steering torque is missing."""
    return with_lost(seed, steered(seed), "M")


def holding_torque(seed: int) -> SteeringRecording:
    """The same, but the last torque known stands for a missing one."""
    made = without_torque(seed)
    return replace(made, M=held(made.M))


STEERED_FAULTS: dict[str, RecordingFactory] = {
    "lost angle": lambda seed: with_lost(seed, steered(seed), "psi"),
    "outliers of angle": lambda seed: replace(steered(seed), psi=add_outliers(seed, steered(seed).psi)),
    "held torque": holding_torque,
}
"""Faults that observers of the steering torque bear."""


def rmse(kind: Any, made: RecordingFactory, seeds: Sequence[int], **settings: Any) -> float:
    """Root mean square error of mu after the first full slide, all runs that reach it [1]."""
    settings = {**CLEAN_WITH_FAULTS, **settings}
    runs = [errors(recording, estimated(kind, recording, **settings)) for recording in map(made, seeds)]
    return float(np.sqrt(np.nanmean([run.late_rmse**2 for run in runs])))
