"""An observer as C, and back
==========================

An observer as C: generated, compiled, run along a recording, held against Python.

.. code-block:: sh

    python examples/embedded_round_trip.py [REC...]

Without an argument it takes an embedded recording, on the declared model and on the one that
`find_the_missing_effect.py` finds on others of the same rig, and a measured one where those are at hand
(see published.py). A recording that is named has to know its rig, as the
published MAT files do. Both sides get the same numbers, angle, torque and load of a sample and its time,
and take the yaw rate from the past of the angle; Python steps by `observers.Loop`, as a controller does.
"""

import sys
import time
from collections.abc import Iterator
from math import nan
from pathlib import Path

import numpy as np

from identification import Recording, read_recording, read_rig
from observers import AligningTorque, Ekf, Loop, Mhe, Sample
from observers.embedded import DOUBLE, SINGLE, Real, compile_native
from published import measured_folder
from symbolic import Model, compiler, effects_named

Observer = Ekf | Mhe
RECORDINGS = Path(__file__).resolve().parent / "recordings"
FOUND = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
VALUES = {"k": 2.4e6, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
MEASURED = "fem4_ident.mat"
ROUNDS = 20


def cases() -> Iterator[tuple[Recording, Observer]]:
    """The recordings, each with observers for it."""
    paths = [Path(name) for name in sys.argv[1:]]
    if not paths:
        embedded = read_recording(RECORDINGS / "holdout_c.csv", read_rig(RECORDINGS / "rig.toml"))
        for kind in (Ekf, Mhe):
            yield embedded, kind(model=Model(), values={"k": VALUES["k"]}, rig=embedded.rig)
        torque = AligningTorque(stiffness=True)
        yield embedded, Ekf(model=FOUND, values=VALUES, rig=embedded.rig, measurement_model=torque)
        measured = measured_folder() / MEASURED
        paths = [measured] if measured.exists() else []
    for path in paths:
        recording = read_recording(path)
        for kind in (Ekf, Mhe):
            yield recording, kind(model=Model(), values={"k": recording.tyre.k}, rig=recording.rig)


def in_python(observer: Observer, recording: Recording) -> tuple[np.ndarray, float]:
    """What mu is after every sample, and the time of a step [s]."""
    loop, t = Loop(observer), recording.t
    rows = zip(
        recording.psi, recording.M_z, recording.F_N, np.diff(t, prepend=2 * t[0] - t[1]), strict=True
    )
    samples = [Sample(psi=p, psi_dot=nan, M_z=M, F_N=F, dt=dt) for p, M, F, dt in rows]
    # The first step compiles the observer, unless that has been done before.
    Loop(observer)(samples[0])
    begin = time.perf_counter()
    mu = [loop(sample).mu for sample in samples]
    return np.array(mu), (time.perf_counter() - begin) / t.size


def in_c(observer: Observer, real: Real, recording: Recording) -> tuple[np.ndarray, float]:
    """The same of the generated code; the time is the least of several rounds."""
    native, took = compile_native(observer, real), []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        mu = native.run(recording.t, recording.psi, recording.F_N, recording.M_z).mu
        took.append(time.perf_counter() - begin)
    return mu, min(took) / recording.t.size


def main() -> None:
    """Print how far C is from Python, and what a step takes in both."""
    if compiler() is None:
        sys.exit("needs a C compiler: install one, or name it in CC")
    for recording, observer in cases():
        second = recording.t > recording.t[0] + 1
        expected, slow = in_python(observer, recording)
        effects = "with effects" if observer.model.effects else "declared model"
        print(f"{recording.name}, {expected.size} samples, {type(observer).__name__.upper()}, {effects}")
        print(f"  Python: mu = {expected[-1]:.6f} at the end, {1e6 * slow:.1f} µs a step")
        for real in (DOUBLE, SINGLE):
            mu, fast = in_c(observer, real, recording)
            off = np.abs(mu - expected)
            print(
                f"  C, {real.c_type}: mu = {mu[-1]:.6f}, off by {off.max():.0e} at most,"
                f" after 1 s by {off[second].max():.0e}; {1e6 * fast:.2f} µs a step,"
                f" {slow / fast:.0f} times as fast"
            )


if __name__ == "__main__":
    main()
