"""How long the patch takes, as ratios within one run.

    python benchmarks/patch.py

The two of a pair run in turn and the ratio is the median over the rounds; the times beside it are those
of the machine at hand.
"""

import sys
from pathlib import Path
from unittest.mock import patch

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.timing import Task, compare
from symbolic import Model, effects_named, sensitivity_step, simulate, trajectory

SAMPLES = 1000
A, E_, K, MU = 0.045, 0.009, 2.4e6, 1.3


def signals() -> np.ndarray:
    """A path with reversals and a varying load, rows psi, psi_dot, F_N, dt."""
    t = np.arange(SAMPLES) * 0.01
    psi = 0.3 * np.sin(t) + 0.15 * np.sin(2.7 * t)
    load = 400 + 20 * np.sin(0.7 * t)
    return np.vstack([psi, np.gradient(psi, 0.01), load, np.full(SAMPLES, 0.01)])


def numpy_grid(rows: np.ndarray, bristles: int) -> np.ndarray:
    """The patch as [Györök 2022] simulates it, bristle by bristle, in NumPy."""
    x = A * (2 * (np.arange(bristles) + 0.5) / bristles - 1)
    q, last, torque = np.zeros(bristles), rows[0, 0], []
    for psi, _, load, _ in rows.T:
        limit = 0.75 * MU * load / (A**3 * K) * (A**2 - x**2)
        q = np.clip(q - (x - E_) * (psi - last), -limit, limit)
        last = psi
        torque.append(K * 2 * A / bristles * (q @ (x - E_)))
    return np.array(torque)


def report(label: str, slow: Task, fast: Task) -> None:
    """Print the ratio of two tasks."""
    pair = compare(slow, fast)
    times = f"({1e3 * pair.slow:.2f} ms, {1e3 * pair.fast:.2f} ms)"
    print(f"{label:75}{pair.ratio:8.1f} x   {times}")


def by_casadi(task: Task) -> Task:
    """The task with the recursion that CasADi writes in the place of our loops."""

    def run() -> object:
        with patch.object(trajectory, "bristle_kernel", lambda _: None):
            return task()

    return run


def main() -> None:
    """Print the ratios."""
    rows, geometry, theta = signals(), np.array([A, E_]), np.array([MU, K])
    exact, bristles = Model(), Model(discretised=True)
    step = exact.step

    def interpreted() -> object:
        state = exact.initial(rows[:, 0], theta, geometry)
        return step.mapaccum(SAMPLES)(state, rows, theta, geometry)

    def direct(model: Model = exact) -> object:
        return simulate(model, rows, theta, geometry)

    reference = numpy_grid(rows, 5000)
    span = np.ptp(reference)
    for count in (201, 5000):
        error = np.abs(numpy_grid(rows, count) - simulate(exact, rows, theta, geometry).M_z).max()
        label = f"NumPy grid of {count} bristles (differs by {error / span:.0e}) / exact zones"
        report(label, lambda count=count: numpy_grid(rows, count), direct)
    report("exact zones interpreted / compiled", interpreted, direct)
    report("exact zones / 80 bristles", direct, lambda: direct(bristles))
    with_effects = Model(effects=effects_named(["carcass_torsion", "rate_friction"]))
    both = np.array([MU, K, 1 / 400, 0.04])
    report(
        "torque and 4 exact sensitivities / torque alone, carcass and rate friction",
        lambda: simulate(with_effects, rows, both, geometry, np.eye(4)),
        lambda: simulate(with_effects, rows, both, geometry),
    )
    for names in (("rate_friction",), ("frictional_creep", "carcass_torsion")):
        model = Model(effects=effects_named(names))
        added = [p.to_coordinate(p.start) for effect, p in model.parameters if effect is not None]
        point = np.array([MU, K, *added])

        def run(model: Model = model, point: np.ndarray = point) -> object:
            return simulate(model, rows, point, geometry, np.eye(len(point)))

        label = f"with sensitivities, {', '.join(names)}: CasADi's vectors / our loops"
        report(label, by_casadi(run), run)
    print(
        f"instructions in one step with its sensitivity: {sensitivity_step(exact, 1).n_instructions()}"
    )


if __name__ == "__main__":
    main()
