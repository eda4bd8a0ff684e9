"""The rig's recordings as the tool reads them, with nothing but nominal parameters declared."""

from collections.abc import Sequence

import numpy as np

from identification import Decay, Recording, smoothed_rate
from reference_rig import Campaign, ImpactRecording, RigRecording, RigTyre, make_campaign
from symbolic import Rig, Tyre


def as_read(made: RigRecording, nominal: RigTyre) -> Recording:
    return Recording(
        name=made.name,
        t=made.t,
        psi=made.psi,
        psi_dot=smoothed_rate(made.t, made.psi),
        M_z=made.M_z,
        F_N=made.F_N,
        rig=Rig(a=nominal.a, e=nominal.e),
        tyre=Tyre(k=nominal.k, mu=nominal.mu),
    )


def as_decay(made: ImpactRecording) -> Decay:
    """The angle after an impact as the tool reads it; k is a first guess."""
    rig = Rig(a=made.tyre.a, e=made.tyre.e, J_A=made.wheel.J_A)
    return Decay(name=made.name, t=made.t, psi=made.psi, rig=rig, tyre=Tyre(k=2e6))


def read_campaign(
    name: str | None, seed: int, recordings: int = 2, duration: float = 10.0
) -> tuple[Campaign, list[Recording]]:
    made = make_campaign(name, seed, recordings, duration=duration)
    return made, [as_read(recording, made.nominal) for recording in made.recordings]


def with_torque(recording: Recording, M_z: Sequence[float] | np.ndarray) -> Recording:
    return Recording(**{**vars(recording), "M_z": np.asarray(M_z, dtype=float)})
