"""Many recordings estimated one by one, in processes, and a table with a row for each."""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from brushgrip.atomic import staged_file
from brushgrip.choices import ObserverName
from brushgrip.estimation import (
    has_aligning_torque,
    has_steering_torque,
    observe,
    observer_factory,
    require_plausible,
)
from brushgrip.formatting import csv_text
from brushgrip.tunings import ChosenTuning
from brushgrip.user_effects import user_effects
from identification import Recording, SignalMap, read_model, read_recording, read_rig
from identification.selection.trial_runner import Submit
from observers import ESTIMATE, Estimates, Status
from symbolic import BrushgripError

COLUMNS = (
    "recording", "ground", "samples", "duration", "mu", "mu_std", "mu_eff", "mu_eff_std", "informed",
    "usable", "rejected", "changes", "inconsistent", "acquiring", "suspect", "bound", "implausible",
    "fault",
)  # fmt: skip
"""Columns of the summary: friction at the end of each recording [1], its duration [s], the share of
informed and of usable samples [1]; samples by their flags: rejected, changes of the ground, not
explained by model and stated error, friction being acquired, an input suspect, mu on its bound, a value
implausible; and what is wrong with a recording."""
Row = Mapping[str, str | int | float]


@dataclass(frozen=True, kw_only=True)
class EstimateTask:
    """What a process needs to estimate friction over one recording: files by absolute paths.

    Attributes:
        name: label of the recording.
        path: its file.
        rig, model: files, None for none.
        signals: where columns come from.
        effects: modules of a user's own effects.
        observer: which observer.
        tuning: of the observer, None for the usual.
        ground: what the wheel stands on; None for what the file says.
        smooth: every sample from the whole recording.
        out: table to write, None for none.
    """

    name: str
    path: Path
    rig: Path | None
    signals: SignalMap
    model: Path | None
    effects: Sequence[str]
    observer: ObserverName
    tuning: ChosenTuning | None
    ground: str | None
    smooth: bool
    out: Path | None


def estimate_all(
    tasks: Sequence[EstimateTask], submit: Submit, report: Callable[[str, int, int], None]
) -> list[Row]:
    """A row for each task, in their order; a recording that cannot be estimated has its fault there."""
    futures = {submit(estimate_one, task): i for i, task in enumerate(tasks)}
    rows: dict[int, Row] = {}
    for future in as_completed(futures):
        rows[futures[future]] = future.result()
        report("estimating friction", len(rows), len(tasks))
    return [rows[i] for i in range(len(tasks))]


def estimate_one(task: EstimateTask) -> Row:
    """The row of one recording; its table is written where one is wanted."""
    try:
        own = user_effects(task.effects)
        found = None if task.model is None else read_model(task.model, effects=own)
        recording = _read(task)
        require_plausible(recording)
        factory = observer_factory(task.observer, task.tuning)
        estimates = observe(factory, recording, found, smoothed=task.smooth)
        if task.out is not None:
            with staged_file(task.out) as table:
                table.write_text(estimates_table(estimates), encoding="utf-8", newline="\n")
    except BrushgripError as error:
        return {**dict.fromkeys(COLUMNS, ""), "recording": task.name, "fault": str(error)}
    return row_of(recording, estimates)


def _read(task: EstimateTask) -> Recording:
    nominal = None if task.rig is None else read_rig(task.rig)
    read = partial(read_recording, task.path, nominal, causal=True, signals=task.signals)
    recording = read(torque_required=False)
    if not (has_aligning_torque(recording) or has_steering_torque(recording)):
        recording = read()
    return replace(recording, name=task.name, ground=task.ground or recording.ground)


def row_of(recording: Recording, estimates: Estimates) -> Row:
    """The row of a recording that has been estimated."""
    counts = {
        name: int(np.count_nonzero(estimates.status & flag))
        for name, flag in (
            ("rejected", Status.REJECTED),
            ("changes", Status.RESET),
            ("inconsistent", Status.INCONSISTENT),
            ("acquiring", Status.ACQUIRING),
            ("suspect", Status.SUSPECT),
            ("bound", Status.BOUND),
            ("implausible", Status.IMPLAUSIBLE),
        )
    }
    friction = {n: float(getattr(estimates, n)[-1]) for n in ("mu", "mu_std", "mu_eff", "mu_eff_std")}
    return {
        "recording": recording.name,
        "ground": recording.ground or "",
        "samples": estimates.t.size,
        "duration": float(estimates.t[-1] - estimates.t[0]),
        **friction,
        "informed": float(estimates.informed.mean()),
        "usable": float(estimates.usable.mean()),
        **counts,
        "fault": "",
    }


def estimates_table(estimates: Estimates) -> str:
    """Estimates as CSV, one row a sample."""
    return csv_text({name: getattr(estimates, name) for name in ("t", *ESTIMATE)})


def summary_table(rows: Sequence[Row]) -> str:
    """The rows as CSV; what is not known is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if value != value else value for name, value in row.items()})
    return text.getvalue()
