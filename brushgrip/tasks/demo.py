"""`brushgrip demo`."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shutil import copyfile, copytree, ignore_patterns

import brushgrip
from brushgrip.atomic import staged_directory
from brushgrip.choices import ObserverName
from brushgrip.console import print_diagnosis, progress, say, show
from brushgrip.estimation import OBSERVERS, FrictionTrack, friction_track, observe
from brushgrip.friction_outcome import found_model, friction_outcome, offline_friction
from brushgrip.provenance import KEY, clear, provenance_of, require_own_folder
from brushgrip.recordings import read_all
from brushgrip.report import PAGE, remove_stale_pictures
from brushgrip.tasks.diagnose import DIAGNOSIS, write_diagnosis
from identification import Diagnosis, FoundModel, Recording, diagnose
from symbolic import InvalidInputError

RIG = "rig.toml"
SIMULATED, FIRST = "reference_rig", "estimate_in_a_loop.py"


def demo(*, out: Path, examples: Path | None = None, force: bool = False) -> None:
    """Diagnose the embedded recordings and write all results; or write the examples alone.

    Its arguments are those of the command; see `brushgrip demo --help`.
    """
    if examples is not None:
        copy_examples(examples)
        return
    folder = embedded_folder()
    training = [str(path) for path in sorted(folder.glob("train*.csv"))]
    held_out = [str(path) for path in sorted(folder.glob("holdout*.csv"))]
    read = read_all([*training, *held_out], folder / RIG)
    recordings, holdout = read[: len(training)], read[len(training) :]
    made = provenance_of([Path(name) for name in (*training, *held_out)], folder / RIG)
    earlier = require_own_folder(out / DIAGNOSIS, made, force=force)
    with staged_directory(out) as stage:
        with progress() as report:
            result = diagnose(recordings, holdout, progress=report)
            report("estimating friction", 0, 1)
            outcome = friction_outcome(recordings, holdout, result)
            tracks = estimate_friction(holdout, result)
        content = write_diagnosis(stage, result, outcome, tracks, made)
        copyfile(folder / RIG, stage / RIG)
    clear(out, earlier, content[KEY]["files"])
    remove_stale_pictures(out, content[KEY]["files"])
    print_diagnosis(result, outcome)
    show(content)
    say(f"report: {out / PAGE}")


def estimate_friction(recordings: Sequence[Recording], diagnosis: Diagnosis) -> list[FrictionTrack]:
    """Friction over each recording: EKF on the declared model, EKF and MHE on the model found."""
    found = found_model(diagnosis)
    fitted = replace(found, own=diagnosis.values.own, rig=diagnosis.values.rig)
    runs: list[tuple[ObserverName, FoundModel | None, str]] = [
        (ObserverName.EKF, None, "declared model"),
        (ObserverName.EKF, found, "model found"),
        (ObserverName.MHE, found, "model found"),
    ]
    return [
        replace(
            friction_track(observer, recording, observe(OBSERVERS[observer], recording, model), label),
            reference=offline_friction(fitted, recording),
            reference_label="μ_eff fitted to the whole recording",
        )
        for recording in recordings
        for observer, model, label in runs
    ]


def copy_examples(out: Path) -> None:
    """Writes the examples, their recordings and the rig that they simulate to a new folder.

    Raises:
        InvalidInputError: the folder holds something, or the examples are missing.
    """
    if out.is_dir() and any(out.iterdir()):
        raise InvalidInputError(f"{out}: is not empty; name a new folder for the examples")
    source = embedded_folder().parent
    rig = next(place for place in (source, source.parent) if (place / SIMULATED).is_dir()) / SIMULATED
    leave = ignore_patterns("__pycache__", "*_output")
    with staged_directory(out) as stage:
        copytree(source, stage, ignore=leave, dirs_exist_ok=True)
        copytree(rig, stage / SIMULATED, ignore=leave, dirs_exist_ok=True)
    scripts = sorted(str(path) for path in out.glob("*.py"))
    say(f"wrote {len(scripts)} examples to {out}; python {out / FIRST} runs one")
    show({"wrote": scripts})


def embedded_folder() -> Path:
    """The demo's recordings: in a checkout among the examples, else inside the package.

    Raises:
        InvalidInputError: they are in neither place.
    """
    package = Path(brushgrip.__file__).parent
    folders = tuple(
        place / "recordings" for place in (package.parent / "examples", package / "embedded")
    )
    for folder in folders:
        if (folder / RIG).is_file():
            return folder
    raise InvalidInputError(
        f"the demo's recordings are missing from this installation; looked for {RIG} in "
        f"{' and '.join(map(str, folders))}; install brushgrip anew"
    )
