"""How the time of one trial of the search grows with recordings, samples, effects and bristles.

    python benchmarks/diagnosis_scaling.py

Recordings of the reference rig, models compiled before. Prints each time as a multiple of the same
reference trial, all in one run: four recordings of 14 s thinned to 50 Hz, one effect, 80 bristles. A
search fits 16 such trials in its first step, fewer in each further one.
"""

import os
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

# Threads of the linear algebra would count as work while they wait.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import FitOptions, Recording, initial_guess
from identification.fits.fitting import fit
from identification.selection.trials import RANKING, Precision, model_of, thin
from reference_rig import make_campaign
from rig_recordings import as_read
from symbolic import effects_named

EFFECTS = (
    "contact_damping",
    "rate_friction",
    "carcass_torsion",
    "viscoelastic_relaxation",
    "patch_width",
)
REPEATS = 3
ONCE = FitOptions(tolerance=1e9)
"""Ends after one step."""


def seconds(effects: Sequence[str], recordings: Sequence[Recording], precision: Precision) -> float:
    """Least processor time of one simulation of everything with its derivatives [s]."""
    model = model_of(effects_named(effects), precision)
    start = initial_guess(model, recordings)
    fit(model, recordings[:1], start, ONCE)
    best = float("inf")
    for _ in range(REPEATS):
        began = time.process_time()
        fit(model, recordings, start, ONCE)
        best = min(best, time.process_time() - began)
    return best


def main() -> None:
    """Print the ratios."""
    rig = make_campaign("contact_damping", 1, recordings=8)
    whole = [as_read(recording, rig.nominal) for recording in rig.recordings]
    thinned = [thin(recording) for recording in whole]
    base = seconds(EFFECTS[:1], thinned[:4], RANKING)
    print(f"reference trial: {1000 * base:.0f} ms of processor time for one step of its fit\n")
    for count in (1, 2, 4, 8):
        print(f"recordings {count}: {seconds(EFFECTS[:1], thinned[:count], RANKING) / base:6.2f}")
    for label, recordings in (("50 Hz", thinned), ("100 Hz", whole)):
        print(f"samples at {label}: {seconds(EFFECTS[:1], recordings[:4], RANKING) / base:6.2f}")
    for bristles in (40, 80, 160):
        finer = replace(RANKING, bristles=bristles)
        print(f"bristles {bristles}: {seconds(EFFECTS[:1], thinned[:4], finer) / base:6.2f}")
    exact = replace(RANKING, discretised=False)
    print(f"exact patch in place of bristles: {seconds((), thinned[:4], exact) / base:.2f}")
    for count in range(len(EFFECTS) + 1):
        ratio = seconds(EFFECTS[:count], thinned[:4], RANKING) / base
        print(f"effects {count} ({', '.join(EFFECTS[:count]) or 'none'}): {ratio:6.2f}")


if __name__ == "__main__":
    main()
