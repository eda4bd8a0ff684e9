"""How long a simulated steering motion takes at equal torque error, as ratios within one run.

    python benchmarks/simulation.py [RUNS]

The motion is that of the published files: a = 0.04 m, mu = 0.5, 5.11 s, sampled at 100 Hz. The rival is
the scheme of [Györök 2022] in NumPy (`thesis_simulation.py`), with the semi-implicit Euler rule and with
a second-order rule at the same cost a step. For each the cheapest setting is sought that keeps M_z
within 1e-4 of its range. The thesis has 201 bristles; how far these come whatever the step is printed as
well. RUNS of ours in a row are one timing, by default 10: a single one straight after a long one of
NumPy's meets cold caches, and the machine's other work.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from benchmarks.timing import compare
from symbolic import Rig, TorqueProfile, Tyre, WheelMotion, simulate_motion
from thesis_simulation import first_order, second_order

RIG, TYRE, LOAD = Rig(a=0.04, e=0.01, J_A=0.1, b_t=0.4827), Tyre(k=6e4, mu=0.5), 180.0
PROFILE = TorqueProfile(t=(0.0, 1.99, 3.99, 4.99), M=(0.4, 0.8, -0.9, 0.2))
DURATION, RATE = 5.11, 100.0
BOUND = 1e-4
"""Largest error of M_z over its range [1]."""
SUBSTEPS = (1, 2, 5, 10, 20, 40, 50, 60, 80, 100)
"""Steps of the rival between two samples."""
BRISTLES = (201, 251, 301, 401, 601, 801)
TOLERANCES = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
DEFAULT = 1e-7
"""The tolerance of `simulate_motion` where none is given [1]."""
ROUNDS = 15
Rule = Callable[..., tuple[np.ndarray, np.ndarray]]


def exact(tolerance: float) -> WheelMotion:
    """Ours."""
    return simulate_motion(RIG, TYRE, PROFILE, LOAD, duration=DURATION, rate=RATE, tolerance=tolerance)


def fixed(rule: Rule, bristles: int, substeps: int) -> np.ndarray:
    """The rival's M_z at the samples."""
    step = 1 / RATE / substeps
    t = np.arange(round(DURATION / step) + 1) * step
    return rule(RIG, TYRE, LOAD, PROFILE.torque_at(t), step, bristles)[1][::substeps]


def main() -> None:
    """Print errors and ratios."""
    runs = int(sys.argv[1]) if sys.argv[1:] else 10
    reference = exact(1e-12).M_z

    def error(M_z: np.ndarray) -> float:
        return float(np.max(np.abs(M_z - reference)) / np.ptp(reference))

    tolerance = next(each for each in TOLERANCES if error(exact(each).M_z) <= BOUND)
    for each in (tolerance, DEFAULT):
        ours = exact(each)
        print(f"exact, tolerance {each:g}: {ours.steps} steps, error {error(ours.M_z):.1e}")
    for name, rule in (("Euler", first_order), ("second order", second_order)):
        errors = {n: error(fixed(rule, 201, n)) for n in SUBSTEPS}
        # A smaller step than this gains the 201 bristles less than a tenth.
        best = next(n for n in SUBSTEPS if errors[n] <= 1.1 * min(errors.values()))
        fits = ((n, m) for n in SUBSTEPS for m in BRISTLES if error(fixed(rule, m, n)) <= BOUND)
        # Steps cost time, bristles hardly: 200 more are a tenth of a step.
        substeps, bristles = next(fits)
        for label, count, n in (("at best", 201, best), ("at equal error", bristles, substeps)):
            off = error(fixed(rule, count, n))
            pair = compare(
                lambda rule=rule, count=count, n=n: fixed(rule, count, n),
                lambda: [exact(tolerance) for _ in range(runs)],
                ROUNDS,
            )
            times = f"({1e3 * pair.slow:.2f} ms, {1e3 * pair.fast / runs:.3f} ms)"
            setting = f"{name}, {count} bristles {label}, steps of {10 / n:.3g} ms, error {off:.1e}"
            print(f"{setting:76} / exact: {pair.ratio * runs:.1f} x   {times}")


if __name__ == "__main__":
    main()
