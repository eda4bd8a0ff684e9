"""How long the patch and the filter take, as ratios within one run.

    python benchmarks/patch_and_filter.py

Each pair is run alternately and the ratio is the median over the rounds; absolute times are printed
beside it for orientation, they are those of the machine at hand.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from observers import Ekf, Sample, run
from symbolic import Model, Rig, effects_named, simulate, step_along

ROUNDS = 7
SAMPLES = 1000
A, E_, K, MU = 0.045, 0.009, 2.4e6, 1.3


def seconds(task: Callable[[], object]) -> float:
    """How long a task takes [s]."""
    begin = time.perf_counter()
    task()
    return time.perf_counter() - begin


def compare(label: str, slow: Callable[[], object], fast: Callable[[], object]) -> None:
    """Print the median ratio of two tasks over alternating rounds."""
    slow(), fast()
    pairs = [(seconds(slow), seconds(fast)) for _ in range(ROUNDS)]
    ratio = np.median([a / b for a, b in pairs])
    a, b = np.median(pairs, axis=0)
    print(f"{label:70}{ratio:8.1f} x   ({1e3 * a:.2f} ms, {1e3 * b:.2f} ms)")


def signals() -> np.ndarray:
    """A path with reversals and a varying load, rows psi, psi_dot, F_N, dt."""
    t = np.arange(SAMPLES) * 0.01
    psi = 0.3 * np.sin(t) + 0.15 * np.sin(2.7 * t)
    load = 400 + 20 * np.sin(0.7 * t)
    return np.vstack([psi, np.gradient(psi, 0.01), load, np.full(SAMPLES, 0.01)])


def numpy_grid(rows: np.ndarray, bristles: int) -> np.ndarray:
    """The patch as the source simulates it, bristle by bristle, in NumPy."""
    x = A * (2 * (np.arange(bristles) + 0.5) / bristles - 1)
    q, last, torque = np.zeros(bristles), rows[0, 0], []
    for psi, _, load, _ in rows.T:
        limit = 0.75 * MU * load / (A**3 * K) * (A**2 - x**2)
        q = np.clip(q - (x - E_) * (psi - last), -limit, limit)
        last = psi
        torque.append(K * 2 * A / bristles * (q @ (x - E_)))
    return np.array(torque)


def main() -> None:
    """Print the ratios."""
    rows, geometry, theta = signals(), np.array([A, E_]), np.array([MU, K])
    exact, bristles = Model(), Model(discretised=True)
    step = exact.step

    def interpreted() -> object:
        state = exact.start(rows[:, 0], theta, geometry)
        return step.mapaccum(SAMPLES)(state, rows, theta, geometry)

    def direct(model: Model = exact) -> object:
        return simulate(model, rows, theta, geometry)

    reference = numpy_grid(rows, 5000)
    span = np.ptp(reference)
    for bristle_count in (201, 5000):
        error = np.abs(
            numpy_grid(rows, bristle_count) - simulate(exact, rows, theta, geometry).M_z
        ).max()
        compare(
            f"NumPy grid of {bristle_count} bristles (differs by {error / span:.0e}) / exact zones",
            lambda count=bristle_count: numpy_grid(rows, count),
            direct,
        )
    compare("exact zones interpreted / compiled", interpreted, direct)
    compare("exact zones / 80 bristles", direct, lambda: direct(bristles))
    found = Model(effects=effects_named(["carcass_torsion", "rate_friction"]))
    both = np.array([MU, K, 1 / 400, 0.04])
    compare(
        "torque and 4 exact sensitivities / torque alone, carcass and rate friction",
        lambda: simulate(found, rows, both, geometry, np.eye(4)),
        lambda: simulate(found, rows, both, geometry),
    )
    ekf = Ekf(model=exact, values={"k": K}, rig=Rig(a=A, e=E_))
    t, torque = np.cumsum(rows[3]), simulate(exact, rows, theta, geometry).M_z

    def sample_by_sample() -> None:
        state = ekf.init(Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01))
        for (psi, rate, load, dt), M_z in zip(rows.T, torque, strict=True):
            state = ekf.step(state, Sample(psi=psi, psi_dot=rate, F_N=load, dt=dt, M_z=M_z))

    compare(
        "EKF sample by sample from Python / a recording in one Function",
        sample_by_sample,
        lambda: run(ekf, t, rows[0], rows[2], torque),
    )
    print(f"instructions in one step with its sensitivity: {step_along(exact, 1).n_instructions()}")


if __name__ == "__main__":
    main()
