"""Recordings of the reference rig as they are read, with nominal parameters alone declared."""

from collections.abc import Sequence

import numpy as np

from identification import Decay, Recording, smoothed_rate
from reference_rig.campaign import Campaign, campaign
from reference_rig.impact import ImpactRecording
from reference_rig.patch import RigTyre
from reference_rig.record import RigRecording
from symbolic import Rig, Tyre


def as_read(recorded: RigRecording, nominal: RigTyre) -> Recording:
    return Recording(
        name=recorded.name,
        t=recorded.t,
        psi=recorded.psi,
        psi_dot=smoothed_rate(recorded.t, recorded.psi),
        M_z=recorded.M_z,
        F_N=recorded.F_N,
        rig=Rig(a=nominal.a, e=nominal.e),
        tyre=Tyre(k=nominal.k, mu=nominal.mu),
    )


def as_decay(impact: ImpactRecording) -> Decay:
    """The angle after an impact as it is read; k is a first guess."""
    rig = Rig(a=impact.tyre.a, e=impact.tyre.e, J_A=impact.wheel.J_A)
    return Decay(name=impact.name, t=impact.t, psi=impact.psi, rig=rig, tyre=Tyre(k=2e6))


def read_campaign(
    name: str | None, seed: int, recordings: int = 2, duration: float = 10.0
) -> tuple[Campaign, list[Recording]]:
    rig_campaign = campaign(name, seed, recordings, duration=duration)
    return rig_campaign, [as_read(one, rig_campaign.nominal) for one in rig_campaign.recordings]


def with_torque(recording: Recording, M_z: Sequence[float] | np.ndarray) -> Recording:
    return Recording(**{**vars(recording), "M_z": np.asarray(M_z, dtype=float)})
