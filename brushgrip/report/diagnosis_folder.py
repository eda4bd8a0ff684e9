"""The results of a diagnosis in a folder: what is written, what goes, and what is said."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from brushgrip.estimation.friction_before_and_after import FrictionOutcome
from brushgrip.outputs.atomic import write_utf8
from brushgrip.outputs.console import say, show
from brushgrip.outputs.provenance import KEY, Provenance, digest_of, provenance_of, remove_earlier
from brushgrip.report.findings_and_reservations import simulated_warning
from brushgrip.report.page import PAGE, remove_stale_pictures, write_report
from brushgrip.report.printed import print_diagnosis
from brushgrip.wording.formatting import json_text
from identification import Diagnosis, Recording, model_text
from identification.selection.trial_runner import Submit, run_at_once
from identification.selection.trials import RANKING_STEP, thin
from observers.interfaces.factory import MODEL_FILE

DIAGNOSIS, MODEL = "diagnosis.json", MODEL_FILE


def results_in(folder: Path) -> list[Path]:
    """Files of a folder that a diagnosis may write."""
    return [folder / DIAGNOSIS, folder / MODEL, folder / PAGE, *folder.resolve().glob("*.png")]


def thinning_note(recordings: Sequence[Recording]) -> str:
    """What of these recordings the search leaves out while it ranks candidates; empty for nothing."""
    whole, thinned = (sum(r.t.size for r in some) for some in (recordings, map(thin, recordings)))
    if thinned == whole:
        return ""
    return (
        f"candidates are ranked on {thinned} of {whole} samples, thinned towards {RANKING_STEP:g} s;"
        " the best are fitted to all of them"
    )


def write_diagnosis(
    folder: Path,
    diagnosis: Diagnosis,
    outcome: FrictionOutcome | None = None,
    made: Provenance | None = None,
    submit: Submit = run_at_once,
) -> dict[str, Any]:
    """Writes diagnosis.json, whose content is returned, model.json, report.html and the pictures."""
    made = provenance_of([]) if made is None else made
    model = json.loads(model_text(diagnosis)) | {KEY: dict(made)}
    write_utf8(folder / MODEL, json_text(model))
    told = {**made, "model": {"name": MODEL, "sha256": digest_of(folder / MODEL)}}
    write_report(folder, diagnosis, outcome.compared if outcome else (), outcome, told, submit)
    content = diagnosis.to_dict() | {
        "friction": outcome.to_dict() if outcome else None,
        KEY: {**told, "files": sorted({DIAGNOSIS, *(path.name for path in folder.iterdir())})},
    }
    write_utf8(folder / DIAGNOSIS, json_text(content))
    return content


def clean_up_and_print(
    out: Path,
    earlier: Sequence[str],
    content: dict[str, Any],
    diagnosis: Diagnosis,
    outcome: FrictionOutcome | None,
) -> None:
    """Removes what an earlier run wrote and this one did not, and says what was found."""
    written = content[KEY]["files"]
    remove_earlier(out, earlier, written)
    remove_stale_pictures(out, written)
    print_diagnosis(diagnosis, outcome, simulated_warning(content[KEY]))
    show(content)
    say(f"report: {out / PAGE}")
