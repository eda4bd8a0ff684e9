"""A step of the search: what was tried, what was chosen, and what would have done as well."""

from dataclasses import dataclass

from identification.fits.values import Values
from identification.selection.criteria import SelectionCriteria
from identification.selection.trial_runner import Effects
from identification.selection.trials import Trial
from symbolic import Effect


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchStep:
    """One step of the search.

    Attributes:
        before: the model before it.
        coarse_before: the same, fitted as coarsely as the candidates that it was compared with.
        trials: of the models with one effect more or less, least judged error first, coarsely fitted.
        after: the model after it; None in the last step.
        indistinguishable: effects that would have done as well as the one that was added.
        with_neither: where an effect took another one's place, the model with neither; else None.
    """

    before: Trial
    coarse_before: Trial
    trials: tuple[Trial, ...]
    after: Trial | None
    indistinguishable: Effects = ()
    with_neither: Trial | None = None

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
    def equal_rival(self) -> Effect | None:
        """The best of the effects that would have done as well for as few parameters, if any."""
        if self.after is None or not self.indistinguishable:
            return None
        sizes = {trial.effects[-1]: len(trial.fitted.labels) for trial in self.trials}
        most = sizes[self.after.effects[-1]]
        return next((e for e in sizes if e in self.indistinguishable and sizes[e] <= most), None)

    def values_of(self, effects: Effects) -> Values:
        """The values fitted in the trial of these effects."""
        return next(t.fitted.values for t in self.trials if set(t.effects) == set(effects))

    def idle(self, criteria: SelectionCriteria) -> set[Effect]:
        """Effects that lowered the judged error by less than half of what is needed."""
        least = (1 - criteria.least_gain / 2) * self.coarse_before.nrmse
        return {trial.effects[-1] for trial in self.trials if trial.nrmse > least}
