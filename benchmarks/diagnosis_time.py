"""Where the processor time of a diagnosis goes.

    python benchmarks/diagnosis_time.py [REC... [--holdout REC...]] [--cold]

One process, linear algebra in one thread; without recordings, three of the reference rig. Prints
processor time, that of the compiler included, of the whole and of its parts: each part without what is
listed above it. `--cold` begins with an empty cache of compiled Functions.
"""

import argparse
import cProfile
import os
import pstats
import sys
import tempfile
from pathlib import Path

# Threads of the linear algebra would count as work while they wait.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import Recording, diagnose, read_recording
from reference_rig import make_campaign
from rig_recordings import as_read

PARTS = (
    ("compiled.py", "_run", "the C compiler"),
    ("bristle_kernel.py", "kernel_source", "building Functions, C from them"),
    ("trajectory.py", "simulate", "simulating recordings with derivatives"),
    ("trials.py", "run_trial", "the fits around them"),
    ("discriminating_experiment.py", "propose", "proposing experiments"),
    ("build.py", "build_diagnosis", "residuals, deviations, signatures"),
)
"""File, function and what it does; a function calls only those above it."""


def processor_time() -> float:
    """Of this process and of those that it has waited for [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def main() -> None:
    """Diagnose, then print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", nargs="*", type=Path)
    parser.add_argument("--holdout", nargs="*", type=Path, default=[])
    parser.add_argument("--cold", action="store_true")
    options = parser.parse_args()
    training, holdout = (
        [read_recording(path) for path in paths] for paths in (options.recordings, options.holdout)
    )
    with tempfile.TemporaryDirectory() as scratch:
        if options.cold:
            os.environ["BRUSHGRIP_CACHE"] = scratch
        print_parts(training or from_rig(), holdout)


def from_rig() -> list[Recording]:
    """Three recordings with a compliant carcass."""
    rig = make_campaign("carcass_torsion", 1)
    return [as_read(recording, rig.nominal) for recording in rig.recordings]


def print_parts(training: list[Recording], holdout: list[Recording]) -> None:
    """Diagnose these recordings and print the parts."""
    profile, began = cProfile.Profile(processor_time), processor_time()
    profile.enable()
    diagnosis = diagnose(training, holdout, jobs=1)
    profile.disable()
    whole = processor_time() - began
    found = {
        (Path(file).name, name): (calls, cumulative)
        for (file, _, name), (_, calls, _, cumulative, _) in pstats.Stats(profile).stats.items()  # type: ignore[attr-defined]
    }
    print(f"named: {', '.join(effect.name for effect in diagnosis.effects) or 'nothing'}")
    print(f"{whole:8.1f} s  all")
    inside = 0.0
    for file, name, meaning in PARTS:
        calls, cumulative = found[file, name]
        # The last two simulate a little of their own; what is inside them is small beside the fits.
        own = cumulative - inside if name in ("kernel_source", "simulate", "run_trial") else cumulative
        inside = cumulative
        print(f"{own:8.1f} s  {meaning} ({calls} times)")


if __name__ == "__main__":
    main()
