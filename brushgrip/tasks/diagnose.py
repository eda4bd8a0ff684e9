"""`brushgrip diagnose`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from brushgrip.atomic import staged_directory
from brushgrip.cluster import executor_at
from brushgrip.console import print_diagnosis, progress, say, show, warn
from brushgrip.estimation import FrictionTrack, implausible
from brushgrip.formatting import json_text
from brushgrip.friction_outcome import FrictionOutcome, friction_outcome
from brushgrip.grounds import on_grounds
from brushgrip.provenance import KEY, Provenance, clear, digest_of, provenance_of, require_own_folder
from brushgrip.recordings import files_read, keep_inputs, read_all, signal_map
from brushgrip.report import PAGE, remove_stale_pictures, write_report
from brushgrip.unfinished import kept_trials
from brushgrip.user_effects import effect_files, user_effects
from identification import LEAST_SQUARES, Diagnosis, Huber, Recording, model_text
from identification import diagnose as close_the_loop
from identification.reading.long_recordings import bounded
from identification.selection.trials import RANKING_STEP, thin
from symbolic import CANDIDATES

DIAGNOSIS, MODEL = "diagnosis.json", "model.json"


def diagnose(
    *,
    recordings: Sequence[str],
    out: Path,
    holdout: Sequence[str] | None,
    robust: float | None,
    effects: Sequence[str] | None,
    ground: Sequence[str] | None,
    rig: Path | None,
    channel_map: str | None,
    jobs: int | None,
    scheduler: str | None,
    force: bool = False,
) -> None:
    """Search for what the declared model lacks, and write all results.

    Its arguments are those of the command; see `brushgrip diagnose --help`.
    """
    own = user_effects(effects)
    held_out = holdout or []
    read = on_grounds(read_all([*recordings, *held_out], rig, given_map=channel_map), ground)
    files, made = _origin([*recordings, *held_out], effects, rig, channel_map, {
        "held_out": len(held_out), "robust": robust, "ground": list(ground or ()),
    })  # fmt: skip
    outputs = [out / DIAGNOSIS, out / MODEL, out / PAGE, *out.resolve().glob("*.png")]
    keep_inputs(outputs, files, rig)
    earlier = require_own_folder(out / DIAGNOSIS, made, force=force)
    for line in implausible(read):
        warn(line)
    training = read[: len(recordings)]
    loss = LEAST_SQUARES if robust is None else Huber(threshold=robust)
    with (
        kept_trials(out) as journal,
        staged_directory(out) as folder,
        executor_at(scheduler) as executor,
    ):
        used, shortened = bounded(read)
        for line in filter(None, (shortened, thinning(used))):
            say(line)
        with progress() as report:
            result = close_the_loop(
                training,
                read[len(training) :],
                loss=loss,
                candidates=[*CANDIDATES, *own],
                jobs=jobs,
                executor=executor,
                progress=report,
                journal=journal,
            )
            report("estimating friction", 0, 1)
            outcome = friction_outcome(used[: len(training)], used[len(training) :], result)
        content = write_diagnosis(folder, result, outcome, made=made)
    clear(out, earlier, content[KEY]["files"])
    remove_stale_pictures(out, content[KEY]["files"])
    print_diagnosis(result, outcome)
    show(content)
    say(f"report: {out / PAGE}")


def _origin(
    names: Sequence[str],
    effects: Sequence[str] | None,
    rig: Path | None,
    channel_map: str | None,
    settings: dict[str, Any],
) -> tuple[list[Path], Provenance]:
    """The files that are read besides the rig, and the provenance of the results."""
    signals = signal_map(rig, channel_map)
    files = files_read(names, signals, effect_files(effects))
    return files, provenance_of(files, rig, signals=signals.to_dict(), **settings)


def thinning(recordings: Sequence[Recording]) -> str:
    """What of these recordings the search leaves out while it ranks candidates; empty for nothing."""
    whole, thinned = (sum(r.t.size for r in some) for some in (recordings, map(thin, recordings)))
    if thinned == whole:
        return ""
    return (
        f"candidates are ranked on {thinned} of {whole} samples, thinned towards {RANKING_STEP:g} s;"
        " the best are fitted to all of them"
    )


def document(diagnosis: Diagnosis, outcome: FrictionOutcome | None) -> dict[str, Any]:
    """The content of diagnosis.json."""
    return diagnosis.to_dict() | {"friction": outcome.to_dict() if outcome else None}


def write_diagnosis(
    folder: Path,
    diagnosis: Diagnosis,
    outcome: FrictionOutcome | None = None,
    friction: Sequence[FrictionTrack] = (),
    made: Provenance | None = None,
) -> dict[str, Any]:
    """Writes diagnosis.json, model.json, report.html and the pictures into an existing folder.

    Args:
        folder: to write to.
        diagnosis: the result of the search.
        outcome: friction before and after, None where none was estimated.
        friction: estimates of friction over time to show in the report, may be empty.
        made: where the results come from; None for a run outside a command.

    Returns:
        The content of diagnosis.json.
    """
    made = provenance_of([]) if made is None else made
    model = json.loads(model_text(diagnosis)) | {KEY: dict(made)}
    _write(folder / MODEL, json_text(model))
    digest = digest_of(folder / MODEL)
    told = {**made, "model": {"name": MODEL, "sha256": digest}}
    write_report(folder, diagnosis, friction, outcome, told)
    files = sorted({DIAGNOSIS, *(path.name for path in folder.iterdir())})
    content = document(diagnosis, outcome) | {KEY: {**told, "files": files}}
    _write(folder / DIAGNOSIS, json_text(content))
    return content


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
