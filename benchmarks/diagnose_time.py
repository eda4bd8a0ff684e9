"""How long `brushgrip diagnose` takes on the measured recordings: wall and CPU time, cold and warm.

    python benchmarks/diagnose_time.py [--left-out | --second-rig] [--stages] [--tree FOLDER] [--warm]
                                       [--jobs N]

Cold begins with an empty cache of compiled models, warm is the same command again. CPU time is that of
all processes and compilers. Four recordings train and four judge; with `--left-out` all eight train,
each left out in turn. `--second-rig` times `examples/second_rig.py` instead. `--stages` runs once more,
warm and under a profiler, which slows it a little, and prints where the time of the main process goes,
waiting for the others included. `--tree` runs another checkout of this project with this environment, so
that two can be compared under one load of the machine; `--warm` leaves the cold run out where the usual
cache is warm.
"""

import argparse
import json
import os
import pstats
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from published import ground_named, measured_folder

HERE = Path(__file__).resolve().parents[1]
TRAINING = ("fem1", "fem4_ident", "piros2_ident", "piros4")
HELD_OUT = ("fem3", "fem5", "piros1", "piros7")
STAGES = {
    "reading": ("command_inputs.py", "recordings"),
    "search: ranking": ("trial_runner.py", "rank"),
    "search: fits": ("trial_runner.py", "_run"),
    "left out in turn": ("torque_errors_by_stage.py", "left_out_residuals"),
    "experiments": ("diagnose.py", "_nearest_rival_proposals"),
    "grades": ("from_search.py", "build_diagnosis"),
    "observers": ("friction_by_both_models.py", "friction_by_both_models"),
    "pictures": ("page.py", "_draw_pictures"),
    "report": ("page.py", "write_report"),
}
"""File and function of each, none within another one but pictures, within the report."""
OWN = "search: own parameters"
"""Parameters of a recording that judges, within the search's fits."""


def diagnosis_of_measured(out: Path, jobs: int, *, left_out: bool) -> list[str]:
    """The arguments of Python for a diagnosis of the measured recordings."""
    folder = measured_folder().resolve()
    trained = (*TRAINING, *HELD_OUT) if left_out else TRAINING
    files = [str(folder / f"{name}.mat") for name in trained]
    for name in () if left_out else HELD_OUT:
        files += ["--holdout", str(folder / f"{name}.mat")]
    for ground in ("steel", "emery"):
        names = [name for name in (*TRAINING, *HELD_OUT) if ground_named(name) == ground]
        files += ["--ground", f"{ground}={','.join(names)}"]
    options = ["--out", str(out), "--force", "--quiet", "--jobs", str(jobs)]
    return ["-m", "brushgrip", "diagnose", *files, *options]


def second_rig() -> list[str]:
    """The arguments of Python for the diagnosis of the second rig."""
    from brushgrip.published.friction_damper import EARTHQUAKES, HARMONIC, damper_folder
    from second_rig import BESIDE, lacks

    folder = BESIDE if BESIDE.is_dir() else damper_folder()
    if lacks(folder, (*HARMONIC, *EARTHQUAKES), "friction-damper"):
        raise SystemExit(1)
    return [str(Path("examples") / "second_rig.py"), str(folder.resolve())]


def timed(tree: Path, arguments: Sequence[str], cache: Path | None) -> tuple[float, float]:
    """Wall and CPU time of one run of Python [s]."""
    environment = os.environ | {"PYTHONPATH": str(tree)}
    if cache:
        environment["BRUSHGRIP_CACHE"] = str(cache)
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, *arguments]
    subprocess.run(command, check=True, env=environment, cwd=tree, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def stages(profile: Path, wall: float) -> dict[str, float]:
    """Time of each stage of a run that lasted so long [s], by the profile of its main process."""
    times, own = Counter[tuple[str, str]](), 0.0
    entries = pstats.Stats(str(profile)).stats  # type: ignore[attr-defined]
    for (file, _, name), (*_, total, callers) in entries.items():
        times[Path(file).name, name] += total
        if name == "fit_recording_parameters":
            own += sum(by[3] for (_, _, caller), by in callers.items() if caller == "run_trial")
    told = {stage: times[function] for stage, function in STAGES.items()}
    told["report"] -= told["pictures"]
    rest = {"start and all else": wall - sum(told.values())}
    told["search: fits"] -= own
    return rest | told | {OWN: own}


def main() -> None:
    """Print a row for each run and each stage, and what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    case = parser.add_mutually_exclusive_group()
    case.add_argument("--left-out", action="store_true")
    case.add_argument("--second-rig", action="store_true")
    parser.add_argument("--stages", action="store_true")
    parser.add_argument("--tree", type=Path, default=HERE)
    parser.add_argument("--warm", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out, profile, tree = Path(folder) / "out", Path(folder) / "profile", options.tree.resolve()
        own = None if options.warm else Path(folder) / "cache"
        arguments = (
            second_rig()
            if options.second_rig
            else diagnosis_of_measured(out, options.jobs, left_out=options.left_out)
        )
        for name in ("warm",) if options.warm else ("cold", "warm"):
            wall, cpu = timed(tree, arguments, own)
            print(f"| {name} | {wall:.0f} s wall | {cpu:.0f} s CPU | load {os.getloadavg()[0]:.1f} |")
        if options.stages:
            wall, _ = timed(tree, ["-m", "cProfile", "-o", str(profile), *arguments], own)
            for stage, seconds in stages(profile, wall).items():
                print(f"| {stage} | {seconds:.1f} s |")
        if options.second_rig:
            return
        found = json.loads((out / "diagnosis.json").read_text("utf-8"))
    after = found["after"]
    key = "left_out_torque_nrmse" if options.left_out else "holdout_torque_nrmse"
    figures = [after[key]] + ([] if options.left_out else [after["holdout_torque_nrmse_unrefitted"]])
    print(*[effect["name"] for effect in found["effects"]], *[f"{figure:.4%}" for figure in figures])


if __name__ == "__main__":
    main()
