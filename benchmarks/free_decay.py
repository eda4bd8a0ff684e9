"""How well free vibrations tell k and b_t: errors and coverage over many campaigns on the reference rig.

    python benchmarks/free_decay.py [--seeds 100] [--first 0] [--noise 0] [--swing 0.008] [--impacts 5]

Every campaign is seven contact lengths with five impacts each, 1 kHz, a 14-bit encoder, k = 2.438e6 and
b_t = 1.04 in SI units, steel under the tyre, the load that makes the contact length. Beside the
likelihood stand the same one on a patch that sticks, as in [Györök 2022], and the FFT and decrement used
there.
"""

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import identify_free_decay
from identification.thesis import estimate_by_decrement
from reference_rig import FOURTEEN_BIT_STEP, make_impacts
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from rig_recordings import as_decay

TRUE = np.array([TYRE.k, B_T])
NAMES = ("k", "b_t")
TARGETS = (0.003, 0.02)
"""Largest relative errors of k and b_t that are aimed at [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Relative errors of k and b_t of one campaign by way, and what the likelihood says of its own."""

    errors: dict[str, np.ndarray]
    spread: np.ndarray
    covered: np.ndarray
    agree: bool | None
    seconds: float

    def line(self, seed: int) -> str:
        """The run in a line, so that a long series can be watched."""
        errors, spread = 100 * self.errors["likelihood"], 100 * self.spread
        return (
            f"{seed:4d} k {errors[0]:+.4f} ± {spread[0]:.4f} %, b_t {errors[1]:+.4f} ±"
            f" {spread[1]:.4f} %, holds {self.covered[0]:d} {self.covered[1]:d}, agree {self.agree},"
            f" {self.seconds:.2f} s"
        )


def run(seed: int, noise: float, swing: float, impacts: int) -> Run:
    """One campaign."""
    recordings = make_impacts(seed, noise=noise * FOURTEEN_BIT_STEP, swing=swing, impacts=impacts)
    decays = [as_decay(recording) for recording in recordings]
    begin = time.perf_counter()
    result = identify_free_decay(decays)
    seconds = time.perf_counter() - begin
    sticking = identify_free_decay(decays, sliding=False)
    decrement = estimate_by_decrement(decays)
    estimates = {
        "likelihood": (result.k.value, result.b_t.value),
        "sticking patch": (sticking.k.value, sticking.b_t.value),
        "FFT and decrement": (decrement.k, decrement.b_t),
    }
    both = (result.k, result.b_t)
    return Run(
        errors={way: np.array(values) / TRUE - 1 for way, values in estimates.items()},
        spread=np.array([p.std for p in both]) / TRUE,
        covered=np.array([p.interval[0] <= t <= p.interval[1] for p, t in zip(both, TRUE, strict=True)]),
        agree=result.contacts_agree,
        seconds=seconds if result.converged else np.inf,
    )


def main() -> None:
    """Print errors by way, coverage and time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--noise", type=float, default=0.0, help="noise in steps of the encoder")
    parser.add_argument("--swing", type=float, default=0.008, help="of an impact [rad]")
    parser.add_argument("--impacts", type=int, default=5, help="at each contact length")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    runs = []
    for seed in seeds:
        runs.append(run(seed, options.noise, options.swing, options.impacts))
        print(runs[-1].line(seed), file=sys.stderr, flush=True)
    print(f"{len(runs)} campaigns; errors in per cent: mean, median size, largest size")
    for way in runs[0].errors:
        errors = 100 * np.array([r.errors[way] for r in runs])
        figures = [
            f"{name} {e.mean():+8.4f} {np.median(np.abs(e)):8.4f} {np.abs(e).max():8.4f}"
            for name, e in zip(NAMES, errors.T, strict=True)
        ]
        print(f"{way:16}{figures[0]}   {figures[1]}")
    errors = np.array([r.errors["likelihood"] for r in runs])
    spread = 100 * np.array([r.spread for r in runs]).mean(axis=0)
    print(f"standard deviation, mean: k {spread[0]:.4f} %, b_t {spread[1]:.4f} %")
    covered = np.array([r.covered for r in runs]).sum(axis=0)
    print(f"95 % intervals hold the truth: k {covered[0]}, b_t {covered[1]} of {len(runs)}")
    agreed = sum(r.agree is not False for r in runs)
    print(f"contacts agree on k, as they do: {agreed} of {len(runs)}")
    kept = (np.abs(errors) <= TARGETS).all(axis=1).sum()
    print(f"within {100 * TARGETS[0]:g} % and {100 * TARGETS[1]:g} %: {kept} of {len(runs)}")
    seconds = np.array([r.seconds for r in runs])
    print(f"time: median {np.median(seconds):.2f} s, longest {seconds.max():.2f} s")


if __name__ == "__main__":
    main()
