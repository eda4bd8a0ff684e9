"""Friction over a batch of recordings, one or many: a table for each, and a summary of all."""

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import nan
from pathlib import Path

import numpy as np

from brushgrip.estimation.anomalies import (
    beyond_range,
    differing_rates,
    far_load,
    hardly_turned,
    inconsistency_remedy,
    require_plausible,
    suspected_cause,
    unstated_range,
    weaker_direction,
)
from brushgrip.estimation.budget import friction_budget
from brushgrip.estimation.estimates import (
    Aligning,
    friction_track,
    has_aligning_torque,
    has_steering_torque,
    observe,
    observer_factory,
)
from brushgrip.estimation.friction_by_direction import OF_DIRECTIONS, friction_of_directions
from brushgrip.inputs.choices import ObserverName
from brushgrip.inputs.command_inputs import Inputs
from brushgrip.inputs.settings import ChosenTuning
from brushgrip.outputs.atomic import check_png_name, staged_files, write_utf8
from brushgrip.outputs.console import Progress, progress
from brushgrip.outputs.standard_streams import REMARKS
from brushgrip.pictures.friction import draw_friction
from brushgrip.running.cluster import cluster_or_local_executor
from brushgrip.wording.declared_values import STANDS, rests_on
from brushgrip.wording.formatting import csv_text
from brushgrip.wording.friction import (
    band_parts,
    dry_friction_note,
    estimates_summary,
    last_usable,
    not_usable,
)
from brushgrip.wording.remarks import BETWEEN, remark
from identification import Recording, read_rig
from identification.diagnosis.found_stiffness import stiffness_note
from identification.selection.trial_runner import Submit, as_completed, workers
from observers import ESTIMATE, DirectionalFriction, Estimates, Status
from symbolic import BrushgripError, InvalidInputError

FLAGS = {
    "rejected": Status.REJECTED,
    "inconsistent": Status.INCONSISTENT,
    "acquiring": Status.ACQUIRING,
    "suspect": Status.SUSPECT,
    "bound": Status.BOUND,
    "implausible": Status.IMPLAUSIBLE,
}
"""Columns of the summary with the share of samples that have a flag [1]: rejected, not explained by
model and stated error, friction being acquired, an input suspect, mu on its bound, a value
implausible."""
FRICTION = ("mu_eff", "mu_eff_std", "mu", "mu_std")
"""Columns of the summary with friction by the last usable sample on the last ground [1]; empty without
one."""
COLUMNS = (
    *("recording", "ground", "samples", "measured", "duration"),
    *FRICTION,
    *OF_DIRECTIONS,
    *("first_usable", "last_usable", "usable", "informed"),
    *FLAGS,
    *("wide", "changes", "fault", "remark"),
)
"""Columns of the summary; measured are the samples with a torque, of which usable, informed and the
flags are shares [1], implausible that of all samples, wide that without a flag whose deviation of mu is
too large; duration, first_usable, last_usable [s], changes of the ground, what is wrong, and what is
told beside friction."""
DIGITS = 5
"""Significant digits of a number in the summary."""
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of a text that spreadsheets take for a formula."""
Row = Mapping[str, str | int | float]


@dataclass(frozen=True, kw_only=True)
class EstimateTask:
    """Inputs of a process that estimates friction over one recording.

    Attributes:
        inputs: of this recording alone.
        observer: which observer.
        tuning: of the observer, None for the usual.
        smooth: every sample from the whole recording.
        aligning: how M_z is measured, None for the usual.
        out: table to write, None for none.
        picture: picture to draw, None for none.
        budget: whether to say what the band is made of.
    """

    inputs: Inputs
    observer: ObserverName
    tuning: ChosenTuning | None
    smooth: bool
    aligning: Aligning | None
    out: Path | None
    picture: Path | None = None
    budget: bool = False


@dataclass(frozen=True, kw_only=True)
class EstimateOutcome:
    """Outcome of a task.

    Attributes:
        row: of the summary.
        lines: in words, empty where there is a fault.
        fault: why the recording could not be estimated.
    """

    row: Row
    lines: tuple[str, ...] = ()
    fault: BrushgripError | None = None


def other_outputs(
    out: Path | None, summary: Path | None, picture: Path | None, *, alone: bool
) -> list[Path]:
    """Files that are written beside the tables of a batch: the summary, or all of a single recording."""
    if alone:
        if out is None:
            if picture is not None:
                check_png_name(picture)
            return [picture] if picture else []
        if out.suffix.lower() == ".png":
            raise InvalidInputError(f"{out}: the table needs a name such as .csv; .png is its picture")
        image = picture or out.with_suffix(".png")
        check_png_name(image)
        return [out, image]
    if picture is not None:
        raise InvalidInputError("--picture is that of one recording without --summary; leave it out")
    return [summary] if summary else []


@contextmanager
def task_submission(
    inputs: Inputs, tasks: Sequence[EstimateTask], jobs: int | None, scheduler: str | None
) -> Iterator[tuple[Submit, Progress]]:
    """Where tasks are done, and who is told how far they are; a single one is done in this process."""
    if len(tasks) == 1 and scheduler is None:
        jobs = 1
    if inputs.rig is not None:
        read_rig(inputs.rig)
    inputs.found()
    with (
        cluster_or_local_executor(scheduler, jobs) as executor,
        progress() as report,
        workers(jobs, inputs.effects, executor) as submit,
    ):
        yield submit, report


def estimate_all(
    tasks: Sequence[EstimateTask], submit: Submit, report: Callable[[str, int, int], None]
) -> list[EstimateOutcome]:
    """Outcome of each task, in their order; the fault of one does not stop the others."""
    futures = {submit(estimate_one, task): i for i, task in enumerate(tasks)}
    outcomes: dict[int, EstimateOutcome] = {}
    for future in as_completed(futures):
        outcomes[futures[future]] = future.result()
        if len(outcomes) < len(tasks):
            report("estimating friction", len(outcomes), len(tasks))
    return [outcomes[i] for i in range(len(tasks))]


def estimate_one(task: EstimateTask) -> EstimateOutcome:
    """Estimates friction over one recording, and writes its table and its picture."""
    if REMARKS.get() is None:
        REMARKS.set(set())
    try:
        return _estimated(task)
    except BrushgripError as error:
        (name,) = task.inputs.paths
        row = {**dict.fromkeys(COLUMNS, ""), "recording": name, "fault": str(error)}
        return EstimateOutcome(row=row, fault=error)


def _estimated(task: EstimateTask) -> EstimateOutcome:
    recording = _read(task.inputs)
    require_plausible(recording)
    found = task.inputs.found()
    with staged_files([path for path in (task.out, task.picture) if path]) as stages:
        factory = observer_factory(task.observer, task.tuning, task.aligning)
        estimates = observe(factory, recording, found, smoothed=task.smooth)
        if task.out:
            columns = {name: getattr(estimates, name) for name in ("t", *ESTIMATE)}
            write_utf8(stages[0], csv_text(columns))
        if task.picture:
            label = ("assumed model" if found is None else "model found") + ", smoothed" * task.smooth
            draw_friction(stages[-1], [friction_track(task.observer, recording, estimates, label)])
    noise = inconsistency_remedy(factory(recording, found), recording, estimates)
    of_car = recording.standstills is not None
    rates, at, budget, note, of_model = differing_rates(recording), last_usable(estimates), {}, "", ""
    cause = "" if estimates.usable.any() else hardly_turned(recording)
    doubts = [beyond_range(recording) or unstated_range(recording)]
    if at is None:
        cause = cause or suspected_cause(factory, recording, found, estimates) or doubts[0]
    number, why = not_usable(estimates, noise, rates, cause, of_car=of_car)
    told = [estimates_summary(estimates, noise, rates, cause, of_car=of_car)]
    by_direction = isinstance(task.aligning, DirectionalFriction)
    directed, line = friction_of_directions(estimates) if by_direction else ({}, "")
    told.append(line)
    if task.budget and not task.smooth:
        budget = friction_budget(factory, recording, found, estimates)
        told.append(band_parts(budget))
    if at is None:
        told.append("" if why == cause else cause)
    elif (car := recording.standstills) is None:
        note = dry_friction_note(float(estimates.mu_eff[at]), recording.rig)
        told.append(note)
    else:
        note = "" if car.speed_recorded else STANDS
        told += [note, "" if budget else rests_on(car.vehicle, brakes=car.brakes[int(car.stretch[at])])]
    if found is not None and recording.standstills is None:
        values = found.values_for_estimation(recording.ground)
        doubts += [stiffness_note(values["k"], recording), far_load(recording, found)]
        of_model = "" if by_direction else weaker_direction(values)
    told += [*(doubt for doubt in doubts if doubt != cause), of_model]
    note = BETWEEN.join(filter(None, (note, *doubts)))
    lines = (f"{recording.name}: {line}" for line in told if line)
    beside = remark(estimates, cause if cause and at is None else why * (number > 0), note)
    row = {**row_of(recording, estimates, beside), **directed}
    return EstimateOutcome(row=row, lines=tuple(lines))


def _read(inputs: Inputs) -> Recording:
    """The recording with its aligning or steering torque; without both, the message asks for M_z."""
    (recording,) = inputs.recordings(torque_required=False, causal=True)
    if not (has_aligning_torque(recording) or has_steering_torque(recording)):
        (recording,) = inputs.recordings(causal=True)
    return recording


def row_of(recording: Recording, estimates: Estimates, beside: str = "") -> Row:
    """The row of a recording that has been estimated."""
    at, measured = last_usable(estimates), estimates.measured
    count = max(1, int(measured.sum()))

    def share(flag: Status) -> float:
        flagged = estimates.status & flag != 0
        # An implausible torque is left out, and then missing.
        if flag is Status.IMPLAUSIBLE:
            return float(flagged.mean())
        return float((flagged & measured).sum()) / count

    return {
        "recording": recording.name,
        "ground": recording.ground or "",
        "samples": estimates.t.size,
        "measured": int(measured.sum()),
        "duration": float(estimates.t[-1] - estimates.t[0]),
        **{name: nan if at is None else float(getattr(estimates, name)[at]) for name in FRICTION},
        "first_usable": nan if at is None else estimates.usable_from,
        "last_usable": nan if at is None else float(estimates.t[at]),
        "usable": estimates.usable_share,
        "informed": float((estimates.informed & measured).sum()) / count,
        **{name: share(flag) for name, flag in FLAGS.items()},
        "wide": float((estimates.wide & measured).sum()) / count,
        "changes": int(np.count_nonzero(estimates.status & Status.RESET)),
        "fault": "",
        "remark": beside,
    }


def summary_csv(rows: Sequence[Row]) -> str:
    """The rows as CSV; what is not known is empty, and no text is a formula to a spreadsheet."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _cell(value) for name, value in row.items()} for row in rows)
    return text.getvalue()


def _cell(value: str | int | float) -> str | int | float:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(FORMULA) else value
    return value if isinstance(value, int) else "" if value != value else f"{value:.{DIGITS}g}"
