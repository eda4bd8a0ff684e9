"""Diagnosis: residual of the declared model, effects that it lacks, errors before and after."""

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from identification.diagnosis.from_search import build_diagnosis, note_slide_beyond_sensor
from identification.diagnosis.graded_effects import assumed_tolerances_note
from identification.diagnosis.result import Diagnosis
from identification.diagnosis.torque_errors_by_stage import declared_errors, left_out_residuals
from identification.experiments.discriminating_experiment import propose
from identification.experiments.model_separation import Proposal
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.fits.single_threaded_blas import one_thread
from identification.fits.values_by_ground_and_recording import grounds_of
from identification.reading.car_torques_beside_tyres import widest_standstill_less_gear
from identification.reading.declared_sensor_range import (
    drop_torques_beyond_range,
    torque_beyond_range_note,
)
from identification.reading.recordings import Recording
from identification.reading.trimming_and_thinning import thin_recordings
from identification.residuals.partial_correlations import signatures
from identification.residuals.residual_signals import check_signatures
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from identification.selection.search_step import SearchStep, begin_trials_without_each
from identification.selection.stepwise_search import Progress, Search
from identification.selection.trial import RANKING
from identification.selection.trial_journal import Journal
from identification.selection.trial_runner import (
    Effects,
    TrialRunner,
    ignore_progress,
    job_count,
    results_of,
    worker_submitter,
)
from symbolic import CANDIDATES, Effect, InvalidInputError, effects_named, with_usual_tolerances

MIN_ANGLE_RANGE = 0.01
"""Least range of the angle that a diagnosis needs [rad]."""


@one_thread
def diagnose(
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    *,
    candidates: Iterable[str | Effect] = tuple(CANDIDATES),
    criteria: SelectionCriteria = DEFAULT_CRITERIA,
    loss: Loss = LEAST_SQUARES,
    jobs: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    journal: Journal | None = None,
) -> Diagnosis:
    """Find the effects that the declared model lacks.

    Of recordings with more than `MAX_SEARCH_SAMPLES` together fewer are used. Half-length, caster, load
    and k without a tolerance have that of `symbolic.USUAL`; 0 makes them exact. Notes say both.

    Args:
        recordings: training recordings; shared parameters are fitted to these alone.
        holdout: recordings that judge. No shared parameter is fitted to them; only mu, torque zero
            and its drift, starting twist, a, e and load are. Without any, training recordings are left
            out in turn.
        candidates: effects that the search may add: names of the library's, or effects of your own.
        criteria: thresholds of the search.
        loss: what a residual costs; `Huber` where the torque has outliers.
        jobs: processes for the search; None for one per core.
        executor: takes the work in place of these, such as a `ProcessPoolExecutor` or that of a Dask
            cluster; in threads nothing goes faster. The result is the same to the last digit.
        progress: called with (what is being done, trials done, trials in this step).
        journal: where trials are kept, so that an interrupted search can go on; None for nowhere.

    Raises:
        InvalidInputError: no recording, a name stands twice, a torque is constant, or a candidate is
            unknown, named twice, declares a signature of an unknown signal, or is of a class that the
            processes cannot import.
        BrushgripError: a process ended before its work was done.
    """
    as_read = [*recordings, *holdout]
    recordings, holdout, notes = _prepare_recordings_and_notes(recordings, holdout)
    effects, most, report = effects_named(candidates), job_count(jobs), progress or ignore_progress
    check_signatures(effects)
    with worker_submitter(jobs, effects, executor) as submit:
        runner = TrialRunner(
            training=recordings, holdout=holdout, loss=loss, submit=submit, journal=journal, threads=most
        )
        # Nothing of the search goes into it, and the processes have nothing else to do yet.
        declared = submit(declared_errors, recordings, holdout, loss)
        search = Search(runner, effects, criteria, report)
        steps = search.run()
        rests = begin_trials_without_each(steps, runner)
        proposals = _nearest_rival_proposals(search, steps)
        trials, both = (steps[0].before, steps[-1].before), [*recordings, *holdout]
        followed = [submit(signatures, trial.residuals, both, trial.fits, effects) for trial in trials]
        if not holdout:
            report("leaving each recording out in turn", 0, 1)
        left_out = [left_out_residuals(trial, runner) for trial in trials]
        results = rests(), declared.result(), [future.result() for future in followed]
    result = build_diagnosis(search, steps, *results, left_out, proposals)
    notes += note_slide_beyond_sensor(result.model, result.values, as_read)
    return replace(result, notes=(*notes, *result.notes), of_car=bool(recordings[0].standstills))


def _prepare_recordings_and_notes(
    recordings: Sequence[Recording], holdout: Sequence[Recording]
) -> tuple[list[Recording], list[Recording], list[str]]:
    """Both as the search takes them, and notes on what was changed."""
    beyond = torque_beyond_range_note([*recordings, *holdout])
    bound, shortened = thin_recordings([drop_torques_beyond_range(r) for r in (*recordings, *holdout)])
    stood = [widest_standstill_less_gear(recording) for recording in bound]
    everything = [recording for recording, _ in stood]
    _require_usable_recordings(recordings, everything)
    notes = [shortened, *(note for _, note in stood), assumed_tolerances_note(everything), beyond]
    read = [replace(r, rig=with_usual_tolerances(r.rig)) for r in everything]
    return read[: len(recordings)], read[len(recordings) :], list(filter(None, notes))


def _require_usable_recordings(recordings: Sequence[Recording], everything: Sequence[Recording]) -> None:
    if not recordings:
        raise InvalidInputError("no recording given; at least one is needed")
    names = [r.name for r in everything]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInputError(f"recording {name!r} is given twice; every recording counts once")
    grounds_of(everything)
    for recording in everything:
        torque_range(recording)
        travel = float(np.ptp(recording.psi))
        if not travel > MIN_ANGLE_RANGE:
            raise InvalidInputError(
                f"{recording.name}: the wheel turns by {travel:.2g} rad only; a diagnosis needs a"
                f" recording in which it turns by more than {MIN_ANGLE_RANGE} rad"
            )


def _nearest_rival_proposals(search: Search, steps: Sequence[SearchStep]) -> dict[Effects, Proposal]:
    """For each set of effects that was chosen, the experiment to tell it from its nearest rival."""
    starts = []
    for step in steps:
        if step.after and step.indistinguishable:
            nearest = (*step.before.effects, step.nearest_rival)
            starts += [(effects, step.values_of(effects)) for effects in (step.after.effects, nearest)]
    if not starts:
        return {}
    label, runner = "looking for an experiment that separates rivals", search.runner
    trials = runner.run_all_on_thinned(
        starts, RANKING, lambda done: search.report(label, done, len(starts))
    )
    fits = [trial.fitted for trial in trials]
    futures = {
        effects: runner.submit(propose, found, rival, runner.thinned_training, search.criteria)
        for (effects, _), found, rival in zip(starts[::2], fits[::2], fits[1::2], strict=True)
    }
    return results_of(futures)
