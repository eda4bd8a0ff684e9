"""The moving-horizon estimator over a recording
=============================================

The moving-horizon estimator over recordings, sample by sample as in a control loop.

.. code-block:: sh

    python examples/moving_horizon.py [REC...]

Without an argument it takes an embedded recording, on the model that `find_the_missing_effect.py` finds
on others of the same rig, and a measured one where those are at hand (see
published.py), on the declared model. A recording that is named has to know its rig, as the
published MAT files do.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from identification import Recording, read_recording, read_rig
from observers import Mhe, Sample, causal_rate
from published import measured_folder
from symbolic import Model, effects_named

RECORDINGS = Path(__file__).resolve().parent / "recordings"
FOUND = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
VALUES = {"k": 2.4e6, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
MEASURED = "fem4_ident.mat"


def cases() -> Iterator[tuple[Recording, Mhe]]:
    """The recordings, each with its estimator."""
    paths = [Path(name) for name in sys.argv[1:]]
    if not paths:
        embedded = read_recording(RECORDINGS / "holdout_c.csv", read_rig(RECORDINGS / "rig.toml"))
        yield embedded, Mhe(model=FOUND, values=VALUES, rig=embedded.rig)
        measured = measured_folder() / MEASURED
        paths = [measured] if measured.exists() else []
    for path in paths:
        recording = read_recording(path)
        yield recording, Mhe(model=Model(), values={"k": recording.tyre.k}, rig=recording.rig)


def samples(recording: Recording) -> list[Sample]:
    """What the sensors would hand over, one after the other; the rate is taken from the past alone."""
    t = recording.t
    rows = np.vstack([
        recording.psi, causal_rate(t, recording.psi), recording.F_N,
        np.diff(t, prepend=2 * t[0] - t[1]), recording.M_z,
    ])  # fmt: skip
    return [
        Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, M_z=M_z)
        for psi, psi_dot, F_N, dt, M_z in rows.T.tolist()
    ]


def main() -> None:
    """Print mu on the way and at the end, and what a sample takes."""
    for recording, observer in cases():
        sequence = samples(recording)
        state = observer.init(sequence[0])
        # The first step compiles the estimator, unless that has been done before.
        observer.step(state, sequence[0])
        print(f"{recording.name}, {len(sequence)} samples, window {observer.window}")
        spent = 0.0
        for number, sample in enumerate(sequence):
            begin = time.perf_counter()
            state = observer.step(state, sample)
            spent += time.perf_counter() - begin
            if number % 200 == 0:
                now = observer.estimate(state)
                word = "" if now.usable else "  (not usable)"
                print(f"{recording.t[number]:6.1f} s  mu = {now.mu:.3f} ± {now.mu_std:.3f}{word}")
        end = observer.estimate(state)
        each = 1e6 * spent / len(sequence)
        print(f"at the end: mu = {end.mu:.3f} ± {end.mu_std:.3f}, {each:.0f} µs per sample\n")


if __name__ == "__main__":
    main()
