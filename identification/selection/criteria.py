"""When an effect is worth having: rules by which the search goes on."""

from collections.abc import Sequence

from identification.reading.recordings import Recording
from identification.selection.scoring import (
    CLEAR,
    LEAST_GAIN,
    LONG_BLOCK,
    RESOLUTION,
    STRONG,
    advantage,
    delta_bic,
    falls_clearly,
)
from identification.selection.trials import Trial


def earns_its_place(trial: Trial, current: Trial, training: Sequence[Recording]) -> bool:
    """Lower judged error by a clear margin, and by the information criterion on the training data.

    That may speak against it, though not strongly, where recordings that were held out speak for it
    clearly. Leaving training recordings out in turn is no evidence beyond the criterion's own, nor is an
    error that falls because something of a held-out recording's own is fitted to it.
    """
    if not falls_clearly(trial.judgement, current.judgement):
        return False
    if not current.nrmse**2 - trial.nrmse**2 > RESOLUTION**2:
        return False
    mean, error = advantage(trial.judgement, current.judgement, LONG_BLOCK)
    foreseen = trial.held_out is not None and _own(trial) == _own(current)
    allowed = STRONG if foreseen and mean > CLEAR * error else 0.0
    return delta_bic(trial.fitted, current.fitted, training) < allowed


def _own(trial: Trial) -> int:
    """Parameters that belong to a recording."""
    return sum(owner is not None for owner, _ in trial.fitted.labels)


def is_better(trial: Trial, current: Trial, training: Sequence[Recording]) -> bool:
    """Lower judged error by a clear margin; more parameters have to be paid for on the training data."""
    if not falls_clearly(trial.judgement, current.judgement):
        return False
    if len(trial.fitted.labels) <= len(current.fitted.labels):
        return True
    return delta_bic(trial.fitted, current.fitted, training) < 0


def tells_apart(best: Trial, other: Trial) -> bool:
    """Whether the judged data can tell the best from another one."""
    mean, error = advantage(best.judgement, other.judgement)
    return mean > CLEAR * error and other.nrmse - best.nrmse > LEAST_GAIN * best.nrmse
