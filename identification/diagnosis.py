"""Close the loop: residual of the declared model, effects that it lacks, errors before and after."""

from collections.abc import Sequence

import numpy as np

from identification.build_diagnosis import verdict
from identification.error_stages import left_out_errors
from identification.experiments.discriminating_experiment import propose
from identification.experiments.proposals import Proposal
from identification.fits.fitting import torque_range
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.reading.recordings import Recording
from identification.results import Diagnosis
from identification.selection.journal import Journal
from identification.selection.stepwise_search import Progress, Step, silent, walk
from identification.selection.trial_runner import Attempts, Effects
from identification.selection.trials import RANKING, Trial
from identification.selection.workers import Submit, workers
from symbolic import InvalidInputError

LEAST_TRAVEL = 0.01
"""Greatest minus least angle that a diagnosis needs [rad]."""


def diagnose(
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    *,
    loss: Loss = LEAST_SQUARES,
    jobs: int | None = None,
    progress: Progress | None = None,
    journal: Journal | None = None,
) -> Diagnosis:
    """Find what the declared model lacks.

    Args:
        recordings: training recordings; shared parameters are fitted to these alone.
        holdout: recordings that judge. Every shared parameter stays frozen on them; only mu, torque
            zero and starting twist are refitted. Without any, training recordings are left out in turn.
        loss: what a residual costs; `Huber` where the torque has outliers.
        jobs: processes for the search; None for one per core.
        progress: called with (what is being done, trials done, trials in this step).
        journal: where trials are kept, so that a search that was interrupted goes on; None for nowhere.

    Raises:
        InvalidInputError: no recording, a name stands twice, or a torque is constant.
    """
    everything = [*recordings, *holdout]
    _check(recordings, everything)
    report = progress or silent
    with workers(jobs) as submit:
        made = Attempts(training=recordings, holdout=holdout, loss=loss, submit=submit, journal=journal)
        steps = walk(made, report)
        trials = steps[0].before, steps[-1].before
        left_out = [_left_out(trial, recordings, holdout, submit, report) for trial in trials]
        proposals = _proposals(steps, made, report)
    report("looking at what is left", 0, 1)
    return verdict(steps, recordings, holdout, left_out, proposals)


def _check(recordings: Sequence[Recording], everything: Sequence[Recording]) -> None:
    if not recordings:
        raise InvalidInputError("no recording given; at least one is needed")
    names = [r.name for r in everything]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInputError(f"recording {name!r} is given twice; every recording counts once")
    for recording in everything:
        torque_range(recording)
        travel = float(np.ptp(recording.psi))
        if not travel > LEAST_TRAVEL:
            raise InvalidInputError(
                f"{recording.name}: the wheel turns by {travel:.2g} rad only; a diagnosis needs a"
                f" recording in which it turns by more than {LEAST_TRAVEL} rad"
            )


def _left_out(
    trial: Trial,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording],
    submit: Submit,
    report: Progress,
) -> dict[str, float]:
    """Errors with each recording left out in turn, where none is held out."""
    if holdout:
        return {}
    report("leaving each recording out in turn", 0, 1)
    return left_out_errors(trial, recordings, submit)


def _proposals(steps: Sequence[Step], made: Attempts, report: Progress) -> dict[Effects, Proposal]:
    """For each set of effects that was chosen, the experiment that tells it from its nearest rival."""
    wanted = []
    for step in steps:
        if step.chosen and step.indistinguishable:
            nearest = (*step.before.effects, step.nearest_rival)
            wanted += [(effects, step.start_of(effects)) for effects in (step.chosen.effects, nearest)]
    if not wanted:
        return {}
    label = "looking for an experiment that separates rivals"
    trials = made.together(wanted, RANKING, lambda done: report(label, done, len(wanted)))
    fits = [trial.fitted for trial in trials]
    waiting = {
        effects: made.submit(propose, found, rival, made.thin_training)
        for (effects, _), found, rival in zip(wanted[::2], fits[::2], fits[1::2], strict=True)
    }
    return {effects: future.result() for effects, future in waiting.items()}
