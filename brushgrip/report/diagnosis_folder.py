"""The results of a diagnosis in a folder: what is written, what goes, and what is said."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

import identification
from brushgrip.estimation import friction_by_both_models
from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.outputs.atomic import write_utf8
from brushgrip.outputs.console import print_line, progress, show_json
from brushgrip.outputs.provenance import KEY, Provenance, digest_of, remove_earlier
from brushgrip.report.page import PAGE, remove_stale_pictures, write_report
from brushgrip.report.print_diagnosis_and_fits import print_diagnosis
from brushgrip.report.validity_and_missing_effects import demo_recordings_warning
from brushgrip.wording.formatting import json_text
from identification import Diagnosis, Recording, model_text
from identification.selection.trial import RANKING_STEP, ROUGH_STEP, thin_for_ranking
from identification.selection.trial_runner import submit_of
from observers.interfaces.observer_from_files import MODEL_FILE

DIAGNOSIS, MODEL = "diagnosis.json", MODEL_FILE


def files_diagnosis_may_write(folder: Path) -> list[Path]:
    """Files of a folder that a diagnosis may write."""
    return [folder / DIAGNOSIS, folder / MODEL, folder / PAGE, *folder.resolve().glob("*.png")]


def thinning_note(recordings: Sequence[Recording]) -> str:
    """What of these recordings the search leaves out while it ranks candidates; empty for nothing."""
    whole = sum(recording.t.size for recording in recordings)
    thinned = sum(recording.t.size for recording in map(thin_for_ranking, recordings))
    if thinned == whole:
        return ""
    return (
        f"candidates are ranked on {thinned} of {whole} samples, thinned towards {RANKING_STEP:g} s"
        f" ({ROUGH_STEP:g} s where the error is large); the best are fitted to all of them"
    )


TrainingAndHoldout = tuple[Sequence[Recording], Sequence[Recording]]
"""Recordings for training, and those held out."""


def diagnose_and_write(
    folder: Path,
    searched: TrainingAndHoldout,
    estimated: TrainingAndHoldout,
    provenance: Provenance,
    executor: Executor | None,
    notes: Sequence[str] = (),
    with_inclination: Callable[[float], Sequence[Recording]] | None = None,
    **options: Any,
) -> tuple[dict[str, Any], Diagnosis, FrictionByBothModels | None]:
    """Searches, estimates friction by what was found, and writes all results into an existing folder.

    Options are those of `identification.diagnose`; the notes go before its own; `with_inclination`
    reads all recordings of a car by the vehicle with another inclination [rad]. The content of
    diagnosis.json is returned first.
    """
    submit = submit_of(executor)
    with progress() as report:
        result = identification.diagnose(*searched, executor=executor, progress=report, **options)
        report("estimating friction", 0, 1)
        again = None
        if with_inclination and result.inclination is not None:
            again = with_inclination(result.inclination)
        outcome = friction_by_both_models.friction_by_both_models(*estimated, result, submit, again)
    result = replace(result, notes=(*notes, *result.notes))
    model = json.loads(model_text(result)) | {KEY: dict(provenance)}
    write_utf8(folder / MODEL, json_text(model))
    told = {**provenance, "model": {"name": MODEL, "sha256": digest_of(folder / MODEL)}}
    write_report(folder, result, outcome.complete_tracks if outcome else (), outcome, told, submit)
    content = result.to_dict() | {
        "friction": outcome.to_dict() if outcome else None,
        KEY: {**told, "files": sorted({DIAGNOSIS, *(path.name for path in folder.iterdir())})},
    }
    write_utf8(folder / DIAGNOSIS, json_text(content))
    return content, result, outcome


def clean_up_and_print(
    out: Path,
    earlier: Sequence[str],
    content: dict[str, Any],
    diagnosis: Diagnosis,
    outcome: FrictionByBothModels | None,
) -> None:
    """Removes what an earlier run wrote and this one did not, and says what was found."""
    written = content[KEY]["files"]
    remove_earlier(out, earlier, written)
    remove_stale_pictures(out, written)
    print_diagnosis(diagnosis, outcome, demo_recordings_warning(content[KEY]))
    show_json(content)
    print_line(f"report: {out / PAGE}")
