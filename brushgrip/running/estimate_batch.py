"""Friction over a batch of recordings, one or many: a table for each, and a summary of all."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brushgrip.estimation.friction_at_common_load import friction_load_text
from brushgrip.estimation.friction_budget import STANDS, declared_uncertainty_text, friction_budget
from brushgrip.estimation.friction_by_direction import (
    directional_friction_and_line,
    hidden_by_torque_zero_note,
)
from brushgrip.estimation.observe_recording import (
    ObserverFactory,
    friction_track,
    observe,
)
from brushgrip.estimation.recording_warnings import (
    car_force_slope_note,
    constant_load_note,
    differing_sample_rates_note,
    direction_deficit_and_note,
    hardly_turned_note,
    implausibility_lines,
    inconsistency_remedy,
    load_outside_model_note,
    range_reached_note,
    suspected_cause,
    suspected_range_note,
    why_not_acquired,
)
from brushgrip.inputs.command_inputs import Inputs
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.outputs.atomic import check_png_name, staged_files, table_and_picture, write_utf8
from brushgrip.outputs.console import Progress, progress
from brushgrip.outputs.standard_streams import REMARKS
from brushgrip.pictures.friction import draw_friction
from brushgrip.running.dask_or_local_executor import cluster_or_local_executor
from brushgrip.running.row_spool import Row, RowSpool
from brushgrip.running.summary_table import COLUMNS, summary_row
from brushgrip.wording.formatting import csv_text
from brushgrip.wording.friction_in_words import (
    band_composition_text,
    estimates_summary,
    slippery_ground_note,
    unusable_samples_and_remedy,
)
from brushgrip.wording.recording_remarks import BETWEEN, recording_remark
from identification import Recording, read_rig
from identification.diagnosis.found_vs_declared_stiffness import stiffness_note
from identification.selection.trial_runner import Submit, as_completed, worker_submitter
from observers import ESTIMATE, DirectionalFriction
from observers.quality.when_usable import last_usable
from symbolic import BrushgripError, InvalidInputError


@dataclass(frozen=True, kw_only=True)
class EstimateTask:
    """What a process needs to estimate friction over one recording."""

    inputs: Inputs
    observer: ObserverName
    factory: ObserverFactory  # Of that observer.
    smooth: bool
    out: Path | None
    picture: Path | None = None
    budget: bool = False  # Whether to tell what the band is made of.


@dataclass(frozen=True, kw_only=True)
class EstimateOutcome:
    """The row of the summary, and what is told in words; or why it could not be estimated."""

    row: Row
    lines: tuple[str, ...] = ()
    fault: BrushgripError | None = None


def output_files_beside_tables(
    out: Path | None, summary: Path | None, picture: Path | None, *, alone: bool
) -> list[Path]:
    """Files that are written beside the tables of a batch: the summary, or all of a single recording."""
    if not alone:
        if picture is not None:
            raise InvalidInputError("--picture is that of one recording without --summary; leave it out")
        return [summary] if summary else []
    tables = table_and_picture(out)
    if picture is None:
        return tables
    check_png_name(picture)
    return [*tables[:1], picture]


@contextmanager
def task_executor(
    inputs: Inputs, jobs: int | None, scheduler: str | None
) -> Iterator[tuple[Submit, Progress]]:
    """Where tasks are done, and who is told how far they are; a single one is done in this process."""
    if len(inputs.paths) == 1 and scheduler is None:
        jobs = 1
    if inputs.rig is not None:
        read_rig(inputs.rig)
    inputs.read_found_model()
    with (
        cluster_or_local_executor(scheduler, jobs) as executor,
        progress() as report,
        worker_submitter(jobs, inputs.effects, executor) as submit,
    ):
        yield submit, report


def estimate_all(
    tasks: Iterable[EstimateTask], count: int, submit: Submit, report: Callable[[str, int, int], None]
) -> tuple[Sequence[Row], EstimateOutcome]:
    """Row of each of so many tasks, in their order, and the outcome that came last.

    The fault of one does not stop the others.
    """
    numbers, rows = dict[Future[EstimateOutcome], int](), RowSpool(count)

    def submitted() -> Iterator[Future[EstimateOutcome]]:
        for number, task in enumerate(tasks):
            numbers[future := submit(estimate_one, task)] = number
            yield future

    for done, future in enumerate(as_completed(submitted()), start=1):
        outcome: EstimateOutcome = future.result()
        rows.put(numbers.pop(future), outcome.row)
        if done < count:
            report("estimating friction", done, count)
    return rows, outcome


def estimate_one(task: EstimateTask) -> EstimateOutcome:
    """Estimates friction over one recording, and writes its table and its picture."""
    if REMARKS.get() is None:
        REMARKS.set(set())
    try:
        return _estimate_and_write(task)
    except BrushgripError as error:
        (name,) = task.inputs.paths
        row = {**dict.fromkeys(COLUMNS, ""), "recording": name, "fault": str(error)}
        return EstimateOutcome(row=row, fault=error)


def _estimate_and_write(task: EstimateTask) -> EstimateOutcome:
    recording = _read(task.inputs)
    for line in implausibility_lines([recording]):
        raise InvalidInputError(line)
    found, factory = task.inputs.read_found_model(), task.factory
    with staged_files([path for path in (task.out, task.picture) if path]) as stages:
        estimates = observe(factory, recording, found, smoothed=task.smooth)
        if task.out:
            columns = {name: getattr(estimates, name) for name in ("t", *ESTIMATE)}
            write_utf8(stages[0], csv_text(columns))
        if task.picture:
            label = ("assumed model" if found is None else "model found") + ", smoothed" * task.smooth
            draw_friction(stages[-1], [friction_track(task.observer, recording, estimates, label)])
    observer, of_found = factory(recording, found), found is not None
    noise = inconsistency_remedy(observer, recording, estimates, of_found=of_found)
    of_car = recording.standstills is not None
    rates, at, budget, note = differing_sample_rates_note(recording), last_usable(estimates), {}, ""
    cause = "" if estimates.usable.any() else hardly_turned_note(recording)
    notes = range_reached_note, suspected_range_note, constant_load_note
    doubts = [note_of(recording) for note_of in notes]
    if at is None:
        cause = cause or suspected_cause(factory, recording, found, estimates) or doubts[0]
        cause = cause or hidden_by_torque_zero_note(observer, estimates)
        cause = cause or why_not_acquired(observer, recording, estimates)
    unusable = unusable_samples_and_remedy(estimates, noise, rates, cause, of_car=of_car)
    number, why = unusable
    aligning, directed, line = getattr(observer, "measurement_model", None), dict[str, str | float](), ""
    if by_direction := isinstance(aligning, DirectionalFriction):
        directed, line = directional_friction_and_line(estimates, recording.psi, recording.M_z, aligning)
    way = str(directed.get("direction", ""))
    told = [estimates_summary(estimates, unusable, rates, way), line]
    if task.budget and not task.smooth:
        budget = friction_budget(factory, recording, found, estimates)
        advised = ", or find what the model lacks (brushgrip diagnose)" * of_found
        told.append(band_composition_text(budget).replace(advised, ""))
    if at is None:
        told.append("" if why == cause else cause)
    elif (car := recording.standstills) is None:
        told.append(note := slippery_ground_note(float(estimates.mu_eff[at]), recording.rig))
    else:
        note = "" if car.speed_recorded else STANDS
        brakes = car.brakes[int(car.stretch[at])]
        told += [note, "" if budget else declared_uncertainty_text(car.vehicle, brakes=brakes)]
        doubts.append(car_force_slope_note(factory, recording, at))
    if found is not None and recording.standstills is None:
        values = found.values_for_estimation(recording.ground)
        at_load = "" if at is None else friction_load_text(found, recording, at)
        far = load_outside_model_note(recording.F_N, found.basis.loads if found.basis else None)
        doubts += [stiffness_note(values["k"], recording), far, at_load]
        if at is not None and not by_direction:
            mu_eff, std = float(estimates.mu_eff[at]), float(estimates.mu_eff_std[at])
            directed["weaker"], of_model = direction_deficit_and_note(values, mu_eff, std)
            doubts.append(of_model)
    doubts = [doubt for doubt in doubts if doubt != cause]
    note = BETWEEN.join(filter(None, (note, *doubts)))
    lines = (f"{recording.name}: {line}" for line in (*told, *doubts) if line)
    why = cause if cause and at is None else why * (number > 0)
    beside = recording_remark(estimates, why, note, of_way=by_direction)
    row = {**summary_row(recording, estimates, beside), **directed}
    return EstimateOutcome(row=row, lines=tuple(lines))


def _read(inputs: Inputs) -> Recording:
    """The recording with its aligning or steering torque; without both, the message asks for M_z."""
    (recording,) = inputs.recordings(torque_required=False, causal=True)
    if not np.isfinite(recording.aligning_or_steering_torque).any():
        (recording,) = inputs.recordings(causal=True)
    return recording
