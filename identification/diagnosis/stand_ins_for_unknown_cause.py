"""Effects of the model found that may stand in for something unknown."""

from collections.abc import Mapping, Sequence

import numpy as np

from identification.fits.fitting import parameters_at_bounds
from identification.fits.least_squares_problem import shares_of_torque_range
from identification.fits.loss import influence
from identification.reading.recordings import Recording
from identification.residuals.residual_structure import Unexplained
from identification.selection.search_step import SearchStep
from identification.selection.trial import Trial
from identification.selection.trial_runner import Effects
from symbolic import Effect

OF_A_WRONG_LAW = 4.0
"""Squared error that a further effect has to explain, over what is left where it acts [1].

Of what a wrong law leaves another mechanism took up to three quarters, three times the rest (laws
planted, seeds 300 to 302)."""


def stand_in_effect_names(
    steps: Sequence[SearchStep],
    rests: Mapping[Effect, Trial],
    recordings: Sequence[Recording],
    left: Unexplained,
) -> set[str]:
    """Effects with a parameter at the end of its range, or that explain too little beside what is left.

    What an effect explains is what the final model loses without it, see `rests` of `build_diagnosis`.
    """
    whole = steps[-1].before
    found = {effect for effect, *_ in parameters_at_bounds(whole.fitted)}
    if not left.present:
        return found
    gains = {effect.name: rest.nrmse**2 - whole.nrmse**2 for effect, rest in rests.items()}
    if recordings[0].standstills is not None:
        return _low_gain_effects_of_car(gains, found, left.structured**2)
    acts = {
        e.name: _unexplained_where_effect_acts(whole, rest, recordings, left)
        for e, rest in rests.items()
    }
    return found | _low_gain_effects_of_wheel(
        gains, acts, _effect_of_first_family(steps, whole.effects, gains)
    )


def _low_gain_effects_of_wheel(
    gains: Mapping[str, float], left: Mapping[str, float], first: str | None
) -> set[str]:
    """Effects of a wheel whose gain is too little beside what is left where they act."""
    return {n for n, gain in gains.items() if gain < left[n] * (1 if n == first else OF_A_WRONG_LAW)}


def _low_gain_effects_of_car(gains: Mapping[str, float], found: set[str], left: float) -> set[str]:
    """The same in a car: all acts beside the tyre, so that what stand-ins explain is unknown too."""
    before, unknown = None, left
    while before != found:
        before = set(found)
        found |= {name for name, gain in gains.items() if gain < unknown}
        unknown = left + sum(max(gains.get(name, 0.0), 0.0) for name in found)
    return found


def _effect_of_first_family(
    steps: Sequence[SearchStep], final: Effects, gains: Mapping[str, float]
) -> str | None:
    """Of the final model, the effect of the family that the search began with."""
    added = [s.after.effects[-1].family for s in steps if s.after and s.after.effects]
    ranked = [(added.index(e.family), -gains[e.name], e.name) for e in final if e.family in added]
    return min(ranked)[-1] if ranked else None


def _unexplained_where_effect_acts(
    whole: Trial, rest: Trial, recordings: Sequence[Recording], left: Unexplained
) -> float:
    """Mean squared error beyond noise, over range, where the model without an effect differs [1]."""
    residuals, others = (shares_of_torque_range(trial.residuals, recordings) for trial in (whole, rest))
    counted = [influence(whole.fitted.loss, residual) for residual in residuals.values()]
    # Neighbours with a torque.
    known = [np.flatnonzero(np.isfinite(one)) for one in counted]
    # Without white noise, which may be of another size where the effect acts.
    errors = np.concatenate([one[at][1:] * one[at][:-1] for one, at in zip(counted, known, strict=True)])
    # What a wrong law leaves lies where that law acts, what has nothing to do with it lies anywhere.
    added = [others[name] - one for name, one in residuals.items()]
    weights = np.concatenate([one[at][1:] for one, at in zip(added, known, strict=True)]) ** 2
    if not weights.any():
        return left.structured**2
    return float(left.structured**2 + np.average(errors, weights=weights) - errors.mean())
