"""When one model is preferred to another: error on judged data, information criterion, paired test."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from identification.fits.autocorrelation import autocorrelation_time, effective_samples
from identification.fits.fitting import Fit, last_effect_at_bound
from identification.fits.least_squares_problem import is_first_torque_zero, shares_of_torque_range
from identification.fits.loss import influence
from identification.reading.recordings import Recording
from identification.residuals.residual_structure import MAX_NOISE_RATIO
from identification.selection.trial import Judgement, Trial, model_of
from symbolic import Effect, InvalidInputError


@dataclass(frozen=True, kw_only=True)
class SelectionCriteria:
    """Every threshold of the search.

    Attributes:
        least_gain: an effect has to lower the judged error by this share [1].
        resolution: it has to explain more than this share of the torque range, the accuracy of the
            discretised patch [1].
        gain_standard_errors: standard errors of the paired test by which that error has to fall [1].
        clear: standard errors by which two models have to differ to be distinguished [1].
        strong: rise of the information criterion that held-out recordings may outweigh; 6 is where
            evidence is strong, see `CLEAR_BIC`, 0 where it has to fall [1].
        block: length of the blocks in which residuals are taken as independent [s].
        long_block: length that outlasts the correlation of a real tyre's residual [s].
        runners_up: candidates fitted to the whole recordings where the best is not confirmed there.
        idle_steps: steps in a row in which a candidate may gain next to nothing before it is left out.
        exchanges: candidates that may replace another effect when no effect can be added.
        further_gain: an effect beside others has to lower the judged error by this share [1].
        law: relative error assumed in the law of an effect; an effect of another family has to explain
            more than this share of what those before it explain [1].
        second_law: the same for a further law of a family that has one in the model [1].
        rough_above: judged error, divided by the torque range, above which 40 bristles and fewer samples
            rank candidates: the least gain that counts there is four times the square of the error that
            those bristles have [1].
    """

    least_gain: float = 0.02
    resolution: float = 5e-4
    gain_standard_errors: float = 1.0
    clear: float = 2.0
    strong: float = 0.0
    block: float = 1.0
    long_block: float = 4.0
    runners_up: int = 2
    idle_steps: int = 2
    exchanges: int = 3
    law: float = 0.15
    further_gain: float = 0.05
    second_law: float = 0.3
    rough_above: float = 0.01

    def __post_init__(self) -> None:
        """Check that no threshold is negative and that blocks and steps are above zero."""
        for name, value in asdict(self).items():
            positive = name in ("block", "long_block", "idle_steps")
            if not (value > 0 if positive else value >= 0):
                least = "greater than 0" if positive else "at least 0"
                raise InvalidInputError(f"criteria: {name} must be {least}, got {value}")


DEFAULT_CRITERIA = SelectionCriteria()


@dataclass(frozen=True, eq=False)
class ComparisonBasis:
    """What two models are compared by."""

    training: Sequence[Recording]  # What both were fitted to.
    criteria: SelectionCriteria
    declared: Trial  # The declared structure on the whole recordings.


CLEAR_BIC = -6.0
"""Change of the information criterion that is strong evidence [Kass 1995]."""
LOAD_CHANGES = 1.01
"""Greatest over least load from which on a load changes [1]."""
WHITE = 1.3
"""Autocorrelation time [samples] that white noise stays below; its estimate is 1.0 to 1.2."""


def forward_step_justified(trial: Trial, present: Trial, by: ComparisonBasis) -> bool:
    """Whether the last effect of a trial is worth adding, or worth the place of others."""
    if len(trial.effects) <= len(present.effects):
        return exchange_justified(trial, present, by)
    added = addition_justified(trial, present, by)
    return added and gain_exceeds_law_error(trial.effects[-1], trial, present, by)


def addition_justified(richer: Trial, present: Trial, by: ComparisonBasis) -> bool:
    """Whether an effect is worth adding: lower judged error, and a lower information criterion.

    The criterion, taken on the training data, may rise by `strong` where held-out recordings show the
    effect clearly. Leaving training recordings out in turn is no evidence beyond the criterion,
    nor is an error that falls because a parameter of a held-out recording is fitted to it.
    """
    criteria = by.criteria
    falls = error_falls(richer.judgement, present.judgement, criteria)
    if not (falls and present.nrmse**2 - richer.nrmse**2 > criteria.resolution**2):
        return False
    mean, error = error_reduction(richer.judgement, present.judgement, criteria.long_block)
    predicted = richer.held_out is not None and sum(richer.fitted.recording_columns) == sum(
        present.fitted.recording_columns
    )
    allowed = criteria.strong if predicted and mean > criteria.clear * error else 0.0
    return delta_bic(richer.fitted, present.fitted, by.training) < allowed


def gain_exceeds_law_error(added: Effect, richer: Trial, present: Trial, by: ComparisonBasis) -> bool:
    """Whether the gain exceeds what slightly wrong laws of the model's effects would leave unexplained.

    Another author's law differs from the library's, and what it leaves must not be read as a further
    mechanism. What is explained is a fall of the squared judged error, from the declared structure on.
    """
    criteria = by.criteria
    if present.effects and not richer.nrmse < (1 - criteria.further_gain) * present.nrmse:
        return False
    structured = present.nrmse > MAX_NOISE_RATIO * richer.nrmse
    if structured and residuals_are_white(richer.fitted, by.training):
        return True
    share = criteria.second_law if family_already_present((*present.effects, added)) else criteria.law
    explained = max(by.declared.nrmse**2 - present.nrmse**2, 0.0)
    return present.nrmse**2 - richer.nrmse**2 > share**2 * explained


def residuals_are_white(fitted: Fit, recordings: Sequence[Recording]) -> bool:
    """Whether the residual of every recording is white: what a wrong law leaves is correlated."""
    shares = shares_of_torque_range(fitted.residuals, recordings).values()
    return all(autocorrelation_time(influence(fitted.loss, share)) < WHITE for share in shares)


def family_already_present(effects: Sequence[Effect]) -> bool:
    """Whether another effect is a law of the last one's family; values of recordings are none."""
    *others, last = (
        None if effect.tare or effect.is_per_recording else effect.family for effect in effects
    )
    return last in {*others} - {None, "other"}


def has_redundant_zero_effects(effects: Sequence[Effect]) -> bool:
    """Whether a torque that was tared stands beside a zero or a starting twist of each recording.

    A torque of memory, such as a drift of the zero, is zero at the first sample and says another thing.
    """
    at_start = (e for e in effects if e.is_per_recording and not e.adds_torque_from_memory)
    return any(e.tare for e in effects) and any(at_start)


def recordings_allow(effect: Effect, present: Sequence[Effect], training: Sequence[Recording]) -> bool:
    """Whether an effect may be tried: a tare begins at zero, a length follows a load that changes."""
    if effect.tare:
        return all(map(is_first_torque_zero, training))
    if effect.of_lengths:
        loads = np.concatenate([recording.F_N for recording in training])
        return bool(loads.max() > LOAD_CHANGES * loads.min())
    if not effect.changes_scopes:
        return True
    # It gives every ground its own values, for which it needs a parameter and two grounds.
    after, before = (model_of(effects).parameters for effects in ((*present, effect), present))
    return after != before and len({recording.ground for recording in training} - {None}) > 1


def backward_step_justified(poorer: Trial, present: Trial, by: ComparisonBasis) -> bool:
    """Whether an effect would not be added any more; a simpler one of its family may replace it."""
    exchanged = len(poorer.effects) == len(present.effects)
    if exchanged and last_effect_at_bound(poorer.fitted):
        return False
    if not addition_justified(present, poorer, by):
        return True
    removed = next(effect for effect in present.effects if effect not in poorer.effects)
    return not (exchanged or gain_exceeds_law_error(removed, present, poorer, by))


def exchange_justified(trial: Trial, present: Trial, by: ComparisonBasis) -> bool:
    """Whether the judged error is lower, and with more parameters the information criterion too."""
    if not error_falls(trial.judgement, present.judgement, by.criteria):
        return False
    larger = len(trial.fitted.labels) > len(present.fitted.labels)
    return not larger or delta_bic(trial.fitted, present.fitted, by.training) < 0


def distinguishable(best: Trial, other: Trial, criteria: SelectionCriteria) -> bool:
    """Whether the judged data distinguish the best trial from another one."""
    mean, error = error_reduction(best.judgement, other.judgement, criteria.block)
    lower = other.nrmse - best.nrmse > criteria.least_gain * best.nrmse
    return mean > criteria.clear * error and lower


def overfits_judging_recordings(trial: Trial, other: Trial, training: Sequence[Recording]) -> bool:
    """Whether a trial's lower error comes from more parameters fitted to the judging recordings."""
    fits_more = sum(trial.fitted.recording_columns) > sum(other.fitted.recording_columns)
    return fits_more and delta_bic(trial.fitted, other.fitted, training) > 0


def error_falls(after: Judgement, before: Judgement, criteria: SelectionCriteria) -> bool:
    """Whether the judged error falls by the least share, and by more than chance."""
    mean, error = error_reduction(after, before, criteria.block)
    lower = after.nrmse < (1 - criteria.least_gain) * before.nrmse
    return lower and mean > criteria.gain_standard_errors * error


def error_reduction(better: Judgement, worse: Judgement, block: float) -> tuple[float, float]:
    """Fall of the mean of (error / range)^2, and its standard error over blocks [s], inf for one."""
    difference = worse.block_errors(block) - better.block_errors(block)
    n = difference.size
    return float(difference.mean()), float(difference.std(ddof=1) / np.sqrt(n)) if n > 1 else np.inf


def cross_term_standard_error(better: Judgement, worse: Judgement, block: float) -> float:
    """Standard error of `error_reduction` from the cross term 2 s r alone.

    r is the residual of the better model and s what it takes off that of the other; squares fall by
    s^2 + 2 s r. s^2 may also vary between blocks, as an effect may act in only a few, and that is not
    chance. The mean of 2 s r over a block is 0 by chance alone; blocks are independent.
    """
    taken = {name: worse.residuals[name] - residual for name, residual in better.residuals.items()}
    squares = (judged.block_errors(block) for judged in (worse, better, replace(worse, residuals=taken)))
    crossed = np.subtract.reduce(list(squares))
    return float(np.linalg.norm(crossed) / crossed.size) if crossed.size > 1 else np.inf


def delta_bic(richer: Fit, poorer: Fit, recordings: Sequence[Recording]) -> float:
    """Change of the Bayesian information criterion from the poorer to the richer model.

    n ln(loss) + p ln(n) with n the effective number of samples of the richer model's residuals, as
    samples 10 ms apart are far from independent. What was declared with a tolerance counts by the
    degrees of freedom that the data decide, see `effective_parameter_count`, and its squared distance
    from the declared value in standard deviations is added. Negative speaks for the richer model.
    """
    shares = shares_of_torque_range(richer.residuals, recordings)
    n = effective_samples({name: influence(richer.loss, share) for name, share in shares.items()})
    gain = np.log(richer.cost(recordings) / poorer.cost(recordings))
    parameters = effective_parameter_count(richer) - effective_parameter_count(poorer)
    distance = float(np.sum(richer.prior_steps**2) - np.sum(poorer.prior_steps**2))
    return float(n * gain + distance + parameters * np.log(n))


def effective_parameter_count(fitted: Fit) -> float:
    """Number of parameters; one declared with a tolerance counts by the share that the data decide.

    The trace of J'J (J'J + W)^-1, W the weights of what was declared: MacKay, Bayesian interpolation,
    Neural Computation 4 (1992) 415, eq. (4.9).
    """
    weights, count = fitted.prior_weights**2, len(fitted.labels)
    if not weights.any():
        return float(count)
    information = fitted.jacobian.T @ fitted.jacobian
    # A column that the data say nothing of still counts as one, as without any tolerance.
    size = np.sqrt(np.maximum(np.diag(information) + weights, 1e-300))
    inverse = np.linalg.pinv((information + np.diag(weights)) / np.outer(size, size), hermitian=True)
    return float(count - np.sum(weights * np.diag(inverse) / size**2))
