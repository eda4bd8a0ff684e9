"""Two effects that are worth adding together where no effect is worth adding alone."""

from collections.abc import Sequence
from dataclasses import replace

from identification.reading.recordings import Recording
from identification.selection.criteria import (
    Comparison,
    delta_bic,
    error_reduction,
    family_already_present,
    forward_step_justified,
)
from identification.selection.search_step import SearchStep, rank_for_confirmation
from identification.selection.trial import Trial
from identification.selection.trial_runner import Effects, TrialRunner, start_values

DEMANDED, FIRSTS = -6.0, 2
"""Change of the information criterion that is strong evidence (Kass and Raftery, JASA 90 (1995) 773);
most effects with such a change that partners are sought for."""
CLEAR = 3.0
"""Standard errors by which the judged error has to fall, as every pair is one more chance."""


def promising_pairs(alone: SearchStep, training: Sequence[Recording]) -> list[Effects]:
    """Pairs to try: an effect that the fitted recordings demand, alone, with each of the others.

    Those that judge do not confirm such an effect: it may take along what its partner would explain.
    """
    present = alone.before.effects
    changes = {
        t.effects[-1]: delta_bic(t.fitted, alone.coarse_before.fitted, training)
        for t in alone.trials
        if t.effects[:-1] == present and not family_already_present(t.effects)
    }
    firsts = sorted((e for e in changes if changes[e] < DEMANDED), key=lambda e: changes[e])[:FIRSTS]
    pairs = [
        (*present, first, e)
        for i, first in enumerate(firsts)
        for e in changes
        if e not in firsts[: i + 1]
    ]
    return [pair for pair in pairs if not family_already_present(pair)]


def steps_to_pair(
    single_step: SearchStep,
    pair_trials: Sequence[Trial],
    runner: TrialRunner,
    on_thinned: Comparison,
    on_whole: Comparison,
) -> list[SearchStep]:
    """Steps to the first pair of these coarse trials that is clear on the whole recordings, if any is.

    The first is `single_step`, in which no effect alone was worth adding; the gain of each effect is
    that beside the other.
    """
    before = single_step.before
    justified = [
        p for p in pair_trials if forward_step_justified(p, single_step.coarse_before, on_thinned)
    ]
    # Those with the same first effect are compared as candidates beside it.
    beside = [pair for pair in justified if pair.effects[-2] == justified[0].effects[-2]]
    ranked = rank_for_confirmation(beside, on_thinned)
    for candidate in ranked[: 1 + on_whole.criteria.runners_up]:
        pair = candidate.trial
        both = runner.run_fine(pair.effects, pair.values)
        mean, error = error_reduction(both.judgement, before.judgement, on_whole.criteria.long_block)
        if not forward_step_justified(both, before, on_whole) or mean <= CLEAR * error:
            continue
        *present, one, other = pair.effects
        first, second = (*present, one), (*present, other)
        alone_first = runner.run_fine(first, start_values(both, first))
        alone_second = runner.run_fine(second, start_values(both, second))
        turned = runner.run_fine((*second, one), both.values)
        step = replace(single_step, trials=tuple(pair_trials))
        return [
            single_step,
            replace(step, before=alone_second, after=turned),
            replace(step, before=alone_first, after=both, indistinguishable=candidate.indistinguishable),
        ]
    return []
