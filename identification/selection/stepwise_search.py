"""The search for the missing effects: stepwise selection, judged on held-out recordings.

Each step adds an effect, or puts a flexible law in place of the others of its family; if none is worth
that, it removes one that the others make superfluous; if there is none, it exchanges one effect for
another; at last it tries the rival of the effect that was added last. An effect that was removed does
not return, so the search ends.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property

from identification.fits.fitting import last_effect_at_bound
from identification.fits.loss import LEAST_SQUARES, Loss
from identification.reading.recordings import Recording
from identification.selection.criteria import (
    DEFAULT_CRITERIA,
    ComparisonBasis,
    SelectionCriteria,
    backward_step_justified,
    distinguishable,
    exchange_justified,
    family_already_present,
    forward_step_justified,
    has_redundant_zero_effects,
    recordings_allow,
)
from identification.selection.search_step import (
    RankedCandidate,
    SearchStep,
    promising_pairs,
    rank_for_confirmation,
    steps_to_pair,
    with_effect,
    without_effect,
)
from identification.selection.trial import RANKING, ROUGH, Trial, with_prior_weights
from identification.selection.trial_journal import Journal
from identification.selection.trial_runner import (
    Effects,
    TrialRunner,
    ignore_progress,
    job_count,
    start_values,
    worker_submitter,
)
from symbolic import CANDIDATES, Effect, effects_named

Progress = Callable[[str, int, int], None]
Justified = Callable[[Trial, Trial, ComparisonBasis], bool]


@dataclass(frozen=True)
class Search:
    """What runs the trials, effects that may be added, thresholds, and what is told of progress."""

    runner: TrialRunner
    candidates: Effects
    criteria: SelectionCriteria
    report: Progress

    @cached_property
    def on_whole(self) -> ComparisonBasis:
        """What fine trials are compared by."""
        return ComparisonBasis(
            self.runner.training, self.criteria, self.runner.run_on_whole_recordings(())
        )

    @cached_property
    def on_thinned(self) -> ComparisonBasis:
        """What coarse trials are compared by."""
        return replace(self.on_whole, training=self.runner.thinned_training)

    def run(self) -> list[SearchStep]:
        """Every step, the last one with nothing chosen."""
        self.report("fitting the declared structure", 0, 1)
        current: Trial | None = self.on_whole.declared
        steps: list[SearchStep] = []
        while current:
            steps.append(self._step(current, steps))
            current = steps[-1].after or self._add_pair(steps)
        return steps

    def _add_pair(self, steps: list[SearchStep]) -> Trial | None:
        """Replace the step in which no effect was worth adding alone by those to a pair, if one is."""
        alone = steps[-1]
        if not (sets := promising_pairs(alone, self.on_thinned.training)):
            return None
        pairs = self._rank(alone, sets, "trying pairs of effects")
        steps[-1:] = steps_to_pair(alone, pairs, self.runner, self.on_thinned, self.on_whole) or [alone]
        return steps[-1].after

    def _step(self, current: Trial, steps: Sequence[SearchStep]) -> SearchStep:
        """Add an effect, else remove one, else exchange one, else nothing."""
        present = self._evaluate_present_model(current)
        active, idle = self._active_and_idle_candidates(current.effects, steps)
        added = self._add(present, active, ())
        # A law that gained nothing before may now do as well as that of its family which was added, one
        # of no family as well as any.
        families = {effect.family for effect in (added.after.effects[-1:] if added.after else idle)}
        if late := [effect for effect in idle if effect.family in families | {"other"}]:
            added = self._add(present, late, added.trials)
        if added.after is not None:
            return added
        return (
            self._remove(present)
            or self._exchange(present, added.trials)
            or self._prefer_rival(present, [*active, *idle], steps, added)
            or added
        )

    def _evaluate_present_model(self, current: Trial) -> SearchStep:
        precision = ROUGH if current.nrmse > self.criteria.rough_above else RANKING
        precision = with_prior_weights(precision, current)
        coarse = self.runner.run_on_thinned_recordings(current.effects, current.values, precision)
        # Weights count samples, of which thinned recordings have fewer.
        precision = with_prior_weights(precision, coarse)
        return SearchStep(before=current, coarse_before=coarse, precision=precision)

    def _active_and_idle_candidates(
        self, present: Effects, steps: Sequence[SearchStep]
    ) -> tuple[list[Effect], list[Effect]]:
        """Candidates to try, and those to try only if none of them is added: idle in the last steps."""
        additions = [step for step in steps if step.removed_effect is None]
        recent = [
            step.low_gain_effects(self.criteria) for step in additions[-self.criteria.idle_steps :]
        ]
        idle = set.intersection(*recent) if len(recent) == self.criteria.idle_steps else set()
        excluded = {*present, *(step.removed_effect for step in steps)}
        training = self.runner.training
        tried = (e for e in self.candidates if e not in excluded)
        allowed = [effect for effect in tried if recordings_allow(effect, present, training)]
        return [e for e in allowed if e not in idle], [e for e in allowed if e in idle]

    def _add(
        self, present: SearchStep, effects: Sequence[Effect], earlier: Sequence[Trial]
    ) -> SearchStep:
        """Add the best of these effects, or of `earlier` trials, that the whole recordings confirm."""
        label = f"trying effects on top of {', '.join(present.before.names) or 'the declared structure'}"
        sets = [with_effect(present.before.effects, effect) for effect in effects]
        trials = [*earlier, *self._rank(present, sets, label)]
        ranked = sorted(trials, key=lambda trial: trial.nrmse)
        justified = [
            t for t in ranked if forward_step_justified(t, present.coarse_before, self.on_thinned)
        ]
        best = rank_for_confirmation(justified, self.on_thinned)
        return present.completed_with(
            self._first_confirmed(best, present, forward_step_justified), ranked
        )

    def _remove(self, present: SearchStep) -> SearchStep | None:
        """Remove an effect, not the last, or put one of its family in place of a flexible law."""
        effects = present.before.effects
        label = f"trying to do without one of {', '.join(present.before.names)}"
        sets = [without_effect(effects, removed) for removed in effects[:-1]]
        sets += [
            (*without_effect(effects, law), member)
            for law in effects
            for member in self.candidates
            if law.flexible and member.family == law.family and member not in effects
        ]
        trials = self._rank(present, sets, label)
        return self._first_confirmed_step(present, trials, backward_step_justified)

    def _exchange(self, present: SearchStep, additions: Sequence[Trial]) -> SearchStep | None:
        """Exchange one effect for one of the candidates that gained most, though not enough."""
        effects = present.before.effects
        least = (1 - self.criteria.least_gain) * present.coarse_before.nrmse
        helpful = [trial.effects[-1] for trial in additions if trial.nrmse < least]
        # Never for a second law of a family: how much more that explains is not tested here.
        sets = [
            exchanged
            for effect in helpful[: self.criteria.exchanges]
            for removed in effects
            if not family_already_present(exchanged := (*without_effect(effects, removed), effect))
        ]
        trials = self._rank(present, sets, f"exchanging one of {', '.join(present.before.names)}")
        return self._first_confirmed_step(present, trials, exchange_justified)

    def _prefer_rival(
        self,
        present: SearchStep,
        candidates: Sequence[Effect],
        steps: Sequence[SearchStep],
        added: SearchStep,
    ) -> SearchStep | None:
        """Replace the last effect by its equal rival if another effect is worth adding beside that."""
        # Which of two equal effects goes on is little more than chance.
        rival = steps[-1].equally_simple_rival if steps else None
        if rival is None or rival not in candidates:
            return None
        *others, chosen = present.before.effects
        effects = (*others, rival)
        if family_already_present(effects):
            return None
        sets = [
            (*effects, e) for e in candidates if e not in {rival, *added.low_gain_effects(self.criteria)}
        ]
        trials = self._rank(present, sets, f"trying {rival.name} in place of {chosen.name}")
        found = self._first_confirmed_step(present, trials, exchange_justified)
        if found is None or found.after is None:
            return None
        after = self.runner.run_on_whole_recordings(effects, start_values(found.after, effects))
        return replace(found, after=after)

    def _first_confirmed_step(
        self, present: SearchStep, trials: Sequence[Trial], justified: Justified
    ) -> SearchStep | None:
        """The step to the first of these models that is confirmed, None where none is."""
        best = [
            RankedCandidate(t) for t in trials if justified(t, present.coarse_before, self.on_thinned)
        ]
        confirmed = self._first_confirmed(best, present, justified)
        return present.completed_with(confirmed, trials) if confirmed else None

    def _rank(self, present: SearchStep, sets: Sequence[Effects], label: str) -> list[Trial]:
        """Coarse trials of these sets of effects, least judged error first."""
        if not (sets := [effects for effects in sets if not has_redundant_zero_effects(effects)]):
            return []
        return self.runner.rank(
            present.coarse_before,
            sets,
            present.precision,
            lambda done: self.report(label, done, len(sets)),
        )

    def _first_confirmed(
        self, best: Sequence[RankedCandidate], present: SearchStep, justified: Justified
    ) -> RankedCandidate | None:
        """The first candidate that is justified on the whole recordings too, with its trial on these."""
        # One with a parameter at the end of its range gives way to another one that does as well.
        at_bound: RankedCandidate | None = None
        for candidate in best[: 1 + self.criteria.runners_up]:
            after = self.runner.run_on_whole_recordings(candidate.trial.effects, candidate.trial.values)
            if not justified(after, present.before, self.on_whole):
                continue
            if at_bound and distinguishable(at_bound.trial, after, self.criteria):
                continue
            confirmed = replace(candidate, trial=after)
            if not last_effect_at_bound(after.fitted):
                return confirmed
            at_bound = at_bound or confirmed
        return at_bound


def search(
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    candidates: Iterable[str | Effect] = tuple(CANDIDATES),
    criteria: SelectionCriteria = DEFAULT_CRITERIA,
    loss: Loss = LEAST_SQUARES,
    journal: Journal | None = None,
) -> list[SearchStep]:
    """Add effects one at a time, remove those that become superfluous; the last step chooses nothing.

    Candidates are ranked on thinned recordings with coarse fits; the best are fitted again to the whole
    recordings, where they have to be confirmed. A candidate that gained next to nothing in the last
    steps is left out, then tried once more before an effect is removed, and where a law of its family is
    added, or any where it has none.

    The shared parameters are fitted to the training recordings; the held-out ones judge, or the training
    recordings left out in turn where there are none. The other arguments are those of `diagnose`.

    Raises:
        InvalidInputError: a candidate is unknown, named twice, or processes cannot import its class.
        BrushgripError: a process ended before its work was done.
    """
    effects, count = effects_named(candidates), job_count(jobs)
    with worker_submitter(jobs, effects, executor) as submit:
        runner = TrialRunner(
            training=training, holdout=holdout, loss=loss, submit=submit, journal=journal, threads=count
        )
        return Search(runner, effects, criteria, progress or ignore_progress).run()
