"""An effect of your own
=====================
"""

import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from identification import Recording, diagnose, smoothed_rate
from reference_rig import make_recording
from symbolic import Effect, Expression, Parameter, ResidualSignature, Rig, Signals, Tyre, Values

STIFFNESS = 80.0  # of the boot in the recordings [N m/rad^3]


@dataclass(frozen=True, kw_only=True)
class BootSpring(Effect):
    """Adds -c psi^3 to the torque."""

    name: str = "boot_spring"
    summary: str = "the kingpin's boot, a torque proportional to the cube of the angle"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m/rad^3", neutral=0.0, start=1.0, lower=0.0, upper=1e3, scale=10.0),
    )
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("the angle", sign=1),)

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Torque of the boot [N m]."""
        return -values["c"] * signals.psi**3


EFFECTS = (BootSpring(),)


def recording(name: str, seed: int, mu: float) -> Recording:
    """A recording of the rig with the boot's torque added."""
    run = make_recording(seed, mu=mu, duration=9.0, bristles=400)
    torque, rate = run.M_z - STIFFNESS * run.psi_true**3, smoothed_rate(run.t, run.psi)
    channels = {"t": run.t, "psi": run.psi, "psi_dot": rate, "M_z": torque, "F_N": run.F_N}
    rig, tyre = Rig(a=run.tyre.a, e=run.tyre.e), Tyre(k=1.2 * run.tyre.k)
    return Recording(name=name, rig=rig, tyre=tyre, **channels)


def main() -> None:
    """Diagnose, and print what was found."""
    candidates = ["steering_return", "carcass_torsion", "contact_damping", *EFFECTS]
    recordings = [recording("first", 3, 0.9), recording("second", 4, 0.8)]
    diagnosis = diagnose(recordings, candidates=candidates, jobs=1)
    for effect in diagnosis.effects:
        for name, p in effect.parameters.items():
            print(f"found {effect.name}: {name} = {p.value:.2f} ± {p.std:.2f} {p.unit}")
    before, after = (stage.summary()["torque_nrmse"] for stage in (diagnosis.before, diagnosis.after))
    print(f"error {before:.2%} of range before, {after:.2%} after")


if __name__ == "__main__":
    main()
