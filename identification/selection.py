"""The search for the missing effects: forward selection, judged on recordings that were held out."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np

from identification.fitting import COARSE, TOLERANCE, Fit, Values, first_values, fit
from identification.recordings import Recording
from identification.scoring import Judgement, advantage, delta_bic, judged, leave_one_out
from symbolic import EFFECTS, Model, effects_named

CORNERS = 16
"""Zone corners kept in identification; beyond this depth they carry less than 1e-6 of the torque."""
LEAST_GAIN = 0.02
"""An effect has to lower the judged error by this share to be named."""
RESOLUTION = 5e-4
"""It has to explain more than this of the range, the accuracy of the discretised patch."""
IDLE_STEPS = 2
"""Steps in which a candidate may do next to nothing before it is left out."""
RANKING_STEP = 0.02
"""Recordings are thinned towards this time between samples while candidates are ranked [s]."""
EARNED, CLEAR = 1.0, 2.0
"""Standard errors on the judged data by which an effect has to help, and two have to differ to be told
apart."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """A model fitted to the training recordings and judged.

    Attributes:
        effects: names of its effects, in order of selection.
        fitted: the fit on the training recordings.
        held_out: the fit of what belongs to each held-out recording; None without any.
        judgement: how it does on the recordings by which it is judged.
    """

    effects: tuple[str, ...]
    fitted: Fit
    held_out: Fit | None
    judgement: Judgement

    @property
    def nrmse(self) -> float:
        """The judged error over range [1]."""
        return self.judgement.nrmse


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """One step of the search.

    Attributes:
        before: the model before it.
        ranked_before: the same as the candidates were compared with, coarsely fitted.
        tried: what was tried on top, best first, coarsely fitted.
        chosen: the model after it; None in the last step.
        indistinguishable: effects that would have done as well as the chosen one.
    """

    before: Trial
    ranked_before: Trial
    tried: tuple[Trial, ...]
    chosen: Trial | None
    indistinguishable: tuple[str, ...]

    def idle(self) -> set[str]:
        """Effects that lowered the judged error by less than half of what is needed."""
        least = (1 - LEAST_GAIN / 2) * self.ranked_before.nrmse
        return {trial.effects[-1] for trial in self.tried if trial.nrmse > least}


def model_of(effects: Sequence[str]) -> Model:
    """The model with these effects as the search uses it."""
    return Model(effects=effects_named(effects), corners=CORNERS)


def attempt(
    effects: Sequence[str],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    start: Values | None = None,
    tolerance: float = TOLERANCE,
) -> Trial:
    """Fit a model and judge it.

    With held-out recordings every shared parameter stays frozen on them. Without, each training
    recording is left out in turn (two or more of them), and the judged errors are those.
    """
    model = model_of(effects)
    begin = start or first_values(model, training)
    fitted = fit(model, training, begin, tolerance=tolerance)
    if holdout:
        held_out = freeze(fitted, holdout, tolerance)
        return Trial(
            effects=tuple(effects),
            fitted=fitted,
            held_out=held_out,
            judgement=judged(held_out.residuals, holdout),
        )
    judgement = judged(leave_one_out(fitted, training), training)
    return Trial(effects=tuple(effects), fitted=fitted, held_out=None, judgement=judgement)


def thinned(recording: Recording) -> Recording:
    """Every so many samples of a recording, such that they are at most `RANKING_STEP` apart.

    The patch is rate-independent: between reversals it does not matter how often it is looked at. A
    recording with missing torques stays as it is.
    """
    if not np.isfinite(recording.M_z).all():
        return recording
    stride = max(1, int(RANKING_STEP / float(np.diff(recording.t).max()) + 1e-6))
    arrays = ("t", "psi", "psi_dot", "M_z", "F_N")
    return replace(recording, M=None, **{name: getattr(recording, name)[::stride] for name in arrays})


def freeze(fitted: Fit, recordings: Sequence[Recording], tolerance: float = TOLERANCE) -> Fit:
    """Fit only what belongs to these recordings, with the shared parameters of `fitted`."""
    own = first_values(fitted.model, recordings).own
    start = Values(shared=fitted.values.shared, own=own)
    return fit(fitted.model, recordings, start, free_shared=False, tolerance=tolerance)


def search(
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
    candidates: Sequence[str] = tuple(EFFECTS),
) -> list[Step]:
    """Add effects one at a time until none earns its place; the last step has nothing chosen.

    Candidates are ranked on thinned recordings with coarse fits; what is chosen is fitted again on
    everything. A candidate that did next to nothing in two steps running is not tried a third time.

    Args:
        training: recordings that the shared parameters are fitted to.
        holdout: recordings that judge; empty for leave-one-out over the training ones.
        jobs: processes to use; None for one per core.
        progress: called with what is being done, trials done, and trials in this step.
        candidates: names of the effects that may be picked.
    """
    report = progress or _silent
    report("fitting the declared structure", 0, 1)
    thin = [thinned(r) for r in training], [thinned(r) for r in holdout]
    ranked, current = attempt((), *thin, None, COARSE), attempt((), training, holdout)
    steps: list[Step] = []
    with _workers(jobs) as submit:
        while True:
            tried = _try_all(ranked, _remaining(candidates, steps), thin, submit, report)
            leader, others = _leader(ranked, tried, thin[0])
            chosen = None
            if leader is not None:
                whole = attempt(leader.effects, training, holdout, leader.fitted.values)
                # What was ranked on thinned recordings has to hold on the whole ones.
                chosen = whole if _earns_its_place(whole, current, training) else None
            steps.append(
                Step(
                    before=current,
                    ranked_before=ranked,
                    tried=tuple(tried),
                    chosen=chosen,
                    indistinguishable=others if chosen else (),
                )
            )
            if leader is None or chosen is None:
                return steps
            ranked, current = leader, chosen


def _remaining(candidates: Sequence[str], steps: Sequence[Step]) -> list[str]:
    """The candidates not chosen yet, less those that were idle in the last two steps."""
    chosen = [] if not steps or steps[-1].chosen is None else steps[-1].chosen.effects
    idle: set[str] = set()
    if len(steps) >= IDLE_STEPS:
        idle = set.intersection(*(step.idle() for step in steps[-IDLE_STEPS:]))
    return [name for name in candidates if name not in chosen and name not in idle]


def _try_all(
    ranked: Trial,
    names: Sequence[str],
    thin: tuple[Sequence[Recording], Sequence[Recording]],
    submit: Callable[..., Future[Trial]],
    report: Progress,
) -> list[Trial]:
    """Every candidate on top of the present model, best first."""
    label = f"trying effects on top of {', '.join(ranked.effects) or 'the declared structure'}"
    report(label, 0, len(names))
    # The heaviest first, so that no core waits for one of them at the end.
    sets = sorted(
        ((*ranked.effects, name) for name in names), key=lambda effects: -model_of(effects).memory_size
    )
    futures = [submit(attempt, effects, *thin, ranked.fitted.values, COARSE) for effects in sets]
    for done, _ in enumerate(as_completed(futures), start=1):
        report(label, done, len(names))
    return sorted((future.result() for future in futures), key=lambda trial: trial.nrmse)


def _leader(
    ranked: Trial, tried: Sequence[Trial], training: Sequence[Recording]
) -> tuple[Trial | None, tuple[str, ...]]:
    """The candidate that goes on, and the effects that would have done as well.

    The best that earns its place, or the one with the fewest parameters among those that cannot be told
    from it.
    """
    worthy = [trial for trial in tried if _earns_its_place(trial, ranked, training)]
    if not worthy:
        return None, ()
    equals = [trial for trial in worthy if not _tells_apart(worthy[0], trial)]
    leader = min(equals, key=lambda trial: (len(trial.fitted.labels), trial.nrmse))
    return leader, tuple(trial.effects[-1] for trial in equals if trial is not leader)


def _silent(message: str, done: int, total: int) -> None:
    del message, done, total


def _earns_its_place(trial: Trial, current: Trial, training: Sequence[Recording]) -> bool:
    """Lower judged error by a clear margin, and by the information criterion on the training data."""
    if not trial.nrmse < (1 - LEAST_GAIN) * current.nrmse:
        return False
    if not current.nrmse**2 - trial.nrmse**2 > RESOLUTION**2:
        return False
    mean, error = advantage(trial.judgement, current.judgement)
    if not mean > EARNED * error:
        return False
    return delta_bic(trial.fitted, current.fitted, training) < 0


def _tells_apart(best: Trial, other: Trial) -> bool:
    mean, error = advantage(best.judgement, other.judgement)
    return mean > CLEAR * error and other.nrmse - best.nrmse > LEAST_GAIN * best.nrmse


@contextmanager
def _workers(jobs: int | None) -> Iterator[Callable[..., Future[Trial]]]:
    """A way to submit trials: processes, or this process alone for one job."""
    count = jobs or os.cpu_count() or 1
    if count == 1:
        yield _at_once
        return
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        yield pool.submit


def _at_once(function: Callable[..., Trial], *arguments: Any) -> Future[Trial]:
    future: Future[Trial] = Future()
    future.set_result(function(*arguments))
    return future
