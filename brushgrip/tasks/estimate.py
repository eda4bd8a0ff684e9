"""`brushgrip estimate`."""

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from brushgrip.atomic import check_picture_name, is_same_file, staged_file
from brushgrip.choices import ObserverName, TuningName
from brushgrip.cluster import executor_at
from brushgrip.console import progress, say, show
from brushgrip.estimation import (
    friction_track,
    has_aligning_torque,
    has_steering_torque,
    observe,
    observer_factory,
    require_plausible,
)
from brushgrip.fleet import (
    EstimateTask,
    Row,
    estimate_all,
    estimates_table,
    row_of,
    summary_table,
)
from brushgrip.formatting import estimates_summary, json_text
from brushgrip.grounds import grounds_by_name, on_grounds, say_ground
from brushgrip.pictures import draw_friction
from brushgrip.provenance import beside, provenance_of
from brushgrip.recordings import files_read, keep_inputs, labelled, read_all, signal_map
from brushgrip.tunings import ChosenTuning, chosen_tuning
from brushgrip.user_effects import effect_files, user_effects
from identification import Recording, SignalMap, read_model, read_rig
from identification.selection.trial_runner import workers
from symbolic import InvalidInputError


def estimate(
    *,
    recordings: Sequence[str],
    observer: ObserverName,
    out: Path | None,
    summary: Path | None,
    rig: Path | None,
    channel_map: str | None,
    model: Path | None,
    effects: Sequence[str] | None,
    tuning: TuningName | None,
    tune: Sequence[str] | None,
    ground: Sequence[str] | None,
    smooth: bool,
    picture: Path | None,
    jobs: int | None,
    scheduler: str | None,
) -> None:
    """Write friction over time, and a picture of it.

    Its arguments are those of the command; see `brushgrip estimate --help`.
    """
    chosen = chosen_tuning(tuning, tune)
    observer_factory(observer, chosen)
    if len(recordings) == 1 and summary is None:
        _estimate_one(
            recordings[0],
            observer,
            chosen,
            out,
            rig,
            channel_map,
            model,
            effects,
            ground,
            smooth,
            picture,
        )
        return
    _check_batch(out, summary, picture)
    files = labelled(recordings)
    signals = signal_map(rig, channel_map)
    grounds = grounds_by_name(list(files), ground, bare=True)
    tasks = [
        EstimateTask(
            name=name,
            path=path.absolute(),
            rig=None if rig is None else rig.absolute(),
            signals=signals,
            model=None if model is None else model.absolute(),
            effects=tuple(effects or ()),
            observer=observer,
            tuning=chosen,
            ground=grounds.get(name),
            smooth=smooth,
            out=None if out is None else _final(out, name, len(files)).absolute(),
        )
        for name, path in files.items()
    ]
    _estimate_many(tasks, summary, effects, jobs, scheduler)


def _check_batch(out: Path | None, summary: Path | None, picture: Path | None) -> None:
    if out is None and summary is None:
        raise InvalidInputError("--out and --summary are both missing; name a table to write")
    if picture is not None:
        raise InvalidInputError("--picture is that of one recording without --summary; leave it out")


def _estimate_one(
    name: str,
    observer: ObserverName,
    tuning: ChosenTuning | None,
    out: Path | None,
    rig: Path | None,
    channel_map: str | None,
    model: Path | None,
    effects: Sequence[str] | None,
    ground: Sequence[str] | None,
    smooth: bool,
    picture: Path | None,
) -> None:
    if out is None:
        raise InvalidInputError("Missing option '--out'; it names the table to write")
    image = out.with_suffix(".png") if picture is None else picture
    _check_names(out, image)
    own = user_effects(effects)
    (read,) = on_grounds([_read(name, rig, channel_map)], ground, bare=True)
    require_plausible(read)
    told = beside(out)
    signals = signal_map(rig, channel_map)
    files = files_read([name], signals, effect_files(effects))
    keep_inputs([out, image, told], files, rig, model)
    made = _provenance(files, rig, model, signals, observer, tuning)
    found = None if model is None else read_model(model, effects=own)
    with staged_file(out) as table, staged_file(image) as drawing, staged_file(told) as origin:
        origin.write_text(json_text(made), encoding="utf-8", newline="\n")
        estimates = observe(observer_factory(observer, tuning), read, found, smoothed=smooth)
        table.write_text(estimates_table(estimates), encoding="utf-8", newline="\n")
        label = ("declared model" if found is None else "model found") + ", smoothed" * smooth
        draw_friction(drawing, [friction_track(observer, read, estimates, label)])
    say_ground(read, found)
    say(f"{read.name}: {estimates_summary(estimates)}")
    say(f"wrote {out} and {image}")
    show([row_of(read, estimates)])


def _estimate_many(
    tasks: Sequence[EstimateTask],
    summary: Path | None,
    effects: Sequence[str] | None,
    jobs: int | None,
    scheduler: str | None,
) -> None:
    first = tasks[0]
    tables = [task.out for task in tasks if task.out is not None]
    if summary and any(is_same_file(summary, table) for table in tables):
        raise InvalidInputError(f"{summary}: --summary and --out must name different files")
    told = beside(summary or tables[0])
    outputs = [*tables, *([summary] if summary else []), told]
    files = files_read([str(task.path) for task in tasks], first.signals, effect_files(effects))
    keep_inputs(outputs, files, first.rig, first.model)
    if first.rig is not None:
        read_rig(first.rig)
    if first.model is not None:
        read_model(first.model, effects=user_effects(effects))
    made = _provenance(files, first.rig, first.model, first.signals, first.observer, first.tuning)
    with (
        staged_file(told) as origin,
        staged_file(summary) if summary else nullcontext() as table,
        executor_at(scheduler) as executor,
        progress() as report,
        workers(jobs, user_effects(effects), executor) as submit,
    ):
        origin.write_text(json_text(made), encoding="utf-8", newline="\n")
        rows = estimate_all(tasks, submit, report)
        if table is not None:
            table.write_text(summary_table(rows), encoding="utf-8", newline="\n")
    _say_rows(rows, summary)
    show(rows)
    if faults := [row for row in rows if row["fault"]]:
        raise InvalidInputError(
            f"{len(faults)} of {len(rows)} recordings could not be estimated; the first is"
            f" {faults[0]['recording']}: {faults[0]['fault']}"
        )


def _provenance(
    files: Sequence[Path],
    rig: Path | None,
    model: Path | None,
    signals: SignalMap,
    observer: ObserverName,
    tuning: ChosenTuning | None,
) -> dict[str, Any]:
    settings = {"observer": observer.value, "tuning": None if tuning is None else tuning.to_dict()}
    return provenance_of(files, rig, model, signals.to_dict(), **settings)


def _say_rows(rows: Sequence[Row], summary: Path | None) -> None:
    good = [row for row in rows if not row["fault"]]
    say(f"estimated {len(good)} of {len(rows)} recordings")
    if summary is not None:
        say(f"wrote {summary}")


def _final(out: Path, name: str, count: int) -> Path:
    return out if count == 1 else out.with_stem(f"{out.stem}_{name}")


def _check_names(out: Path, image: Path) -> None:
    if out.suffix.lower() == ".png":
        raise InvalidInputError(f"{out}: the table needs a name such as .csv; .png is its picture")
    check_picture_name(image)


def _read(name: str, rig: Path | None, given_map: str | None) -> Recording:
    """The recording with its aligning or steering torque; without both, the message asks for M_z."""
    (read,) = read_all([name], rig, torque_required=False, causal=True, given_map=given_map)
    if not (has_aligning_torque(read) or has_steering_torque(read)):
        (read,) = read_all([name], rig, causal=True, given_map=given_map)
    return read
