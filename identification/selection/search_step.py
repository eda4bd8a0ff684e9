"""A step of the search: models that it may go to, what was tried, chosen, and does as well.

Where no effect is worth adding alone, two may be worth adding together.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from identification.fits.fitting import last_effect_at_bound
from identification.fits.values_by_ground_and_recording import Values
from identification.reading.recordings import Recording
from identification.selection.criteria import (
    CLEAR_BIC,
    ComparisonBasis,
    SelectionCriteria,
    delta_bic,
    distinguishable,
    error_reduction,
    family_already_present,
    forward_step_justified,
    overfits_judging_recordings,
)
from identification.selection.trial import RANKING, Precision, Trial
from identification.selection.trial_runner import Effects, TrialRunner, start_values
from symbolic import Effect

FIRSTS = 2
"""Most effects with clear evidence by the information criterion that partners are sought for."""
CLEAR_OF_PAIR = 3.0
"""Standard errors by which the judged error has to fall, as every pair is one more chance."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchStep:
    """One step of the search, from a model to the one after it, None in the last step."""

    before: Trial
    coarse_before: Trial  # The same, fitted as coarsely as the candidates that it was compared with.
    precision: Precision = RANKING  # Of these coarse fits.
    trials: tuple[Trial, ...] = ()  # One effect more or less, least judged error first, coarsely fitted.
    after: Trial | None = None
    indistinguishable: Effects = ()  # Effects that would have done as well as the one that was added.

    @property
    def removed_effect(self) -> Effect | None:
        """The effect that was removed or exchanged; None where there is none."""
        kept = self.after.effects if self.after else self.before.effects
        return next((effect for effect in self.before.effects if effect not in kept), None)

    @property
    def nearest_rival(self) -> Effect:
        """Of the effects that would have done as well, the one with the least judged error."""
        ranked = (trial.effects[-1] for trial in self.trials)
        return next(effect for effect in ranked if effect in self.indistinguishable)

    @property
    def equally_simple_rival(self) -> Effect | None:
        """The best of the effects that would have done as well for as few parameters, if any."""
        if self.after is None or not self.indistinguishable:
            return None
        sizes = {trial.effects[-1]: len(trial.fitted.labels) for trial in self.trials}
        most = sizes[self.after.effects[-1]]
        return next((e for e in sizes if e in self.indistinguishable and sizes[e] <= most), None)

    def completed_with(
        self, confirmed: "RankedCandidate | None", trials: Sequence[Trial]
    ) -> "SearchStep":
        """The step to what was confirmed of these trials, if anything was."""
        tried = replace(self, trials=tuple(trials))
        if confirmed is None:
            return tried
        return replace(tried, after=confirmed.trial, indistinguishable=confirmed.indistinguishable)

    def values_of(self, effects: Effects) -> Values:
        """The values fitted in the trial of these effects."""
        return next(t.fitted.values for t in self.trials if set(t.effects) == set(effects))

    def low_gain_effects(self, criteria: SelectionCriteria) -> set[Effect]:
        """Effects that lowered the judged error by less than half of what is needed."""
        least = (1 - criteria.least_gain / 2) * self.coarse_before.nrmse
        return {trial.effects[-1] for trial in self.trials if trial.nrmse > least}


@dataclass(frozen=True)
class RankedCandidate:
    """A model that coarse trials propose, and the effects that would do as well as its last one."""

    trial: Trial
    indistinguishable: Effects = ()


def with_effect(effects: Effects, effect: Effect) -> Effects:
    """The effects and another one; a flexible law takes the place of the others of its family."""
    kept = [e for e in effects if not (effect.flexible and e.family == effect.family)]
    return (*kept, effect)


def without_effect(effects: Effects, removed: Effect) -> Effects:
    """The effects but for one."""
    return tuple(effect for effect in effects if effect != removed)


def rank_for_confirmation(justified: Sequence[Trial], by: ComparisonBasis) -> list[RankedCandidate]:
    """Candidates in the order in which they should be confirmed.

    Take the best trial that does not overfit the judging recordings. Of it and all trials
    indistinguishable from it, the one with the fewest parameters comes first. Repeat with the rest. A
    trial with a parameter at the end of its range, or with a second law of its family, comes after
    others as good. A flexible law is no rival of a law of its family.
    """
    ranked, rest = [], list(justified)
    while rest:
        best = next(
            t for t in rest if not any(overfits_judging_recordings(t, one, by.training) for one in rest)
        )
        equals = [trial for trial in rest if not distinguishable(best, trial, by.criteria)]
        leader = min(equals, key=_simplicity)
        own = leader.effects[-1].family
        rivals = (trial.effects[-1] for trial in equals if trial is not leader)
        others = tuple(e for e in rivals if not (e.flexible and e.family == own))
        ranked.append(RankedCandidate(leader, others))
        rest.remove(leader)
    return ranked


def _simplicity(trial: Trial) -> tuple[bool, bool, int, float]:
    """Order of models that judge alike, the one to prefer first: a family has one law."""
    return (
        last_effect_at_bound(trial.fitted),
        family_already_present(trial.effects),
        len(trial.fitted.labels),
        trial.nrmse,
    )


def begin_trials_without_each(
    steps: Sequence[SearchStep], runner: TrialRunner
) -> Callable[[], dict[Effect, Trial]]:
    """The final model without each of its effects, fitted to the whole recordings.

    The processes begin with it; what is returned waits for them.
    """
    final = steps[-1].before
    exact = final.fitted.model.uses_exact_patch
    known = {
        frozenset(s.before.effects): s.before
        for s in steps
        if s.before.fitted.model.uses_exact_patch == exact
    }
    rests = {effect: without_effect(final.effects, effect) for effect in final.effects}
    missing = {e: rest for e, rest in rests.items() if frozenset(rest) not in known}
    # Bristles as in the final model: quicker, and their error does not count as an effect's.
    finish = runner.begin_on_whole_recordings(
        {effect: (rest, start_values(final, rest)) for effect, rest in missing.items()},
        Precision(discretised=not exact),
    )

    def trials() -> dict[Effect, Trial]:
        fitted = finish()
        return {e: fitted.get(e) or known[frozenset(rest)] for e, rest in rests.items()}

    return trials


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
    firsts = sorted((e for e in changes if changes[e] < CLEAR_BIC), key=lambda e: changes[e])[:FIRSTS]
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
    on_thinned: ComparisonBasis,
    on_whole: ComparisonBasis,
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
        both = runner.run_on_whole_recordings(pair.effects, pair.values)
        mean, error = error_reduction(both.judgement, before.judgement, on_whole.criteria.long_block)
        if not forward_step_justified(both, before, on_whole) or mean <= CLEAR_OF_PAIR * error:
            continue
        *present, one, other = pair.effects
        first, second = (*present, one), (*present, other)
        alone_first = runner.run_on_whole_recordings(first, start_values(both, first))
        alone_second = runner.run_on_whole_recordings(second, start_values(both, second))
        turned = runner.run_on_whole_recordings((*second, one), both.values)
        step = replace(single_step, trials=tuple(pair_trials))
        return [
            single_step,
            replace(step, before=alone_second, after=turned),
            replace(step, before=alone_first, after=both, indistinguishable=candidate.indistinguishable),
        ]
    return []
