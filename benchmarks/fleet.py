"""A fleet of recordings estimated on a Dask cluster of local workers: how many a second.

    python benchmarks/fleet.py --recordings 1000 --workers 2 [--samples N] [--local]

The recordings are those of the demo with new noise, so that no two are alike. The same command with
`--scheduler` of a real cluster does the same there. `--samples` cuts each recording short, so that very
many take minutes; `--local` does without Dask, whose scheduler has memory of its own. The largest memory
is that of the process of the command, not of the workers.
"""

import argparse
import csv
import resource
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from benchmarks.car_files import run_command

SOURCE = Path(__file__).parents[1] / "examples" / "recordings"
NOISE = 0.1
"""Standard deviation of the noise that is added to the torque [N m]."""


def main() -> None:
    """Print recordings and samples a second, and what the summary says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--samples", type=int)
    parser.add_argument("--local", action="store_true")
    options = parser.parse_args()
    from distributed import LocalCluster

    with tempfile.TemporaryDirectory() as folder:
        files = make_fleet(Path(folder), options.recordings, options.samples)
        table = Path(folder) / "table.csv"
        workers = {"n_workers": options.workers, "threads_per_worker": 1, "dashboard_address": None}
        with nullcontext() if options.local else LocalCluster(**workers) as cluster:
            local = ("--jobs", str(options.workers))
            on = ("--scheduler", cluster.scheduler_address) if cluster else local
            # One recording for each worker before, so that what is compiled once is not counted.
            estimate(files[: 2 * options.workers], table, on)
            start = time.perf_counter()
            estimate(files, table, on)
            seconds = time.perf_counter() - start
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with table.open() as content:
            rows = list(csv.DictReader(content))
    samples = sum(int(row["samples"] or 0) for row in rows)
    mu = np.array([float(row["mu"]) for row in rows if row["mu"]])
    print(f"{len(rows)} recordings, {samples} samples, {options.workers} workers: {seconds:.1f} s")
    print(f"{len(rows) / seconds:.1f} recordings a second, {samples / seconds:.0f} samples a second")
    print(f"largest memory of the command: {memory / 1024:.0f} MB")
    if mu.size:
        print(f"mu at the end: {mu.mean():.3f}, standard deviation {mu.std():.3f}, {mu.size} known")


def make_fleet(folder: Path, count: int, samples: int | None) -> list[Path]:
    """So many recordings in a folder, each of so many samples."""
    random = np.random.default_rng(1)
    sources = sorted(SOURCE.glob("*.csv"))
    tables = [np.genfromtxt(path, delimiter=",", names=True, comments="#") for path in sources]
    files = []
    for number in range(count):
        table = tables[number % len(tables)][:samples].copy()
        names = table.dtype.names or ()
        table["M_z"] += NOISE * random.standard_normal(table.size)
        path = folder / f"wheel_{number:06}.csv"
        np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.6g")
        files.append(path)
    return files


def estimate(files: list[Path], table: Path, on: tuple[str, str]) -> None:
    """The command, as a user calls it."""
    options = ("--rig", SOURCE / "rig.toml", "--observer", "ekf", "--summary", table)
    run_command("estimate", *files, *options, *on)


if __name__ == "__main__":
    main()
