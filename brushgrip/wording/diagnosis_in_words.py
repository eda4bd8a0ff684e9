"""The result of a diagnosis, and what an observer takes of it, in sentences as sure as its figures."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from string import ascii_uppercase

from brushgrip.wording.formatting import (
    add_degrees_behind_radians,
    effect_words,
    judging_error_before_and_after,
    listed,
    percent,
    sentence,
    unrefitted_error,
    value_with_std,
)
from identification import Diagnosis, FoundEffect, FoundModel, ParameterEstimate
from identification.diagnosis.contradicted_declared_values import says_declared_value_is_off
from identification.diagnosis.graded_effects import CLEAR_ERRORS, UNRECORDED_LOAD
from identification.experiments.model_separation import Proposal
from identification.selection.criteria import CLEAR_BIC

GRADES: Mapping[str, str] = {
    "strong": "likely",
    "weak": "weak",
    "ambiguous": "ambiguous",
    "stands_in": "stand-in",
}
"""Words for the grades; a stand-in takes the place of something unknown."""
UNPROVEN = "unproven, not to be built on"
"""Of a stand-in."""
HARDLY_BETTER = 0.75
"""Error with nothing adjusted over that without the effects found from which on they hardly help [1]."""
CLEAR = ("strong", "ambiguous")
"""Grades of effects that are said to be missing."""
COMMON_NAMES = {
    "mu": "internal coefficient μ, not to be quoted",
    "k": "tread stiffness k",
    "a": "half-length a",
    "e": "caster e",
    "load": "load over the recorded one",
}


def headline(diagnosis: Diagnosis) -> str:
    """The result of a diagnosis in one sentence; what is unexplained goes first if it is the larger."""
    kind, *errors = judging_error_before_and_after(diagnosis)
    before, after = map(percent, errors)
    if not diagnosis.effects:
        beside = " beside its stiffness" * (diagnosis.stiffness_ratio != 1)
        verdict = (
            "No effect alone explains enough of what the assumed model lacks"
            if diagnosis.unexplained.present
            else f"The assumed model lacks nothing{beside} that these recordings could show"
        )
        return f"{verdict}: {kind} error {after} of range{_unrefitted_clause(diagnosis)}."
    found = _findings_text(diagnosis)
    if diagnosis.unexplained.present:
        rest = percent(diagnosis.unexplained.structured)
        if unexplained_is_larger(diagnosis):
            found = f"Something unknown remains, {rest} of range; {found[:1].lower()}{found[1:]}"
        else:
            found = f"{found}; {rest} of range stay unexplained"
    return (
        f"{found}: {kind} error {before} (k refitted) → {after} of range{_unrefitted_clause(diagnosis)}."
    )


def _unrefitted_clause(diagnosis: Diagnosis) -> str:
    """That the error is small by what is adjusted to each validation recording alone."""
    error = unrefitted_error(diagnosis)
    if error is None:
        return ""
    return f", but {percent(error)} with nothing adjusted: there friction, lengths or load differ"


def is_validation_wheel_doubtful(diagnosis: Diagnosis) -> bool:
    """Whether with nothing adjusted the model found is hardly better than none, or a value seems off."""
    if (error := unrefitted_error(diagnosis)) is None:
        return False
    known = diagnosis.before.summary()["holdout_torque_nrmse_unrefitted"]
    hardly = known is not None and error > HARDLY_BETTER * known
    return hardly or any(map(says_declared_value_is_off, diagnosis.notes))


def unexplained_is_larger(diagnosis: Diagnosis) -> bool:
    """Whether more is unexplained than the effects found explain, or none of them is clear."""
    if not diagnosis.unexplained.present:
        return False
    _, before, after = judging_error_before_and_after(diagnosis)
    clear = any(effect.grade in CLEAR for effect in diagnosis.effects)
    return not clear or diagnosis.unexplained.structured > before - after


def _findings_text(diagnosis: Diagnosis) -> str:
    """Findings in words; only effects with clear figures are said to be missing."""
    clear, weak, odd = (
        [e for e in diagnosis.effects if e.grade in grades]
        for grades in (CLEAR, ("weak",), ("stands_in",))
    )
    parts = []
    if clear:
        families = dict.fromkeys(effect.family for effect in clear)
        missed = [_family_and_laws(name, [e for e in clear if e.family == name]) for name in families]
        parts.append(f"The assumed model lacks {listed(missed)}")
    if weak:
        parts.append(
            f"{'there are ' if clear else 'There are only '}weak signs of {listed(_effect_names(weak))}"
        )
    if odd:
        names = f"{listed(_effect_names(odd))} {'is a stand-in' if len(odd) == 1 else 'are stand-ins'}"
        parts.append(names if parts else names[:1].upper() + names[1:])
    return "; ".join(parts)


def _effect_names(effects: Iterable[FoundEffect]) -> list[str]:
    return [effect_words(effect.name) for effect in effects]


def _family_and_laws(name: str, effects: list[FoundEffect]) -> str:
    """The mechanism, then the effects that are laws of it; an effect of none by its own name."""
    if name in ("other", effects[0].name):
        return listed([effect_words(one.name) + _rivals_clause(one, " (or {})") for one in effects])
    laws = [effect_words(effect.name) + _rivals_clause(effect, ", or {}") for effect in effects]
    return f"{effect_words(name)} ({'; '.join(laws)})"


def rivals_of(effect: FoundEffect) -> str:
    """The effects that this one may be as well; empty for none."""
    return listed([effect_words(name) for name in effect.indistinguishable_from], "or")


def _rivals_clause(effect: FoundEffect, form: str) -> str:
    """The effects that an ambiguous one may be."""
    rivals = rivals_of(effect)
    remedy = ": record it" * (UNRECORDED_LOAD in effect.indistinguishable_from)
    return form.format(rivals + remedy) if effect.grade == "ambiguous" and rivals else ""


def mechanism(effect: FoundEffect) -> str:
    """The mechanism that an effect is a law of, then the effect."""
    return _family_and_laws(effect.family, [replace(effect, grade="strong")])


def grade_reason(effect: FoundEffect) -> str:
    """Why an effect has its grade, in one sentence."""
    errors, rivals = effect.standard_errors, rivals_of(effect)
    fall = (
        "That it improves the model is hardly chance"
        + f" ({errors or 0:.1f} standard errors)" * bool(errors)
    )
    match effect.grade:
        case "stands_in":
            if effect.at_bound:
                return f"Its best value is at the allowed limit: {UNPROVEN}."
            return (
                "Its gain is too small beside what remains unexplained: it may make up for a flaw of"
                f" another effect, {UNPROVEN}."
            )
        case "weak":
            return _why_weak(effect)
        case "ambiguous":
            if not rivals:
                return f"{fall}, but another effect that the model has too would explain as much alone."
            return f"{fall}, but {rivals} would explain as much."
        case "strong":
            return f"{fall}, and no other effect with as few parameters does as well."


def recordings_shown_note(diagnosis: Diagnosis, count: int, otherwise: str) -> str:
    """Which recordings a picture has room for, in a sentence; empty where it shows all.

    `otherwise` go first where none is held out.
    """
    first = "those for validation" if diagnosis.holdout else otherwise
    told = f" There is room for {count} of {len(diagnosis.series)} recordings (chosen first: {first})."
    return told * (count < len(diagnosis.series))


def proposed_recordings(diagnosis: Diagnosis) -> dict[str, tuple[FoundEffect, Proposal]]:
    """Recordings that would tell an effect from a rival, by letters."""
    pairs = [(e, e.experiment) for e in diagnosis.effects if e.experiment and e.experiment.feasible]
    return dict(zip(ascii_uppercase, pairs, strict=False))


def experiment_in_words(proposal: Proposal) -> str:
    """A proposed experiment with angles in degrees too, and which way to turn first."""
    words = add_degrees_behind_radians(sentence(proposal.sentence))
    return f"{words} {proposal.manoeuvre.first_stroke_sentence}" if proposal.feasible else words


def is_unconfirmed(effect: FoundEffect) -> bool:
    """Whether the fitted recordings demand an effect that those that judge do not confirm."""
    errors, off = effect.standard_errors, effect.deviations
    few = errors is not None and errors < CLEAR_ERRORS
    return effect.grade == "weak" and few and off is not None and off >= CLEAR_ERRORS


def doubtful_effects(diagnosis: Diagnosis) -> tuple[list[str], list[str], list[str]]:
    """Names in words of unconfirmed effects, of other weak ones, and of stand-ins."""
    unconfirmed = [e for e in diagnosis.effects if is_unconfirmed(e)]
    weak = [e for e in diagnosis.effects if e.grade == "weak" and e not in unconfirmed]
    odd = [e for e in diagnosis.effects if e.grade == "stands_in"]
    return _effect_names(unconfirmed), _effect_names(weak), _effect_names(odd)


def is_single_recording(diagnosis: Diagnosis) -> bool:
    """Whether there is one recording, which nothing judges."""
    return len(diagnosis.recordings) + len(diagnosis.holdout) == 1


def find_note(diagnosis: Diagnosis, beginning: str) -> str:
    """The first note of a diagnosis that begins so; empty where none does."""
    return next((note for note in diagnosis.notes if note.startswith(beginning)), "")


def _why_weak(effect: FoundEffect) -> str:
    """What is asked of a finding, and what there is."""
    errors, off = effect.standard_errors, effect.deviations
    gain = [] if errors is None else [f"a gain of {errors:.1f} standard errors"]
    size = [] if off is None else [f"a parameter {off:.1f} σ from no effect"]
    if is_unconfirmed(effect):
        return (
            f"The fitted recordings demand it ({size[0]}), those that judge do not confirm it"
            f" ({gain[0]}; {CLEAR_ERRORS:g} are asked for): fit a recording of each ground, or judge"
            " without --holdout."
        )
    if errors is None and (off or 0.0) >= CLEAR_ERRORS and effect.delta_bic <= CLEAR_BIC:
        return f"Only the fit to one recording demands it ({size[0]}), none confirms it."
    figures = f" ({listed([*gain, *size])}; {CLEAR_ERRORS:g} of each are asked for)"
    return f"It may be chance{figures * bool(gain or size)}."


def parameter_words_and_owner(label: str) -> tuple[str, str]:
    """A parameter in words, and its owner: `effect_a.k_t [b]` as `effect a: k_t` and `b`."""
    path, _, owner = label.partition(" [")
    effect, dot, own = path.rpartition(".")
    text = f"{effect_words(effect)}: {own}" if dot else COMMON_NAMES.get(path, path)
    return text, owner.removesuffix("]")


def model_use_text(diagnosis: Diagnosis, found: FoundModel) -> str:
    """Friction by `estimate` with the model of a diagnosis."""
    if not diagnosis.of_car:
        return f"With model.json the command estimate uses {taken_from_model(found)}."
    vehicle = "as declared, before and after alike"
    if diagnosis.inclination is not None:
        vehicle = f"with inclination = {diagnosis.inclination:.3f}, before it as declared"
    return (
        f"Friction is by the vehicle {vehicle}: estimate takes no model.json of a car. Declare what was"
        " found as inclination (return torque), gear_friction or damping, or measure these: brushgrip "
        "identify --plates --write-vehicle."
    )


def taken_from_model(found: FoundModel) -> str:
    """What an observer takes from a model file, and on how many recordings that stands."""
    basis, model = found.basis, found.model
    grades = {} if basis is None else basis.grades
    own = [effect.name for effect in model.effects if effect.is_per_recording]
    parts = [
        effect_words(name) + (f" ({GRADES.get(grades[name], grades[name])})" if name in grades else "")
        for name in (effect.name for effect in model.effects)
        if name not in own
    ]
    if "k" in found.tyre:
        stiffness = ParameterEstimate(value=found.tyre["k"], std=None, unit="N/m^2")
        parts.append(f"k = {value_with_std(stiffness)}")
    else:
        parts.append("k of the ground")
    kept = basis is not None and basis.explains_nothing
    if found.error is not None and not kept:
        full_slide = found.error.relative is None
        whole = "the torque of full slide" if full_slide else "the torque's range"
        share = found.error.share_of_torque * (1 if full_slide else 0.5)
        parts.append(f"the error that observers allow the model, {percent(share)} of {whole}")
    line = listed(parts)
    if own:
        line += f"; not {listed([effect_words(name) for name in own])}, which belongs to a recording"
    if kept:
        line += "; at least the error of the assumed model, as no effect surely explains what is left"
    return f"{line}. {_model_basis_sentence(found)}"


def _model_basis_sentence(found: FoundModel) -> str:
    basis = found.basis
    if basis is None:
        return "The file does not say how many recordings that stands on"
    count = f"{basis.training} recording{'s' * (basis.training != 1)}"
    if basis.holdout:
        judged = f"{basis.holdout} validation recording{'s' * (basis.holdout != 1)} judged it"
    elif basis.training > 1:
        judged = "each left out in turn judged it"
    else:
        judged = "nothing judged it"
    weak = sum(grade in ("weak", "stands_in") for grade in basis.grades.values())
    doubt = f"; {weak} of {len(basis.grades)} effects are weak or stand-ins" * bool(weak)
    doubt += "; something stays unexplained" * basis.unexplained
    return f"It stands on {count}, {judged}{doubt}"
