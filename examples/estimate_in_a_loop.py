"""An observer in a control loop
=============================

Estimate friction in a control loop: one sample in, one estimate out; the controller acts on those that
are usable.

.. code-block:: sh

    python examples/estimate_in_a_loop.py [ekf|mhe]

The recording stands for the sensors. The model is what `find_the_missing_effect.py` finds on other
recordings of the same rig, rounded. The filter, or the moving-horizon estimator: all else is the same.
"""

import math
import sys
from pathlib import Path

from identification import read_recording
from observers import Ekf, Loop, Mhe, Sample
from symbolic import Model, effects_named

RECORDINGS = Path(__file__).resolve().parent / "recordings"
KINDS = {"ekf": Ekf, "mhe": Mhe}
VALUES = {"k": 2.4e6, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}


def main() -> None:
    """Run the loop and print mu_eff once a second and at the end."""
    recording = read_recording(RECORDINGS / "holdout_c.csv", RECORDINGS / "rig.toml")
    observer = KINDS[sys.argv[1] if sys.argv[1:] else "ekf"](
        model=Model(effects=effects_named(["rate_friction", "carcass_torsion"])),
        values=VALUES,
        rig=recording.rig,
    )
    loop, dt = Loop(observer), float(recording.t[1] - recording.t[0])
    samples = zip(recording.psi, recording.F_N, recording.M_z, strict=True)
    for number, (psi, F_N, M_z) in enumerate(samples):
        # NaN: the loop takes the rate from the angle.
        now = loop(Sample(psi=psi, psi_dot=math.nan, F_N=F_N, dt=dt, M_z=M_z))
        if number % 100 == 0:
            word = "" if now.usable else f"  (not usable: {now.remedy})"
            print(f"{number * dt:5.1f} s  mu_eff = {now.mu_eff:.3f} ± {2 * now.mu_eff_std:.3f}{word}")
    print(f"friction at the end: mu_eff = {now.mu_eff:.3f} ± {2 * now.mu_eff_std:.3f}")


if __name__ == "__main__":
    main()
