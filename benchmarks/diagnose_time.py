"""How long `brushgrip diagnose` takes on the measured recordings: wall and CPU time, cold and warm.

    python benchmarks/diagnose_time.py [--tree FOLDER] [--warm] [--jobs N]

Cold begins with an empty cache of compiled models, warm is the same command again. CPU time is that of
all processes and compilers. `--tree` runs another checkout of this project with this environment, so
that two can be compared under one load of the machine; `--warm` leaves the cold run out where the usual
cache is warm.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from published import ground_named, measured_folder

HERE = Path(__file__).resolve().parents[1]
TRAINING = ("fem1", "fem4_ident", "piros2_ident", "piros4")
HELD_OUT = ("fem3", "fem5", "piros1", "piros7")


def diagnosed(tree: Path, out: Path, cache: Path | None, jobs: int) -> tuple[float, float]:
    """Wall and CPU time of one run [s]."""
    folder = measured_folder().resolve()
    files = [str(folder / f"{name}.mat") for name in TRAINING]
    for name in HELD_OUT:
        files += ["--holdout", str(folder / f"{name}.mat")]
    for ground in ("steel", "emery"):
        names = [name for name in (*TRAINING, *HELD_OUT) if ground_named(name) == ground]
        files += ["--ground", f"{ground}={','.join(names)}"]
    options = ["--out", str(out), "--force", "--quiet", "--jobs", str(jobs)]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    if cache:
        environment["BRUSHGRIP_CACHE"] = str(cache)
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, "-m", "brushgrip", "diagnose", *files, *options]
    subprocess.run(command, check=True, env=environment, cwd=tree, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print a row for each run, and what it found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tree", type=Path, default=HERE)
    parser.add_argument("--warm", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        own = None if options.warm else Path(folder) / "cache"
        for name in ("warm",) if options.warm else ("cold", "warm"):
            wall, cpu = diagnosed(options.tree.resolve(), Path(folder) / "out", own, options.jobs)
            print(f"| {name} | {wall:.0f} s wall | {cpu:.0f} s CPU | load {os.getloadavg()[0]:.1f} |")
        found = json.loads((Path(folder) / "out" / "diagnosis.json").read_text("utf-8"))
    after = found["after"]
    figures = [after["holdout_torque_nrmse"], after["holdout_torque_nrmse_unrefitted"]]
    print(*[effect["name"] for effect in found["effects"]], *[f"{figure:.4%}" for figure in figures])


if __name__ == "__main__":
    main()
