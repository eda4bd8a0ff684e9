"""`brushgrip demo`."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import brushgrip
from brushgrip.atomic import staged_directory
from brushgrip.choices import ObserverName
from brushgrip.console import print_diagnosis, progress, say, show
from brushgrip.estimation import OBSERVERS, FrictionTrack, friction_track, observe
from brushgrip.friction_outcome import found_model, friction_outcome
from brushgrip.recordings import read_all
from brushgrip.report import PAGE, remove_stale_pictures
from brushgrip.tasks.diagnose import document, write_diagnosis
from identification import Diagnosis, FoundModel, Recording, diagnose
from symbolic import InvalidInputError

RIG = "rig.toml"


def demo(*, out: Path) -> None:
    """Diagnose the embedded recordings and write all results.

    Its arguments are those of the command; see `brushgrip demo --help`.
    """
    folder = embedded_folder()
    training = [str(path) for path in sorted(folder.glob("train*.csv"))]
    held_out = [str(path) for path in sorted(folder.glob("holdout*.csv"))]
    read = read_all([*training, *held_out], folder / RIG)
    recordings, holdout = read[: len(training)], read[len(training) :]
    with staged_directory(out) as stage:
        with progress() as report:
            result = diagnose(recordings, holdout, progress=report)
            report("estimating friction", 0, 1)
            outcome = friction_outcome(read, found_model(result))
            tracks = estimate_friction(holdout, result)
        write_diagnosis(stage, result, outcome, tracks)
        written = {path.name for path in stage.iterdir()}
    remove_stale_pictures(out, written)
    print_diagnosis(result, outcome)
    show(document(result, outcome))
    say(f"report: {out / PAGE}")


def estimate_friction(recordings: Sequence[Recording], diagnosis: Diagnosis) -> list[FrictionTrack]:
    """Friction over each recording: EKF on the declared model, EKF and MHE on the model found."""
    found = found_model(diagnosis)
    runs: list[tuple[ObserverName, FoundModel | None, str]] = [
        (ObserverName.EKF, None, "declared model"),
        (ObserverName.EKF, found, "model found"),
        (ObserverName.MHE, found, "model found"),
    ]
    return [
        replace(
            friction_track(observer, recording, observe(OBSERVERS[observer], recording, model), label),
            reference=diagnosis.values.own[recording.name]["mu"],
            reference_label="μ fitted to the whole recording",
        )
        for recording in recordings
        for observer, model, label in runs
    ]


def embedded_folder() -> Path:
    """The demo's recordings: in a checkout among the examples, else inside the package.

    Raises:
        InvalidInputError: they are in neither place.
    """
    package = Path(brushgrip.__file__).parent
    folders = (package.parent / "examples" / "recordings", package / "embedded")
    for folder in folders:
        if (folder / RIG).is_file():
            return folder
    raise InvalidInputError(
        f"the demo's recordings are missing from this installation; looked for {RIG} in "
        f"{' and '.join(map(str, folders))}; install brushgrip anew"
    )
