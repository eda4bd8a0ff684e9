"""`brushgrip diagnose`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_directory
from brushgrip.commands.options import Jobs, OutFolder, RecordingNames, RigFile
from brushgrip.console import progress, say
from brushgrip.friction import FrictionTrack
from brushgrip.recordings import keep_inputs, read_all
from brushgrip.report import PAGE, write_report
from brushgrip.tables import json_text, print_summary
from brushgrip.unfinished import kept_trials
from identification.diagnosis import diagnose as close_the_loop
from identification.fits.loss import LEAST_SQUARES, Huber
from identification.modelfile import model_text
from identification.results import Diagnosis

DIAGNOSIS, MODEL = "diagnosis.json", "model.json"


def diagnose(
    recordings: RecordingNames,
    out: OutFolder,
    holdout: Annotated[
        list[str] | None,
        typer.Option(
            "--holdout",
            metavar="REC...",
            help="Recordings that only judge: one or more names after the flag.",
            show_default=False,
        ),
    ] = None,
    robust: Annotated[
        float | None,
        typer.Option(
            "--robust",
            metavar="SHARE",
            help="Torque errors beyond this share of range pull no harder than one of that size (Huber);"
            " for a torque with outliers, 1.5 times its noise.",
            show_default=False,
        ),
    ] = None,
    rig: RigFile = None,
    jobs: Jobs = None,
) -> None:
    """Find what the declared model lacks; write diagnosis.json, model.json and report.html.

    Interrupted, it keeps what it has; the same command goes on from there.
    """
    held_out = holdout or []
    read = read_all([*recordings, *held_out], rig)
    outputs = [out / DIAGNOSIS, out / MODEL, out / PAGE, *out.resolve().glob("*.png")]
    keep_inputs(outputs, [*recordings, *held_out], rig)
    training = read[: len(recordings)]
    loss = LEAST_SQUARES if robust is None else Huber(threshold=robust)
    with kept_trials(out) as journal, staged_directory(out) as folder:
        with progress() as report:
            result = close_the_loop(
                training,
                read[len(training) :],
                loss=loss,
                jobs=jobs,
                progress=report,
                journal=journal,
            )
        write_diagnosis(folder, result)
    print_summary(result)
    say(f"report: {out / PAGE}")


def write_diagnosis(folder: Path, diagnosis: Diagnosis, friction: Sequence[FrictionTrack] = ()) -> None:
    """Writes diagnosis.json, model.json, report.html and the pictures into an existing folder."""
    for name, text in (
        (DIAGNOSIS, json_text(diagnosis.to_dict())),
        (MODEL, model_text(diagnosis)),
    ):
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    write_report(folder, diagnosis, friction)
