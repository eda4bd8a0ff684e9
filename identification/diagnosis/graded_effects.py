"""The effects that a search added, how sure each is, and remarks on the final model."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from identification.diagnosis.contradicted_declared_values import notes_on_wrong_declared_values
from identification.diagnosis.found_vs_declared_stiffness import kingpin_inclination_note, stiffness_note
from identification.diagnosis.result_parts import FoundEffect, Grade, TorqueErrors
from identification.experiments.model_separation import Proposal
from identification.fits.fitting import Fit, parameters_at_bounds
from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.reading.recordings import Recording
from identification.selection.criteria import (
    CLEAR_BIC,
    DEFAULT_CRITERIA,
    cross_term_standard_error,
    delta_bic,
    error_reduction,
)
from identification.selection.search_step import SearchStep
from identification.selection.trial import Trial
from identification.selection.trial_runner import Effects
from symbolic import USUAL, Effect, Scope, parameter_name

CLEAR_ERRORS = 3.0
"""Standard errors by which the judged error has to fall, and deviations that a parameter has to be off
its neutral value, for a finding."""
ASSUMED = "assumed, as nobody declared a tolerance"
"""How the note on what counts as known within the usual tolerance begins."""
UNRECORDED_LOAD = "unrecorded_load"
"""Stands beside the effects that one may be, where the recorded load is constant."""
LIKE_LOAD = ("steering_return", "torque_offset", "asymmetric_friction")
"""Effects that a load that changes with the angle, but not in the recording, looks like."""
MIN_LOAD_RANGE = 1e-3
"""Range of a load over its mean below which it is constant, and so was not recorded [1]."""
SCOPES: tuple[Scope, ...] = ("ground", "tyre", "recording")
"""An effect belongs to the first of these that one of its parameters belongs to."""


def found_effects(
    steps: Sequence[SearchStep],
    rests: Mapping[Effect, Trial],
    estimates: Mapping[str, ParameterEstimate],
    recordings: Sequence[Recording],
    proposals: Mapping[Effects, Proposal],
    standing_in: Collection[str],
) -> tuple[FoundEffect, ...]:
    """The effects of the final model, in order of selection.

    Arguments are as in `build_diagnosis`; these recordings are the training ones.
    """
    whole = steps[-1].before
    final = whole.fitted
    added = _steps_that_added_effects(steps, final.model.effects)
    of_car = recordings[0].standstills is not None
    at_bounds = {effect for effect, *_ in parameters_at_bounds(final)}
    # Nothing but the fit judges a single recording.
    alone = len(recordings) == 1 and not whole.held_out
    hidden_load = not of_car and all(np.ptp(r.F_N) < MIN_LOAD_RANGE * r.F_N.mean() for r in recordings)
    effects = []
    for step in added:
        assert step.after is not None
        effect = step.after.effects[-1]
        scope, own = _scope_and_parameters(effect, final, estimates)
        rest = rests[effect]
        judged = whole.judgement, rest.judgement, DEFAULT_CRITERIA.long_block
        (gain, _), error = error_reduction(*judged), cross_term_standard_error(*judged)
        bic = delta_bic(final, rest.fitted, recordings)
        errors = gain / error if error > 0 else 0.0
        distance = distance_from_neutral_in_std(effect, own)
        like_load = hidden_load and effect.name in LIKE_LOAD
        rivals = (*_rivals_outside_model(step, final.model.effects), *[UNRECORDED_LOAD] * like_load)
        less = all(one.value < 0 for one in own.values())
        proposal = proposals.get(step.after.effects)
        effects.append(
            FoundEffect(
                name=effect.name,
                summary=effect.summary.replace("other than", f"{'less' if less else 'more'} than"),
                family=effect.name if effect.family == "other" else effect.family,
                scope=scope,
                grade=effect_grade(
                    0.0 if alone else errors,
                    bic,
                    distance,
                    has_rivals=bool(step.indistinguishable) or like_load,
                    stands_in=effect.name in standing_in,
                ),
                standard_errors=None if alone else errors,
                deviations=distance,
                at_bound=effect.name in at_bounds,
                parameters=own,
                holdout_nrmse_after=step.after.nrmse,
                delta_bic=bic,
                indistinguishable_from=rivals,
                experiment=proposal if proposal and proposal.rival in rivals else None,
            )
        )
    return tuple(effects)


def _rivals_outside_model(step: SearchStep, final: Effects) -> tuple[str, ...]:
    """What would have done as well in a step; what the final model holds besides is no alternative."""
    return tuple(effect.name for effect in step.indistinguishable if effect not in final)


def _steps_that_added_effects(steps: Sequence[SearchStep], final: Effects) -> list[SearchStep]:
    """The step that added each effect of the final model; the last one, where a law came back."""
    added: dict[Effect, SearchStep] = {}
    for step in steps:
        effect = step.after.effects[-1] if step.after and step.after.effects else None
        if effect in final and effect not in step.before.effects:
            added.pop(effect, None)
            added[effect] = step
    return list(added.values())


def _scope_and_parameters(
    effect: Effect, fitted: Fit, estimates: Mapping[str, ParameterEstimate]
) -> tuple[Scope, dict[str, ParameterEstimate]]:
    """Owner and parameters of an effect; those of other effects that it gave to each ground."""
    prefix, parameters = f"{effect.name}.", fitted.model.parameters
    own = {k.removeprefix(prefix): e for k, e in estimates.items() if k.startswith(prefix)}
    if own:
        scopes = {p.scope for owner, p in parameters if owner == effect}
        return next(s for s in SCOPES if s in scopes), own
    without = replace(fitted.model, effects=tuple(e for e in fitted.model.effects if e != effect))
    of_grounds = {
        parameter_name(*after)
        for after, before in zip(parameters, without.parameters, strict=True)
        if after != before
    }
    return "ground", {k: e for k, e in estimates.items() if k.split(" ")[0] in of_grounds}


def distance_from_neutral_in_std(
    effect: Effect, estimates: Mapping[str, ParameterEstimate]
) -> float | None:
    """Standard deviations from an effect's most significant parameter to its neutral value, if any."""
    neutral = {parameter.name: parameter.neutral for parameter in effect.parameters}
    distances = []
    for label, estimate in estimates.items():
        vanishes = neutral.get(label.split(" [")[0])
        if vanishes is None or not estimate.std or not math.isfinite(estimate.std):
            continue
        # What vanishes at infinity, as a stiffness, is off it by its own inverse: value over deviation.
        off = estimate.value - vanishes if math.isfinite(vanishes) else estimate.value
        distances.append(abs(off) / estimate.std)
    return max(distances, default=None)


def effect_grade(
    standard_errors_of_gain: float,
    delta_bic: float,
    distance_from_no_effect: float | None = None,
    *,
    has_rivals: bool,
    stands_in: bool,
) -> Grade:
    """How sure it is that an effect that was found is the one that is missing.

    stands_in: it may stand in place of something unknown, see `stand_ins`;
    weak: what it gains may be chance, by the standard errors by which the judged error is lower than
    without it, by the information criterion, or by its distance from no effect at all;
    ambiguous: what it gains is clear, but others gain as much; strong: none of these.
    """
    if stands_in:
        return "stands_in"
    off = math.inf if distance_from_no_effect is None else distance_from_no_effect
    if not (min(standard_errors_of_gain, off) >= CLEAR_ERRORS and delta_bic <= CLEAR_BIC):
        return "weak"
    return "ambiguous" if has_rivals else "strong"


STOPPED_EARLY = "the final fit stopped early"
"""How the note on it begins."""
FAR_ZERO = 3.0
"""Torque offset over the tolerance of the zero from which on it is doubted [1]."""


def final_model_notes(
    before: TorqueErrors,
    after: TorqueErrors,
    fitted: Fit,
    recordings: Sequence[Recording] = (),
    own: Sequence[Fit] = (),
    effects: Sequence[FoundEffect] = (),
    estimates: Mapping[str, ParameterEstimate] | None = None,
) -> tuple[str, ...]:
    """Sentences on the final model, without a full stop; `own` are fits to held-out recordings."""
    stiffnesses = [stiffness_note(fitted.values.of(one)["k"], one) for one in recordings]
    notes = list(dict.fromkeys(filter(None, stiffnesses)))
    notes += [
        f"{name} got worse{when}: {old[name]:.2%} of range before, {new[name]:.2%} after"
        for when, old, new in (
            ("", before.nrmse, after.nrmse),
            (" when left out", before.left_out, after.left_out),
        )
        for name in old
        if new[name] > old[name]
    ]
    notes += [
        f"{effect}: {what}, so that it is a stand-in" for effect, _, what in parameters_at_bounds(fitted)
    ]
    notes += notes_on_wrong_declared_values((fitted, *own), estimates or {})
    notes += [
        note for one in recordings if (note := _large_torque_offset_note(one, fitted.values.of(one)))
    ]
    for effect in effects:
        if UNRECORDED_LOAD in effect.indistinguishable_from:
            notes.append(f"{effect.name}: it is this, or a load that changes with the angle: record it")
        stiffness = effect.parameters.get("stiffness")
        if told := inclination_note_of_effect(effect, fitted, recordings)[0]:
            notes.append(f"{effect.name}: {told}")
        elif stiffness and stiffness.value < 0:
            notes.append(
                f"{effect.name}: a negative stiffness, so no spring: it turns the wheel outward"
            )
    if not fitted.converged:
        notes.append(f"{STOPPED_EARLY} ({fitted.status}); more samples or bounds may help")
    return tuple(notes)


def inclination_note_of_effect(
    effect: FoundEffect, fitted: Fit, recordings: Sequence[Recording]
) -> tuple[str, float | None]:
    """What an effect says of a car's kingpin, and the inclination to declare [rad], None for none."""
    stiffness = effect.parameters.get("stiffness")
    car = recordings[0].standstills if recordings else None
    if stiffness is None or car is None:
        return "", None
    label = (recordings[0].name, "return_share")
    share = fitted.values.at(label) if label in fitted.labels else 1.0
    told, inclination = kingpin_inclination_note(car, stiffness.value, stiffness.std or 0.0, share)
    if inclination is not None and effect.grade in ("weak", "stands_in"):
        return f"{told}; have a second log confirm it before you declare it", None
    return told, inclination


def assumed_tolerances_note(recordings: Sequence[Recording]) -> str:
    """Note on values declared without a tolerance, a sentence without a full stop; empty for none."""
    names = {
        "a": "half-length a",
        "e": "caster e (kingpin to contact)",
        "k": "tread stiffness k (how steeply the torque rises)",
    }
    missing = [
        names.get(name, name)
        + (f" ± {100 * usual:g} %" if name in ("load", "k") else f" ± {1000 * usual:g} mm")
        + " of its fitted value" * (name == "k")
        for name, usual in USUAL.items()
        if any(getattr(r.rig.tolerances, name) is None for r in recordings)
    ]
    return f"{ASSUMED}: {', '.join(missing)}" if missing else ""


def _large_torque_offset_note(recording: Recording, values: Mapping[str, float]) -> str:
    """What a zero of the torque may be that is far beyond what is declared; empty where it is not."""
    M_0, tolerance = values.get("torque_offset.M_0", 0.0), recording.rig.tolerances.zero
    if not tolerance or abs(M_0) < FAR_ZERO * tolerance:
        return ""
    return (
        f"{recording.name}: a torque offset of {M_0:.2g} N m is {abs(M_0) / tolerance:.0f} times the"
        " tolerance of the zero: friction may be less one way than the other, which estimate"
        " --by-direction tells"
    )
