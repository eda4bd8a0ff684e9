"""From raw channels to a recording.

The source's rig samples at 4 kHz. Its evaluation takes off the offsets of angle, force and torque,
smooths the angle by a moving average and keeps every fortieth sample (section 5.3), which folds mains
hum and all noise above 50 Hz into what is left. Here every channel goes through a low-pass before, the
same for all, so that angle and torque stay simultaneous.
"""

from collections.abc import Mapping

import numpy as np

from identification.reading.conditioning import Channel, Pipeline
from identification.reading.recordings import Recording
from identification.reading.smoothing import smoothed_rate
from symbolic import InvalidInputError, Rig, Tyre

CHANNELS = ("psi", "M_z", "F_N")
"""What a recording needs: yaw angle [rad], aligning torque [N m], vertical load [N]."""


def recording_from_raw(
    name: str,
    raw: Mapping[str, Channel],
    pipelines: Mapping[str, Pipeline],
    rig: Rig,
    tyre: Tyre,
) -> Recording:
    """A recording from raw channels that begin at the same instant.

    Args:
        name: of the recording.
        raw: channels by the names in `CHANNELS`.
        pipelines: what to do with each; all must end at the same rate.
        rig: geometry.
        tyre: the tyre as declared.

    Raises:
        InvalidInputError: a channel or its pipeline is missing, a step cannot be done (the message
            names the channel), or the channels end up with different rates or lengths.
    """
    missing = [channel for channel in CHANNELS if channel not in raw or channel not in pipelines]
    if missing:
        raise InvalidInputError(
            f"{name}: {', '.join(missing)} needs a raw channel and a pipeline; give both for"
            f" {', '.join(CHANNELS)}"
        )
    clean = {}
    for channel in CHANNELS:
        try:
            clean[channel] = pipelines[channel](raw[channel])
        except InvalidInputError as error:
            raise InvalidInputError(f"{name}: {channel}: {error}") from None
    kinds = {(channel.rate, channel.values.size) for channel in clean.values()}
    if len(kinds) > 1:
        ends = ", ".join(f"{n} {c.values.size} at {c.rate:g} Hz" for n, c in clean.items())
        raise InvalidInputError(f"{name}: all channels must end alike, got samples of {ends}")
    ((rate, size),) = kinds
    t, psi = np.arange(size) / rate, clean["psi"].values
    return Recording(
        name=name,
        t=t,
        psi=psi,
        psi_dot=smoothed_rate(t, psi),
        M_z=clean["M_z"].values,
        F_N=clean["F_N"].values,
        rig=rig,
        tyre=tyre,
    )
