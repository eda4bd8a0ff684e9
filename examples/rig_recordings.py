"""Recordings of the independent rig as the toolkit reads them, for the other examples.

    python examples/rig_recordings.py

prints what one of them holds. The reference rig shares no code with the toolkit, so the conversion
stands here.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from identification import Decay, Recording, smoothed_rate
from reference_rig import ImpactRecording, RigRecording, RigTyre, make_recording
from symbolic import Rig, Tolerances, Tyre


def as_read(recording: RigRecording, nominal: RigTyre, tolerance: float | None = None) -> Recording:
    """A recording with nominal values and the tolerance of a [m]; psi_dot is smoothed."""
    return Recording(
        name=recording.name,
        t=recording.t,
        psi=recording.psi,
        psi_dot=smoothed_rate(recording.t, recording.psi),
        M_z=recording.M_z,
        F_N=recording.F_N,
        rig=Rig(a=nominal.a, e=nominal.e, tolerances=Tolerances(a=tolerance)),
        tyre=Tyre(k=nominal.k, mu=nominal.mu),
        ground=recording.ground,
    )


def as_decay(recording: ImpactRecording) -> Decay:
    """The angle after an impact, lengths exact; the declared k is an initial guess of 2e6 N/m^2."""
    exact = Tolerances(a=0.0, e=0.0)
    rig = Rig(a=recording.tyre.a, e=recording.tyre.e, J_A=recording.wheel.J_A, tolerances=exact)
    return Decay(name=recording.name, t=recording.t, psi=recording.psi, rig=rig, tyre=Tyre(k=2e6))


def main() -> None:
    """Print the size and the range of one recording."""
    recording = as_read(make_recording(1), RigTyre())
    print(f"{recording.t.size} samples in {recording.t[-1]:g} s")
    print(f"M_z from {recording.M_z.min():.2f} to {recording.M_z.max():.2f} N m")


if __name__ == "__main__":
    main()
