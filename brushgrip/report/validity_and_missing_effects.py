"""What a report's friction is valid for, and what the model found changes, in plain words."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import groupby
from string import ascii_lowercase
from typing import Any

import numpy as np

from brushgrip.estimation.friction_by_both_models import EKF_DECLARED, EKF_FOUND, FrictionByBothModels
from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.estimation.recording_warnings import MAY_END, SUSPECTED
from brushgrip.outputs.provenance import digest_of
from brushgrip.published.bundled_files import TRUE_FRICTION, demo_folder
from brushgrip.report.friction_and_found_stiffness import stiffness_explanations
from brushgrip.report.friction_summary import is_by_declared_vehicle
from brushgrip.report.what_effects_do import MECHANISMS, OVER_SPEED, effect_summary, friction_over_speed
from brushgrip.wording.diagnosis_in_words import CLEAR, is_unconfirmed, unexplained_is_larger
from brushgrip.wording.formatting import effect_words, judging_error_name, listed, percent, sentence
from identification import Diagnosis, FoundEffect
from identification.diagnosis.found_vs_declared_stiffness import OFF_STIFFNESS
from identification.diagnosis.from_search import BEYOND_RANGE
from identification.diagnosis.graded_effects import ASSUMED
from symbolic import EFFECTS, InvalidInputError

LEFT_OUT = "What the assumed model leaves out"
"""Label of `missing_effects`."""
ALLOWED_FOR = "; friction above allows for it"
"""What follows that label where friction is told by the model found."""
UNCLEAR = ("stands_in", "weak")
"""Grades of effects that are not certain."""
CERTAIN = "likely, not proven"
"""Of a gain that is as good as certainly no chance."""


def demo_recordings_warning(provenance: Mapping[str, Any] | None) -> str:
    """That recordings are the demo's, by their digests, in one sentence; empty where none is."""
    # Sources of own effects are inputs too.
    files = provenance["inputs"] if provenance else []
    inputs = [file for file in files if not file["name"].endswith(".py")]
    try:
        bundled = {digest_of(path) for path in demo_folder().glob("*.csv")}
    except InvalidInputError:
        return ""
    count = sum(file["sha256"] in bundled for file in inputs)
    if not count:
        return ""
    which = "all" if count == len(inputs) else f"{count} of {len(inputs)}"
    return (
        f"Simulated, not measured: {which} recordings come from brushgrip's demo (true friction"
        f" {TRUE_FRICTION})."
    )


def validity_text(diagnosis: Diagnosis, slide_rate: float | None, slide_speed: float | None) -> str:
    """What friction at a rate of turning [rad/s] and of sliding [m/s] is valid for; None: not told."""
    loads = [series.F_N[np.isfinite(series.F_N)] for series in diagnosis.series]
    known = np.concatenate(loads) if loads else np.empty(0)
    at = ""
    if known.size and not diagnosis.of_car:
        low, high = f"{known.min():.0f}", f"{known.max():.0f}"
        at = f", at a load of {low} N" if low == high else f", at momentary loads of {low} to {high} N"
    sliding = ""
    if slide_rate and slide_speed:
        changes = any(family.name == OVER_SPEED for family in diagnosis.families)
        degrees = f"{np.degrees(slide_rate):.2g}°/s"
        sliding = (
            f"; friction is that of turning at {slide_rate:.2g} rad/s ({degrees}, sliding"
            f" {1e3 * slide_speed:.2g} mm/s)"
        ) + ", and differs at other speeds" * changes
    return (
        f"A wheel that stands and is steered as in these recordings{at}{sliding}; not for driving"
        " speed, rain or other ground."
    )


def band_caveats(diagnosis: Diagnosis) -> list[str]:
    """What the bands of friction rest on that no recording tells, in sentences."""
    doubtful = [n for n in diagnosis.notes if n.startswith((SUSPECTED, MAY_END, BEYOND_RANGE))]
    assumed = [sentence(note) for note in diagnosis.notes if note.startswith(ASSUMED)]
    covered = "errors of this size, no larger ones" if assumed else "the tolerances"
    return [*map(sentence, doubtful), " ".join([*assumed, f"The ± of friction covers {covered}."])]


def notes_not_in_text(diagnosis: Diagnosis, told: str) -> list[str]:
    """The notes of a diagnosis that a text does not tell; that on the stiffness is told case by case."""
    begun = [case for case in stiffness_explanations(diagnosis)[:1] if case in told]
    return [
        note
        for note in diagnosis.notes
        if sentence(note) not in told and not (note.startswith(OFF_STIFFNESS) and begun)
    ]


def missing_effects(diagnosis: Diagnosis, outcome: FrictionByBothModels | None = None) -> list[str]:
    """What the assumed model leaves out (`LEFT_OUT`), an item each; empty where nothing is certain.

    With an outcome its friction, by the model found, was told before.
    """
    if not any(effect.grade in CLEAR for effect in diagnosis.effects):
        return []
    told = []
    for cause, group in groupby(diagnosis.effects, key=partial(_cause, diagnosis)):
        effects = list(group)
        if cause:
            clearest = min(effects, key=lambda effect: effect.grade not in CLEAR)
            told.append(f"{cause} ({_sureness(clearest, cause)})")
        else:
            several = len(effects) > 1
            copies = "Corrections stand in for it" if several else "A correction stands in for it"
            without = (
                ""
                if outcome is None
                else _without_stand_ins_clause("them" if several else "it", outcome)
            )
            told.append(f"a further cause, unknown. {copies}{without}")
    if diagnosis.unexplained.present:
        unknown = "an error beyond noise remains, of unknown cause, which the model found leaves out too"
        if unexplained_is_larger(diagnosis):
            told.insert(0, unknown)
        elif diagnosis.effects[-1].grade == "stands_in":
            told[-1] += ". Even so part of the error remains"
        else:
            told.append(unknown)
    return [
        f"({i}) " * (len(told) > 1) + sentence(one)
        for i, one in zip(ascii_lowercase, told, strict=False)
    ]


def unclear_result_text(diagnosis: Diagnosis) -> str:
    """What a search without a clear effect came to, in sentences."""
    unknown = diagnosis.unexplained
    names = {g: [effect_words(e.name) for e in diagnosis.effects if e.grade == g] for g in UNCLEAR}
    if names["stands_in"]:
        told = f"Nothing is certain: what looks like {listed(names['stands_in'])} may be something else."
    elif names["weak"]:
        told = f"There are only weak signs of {listed(names['weak'])}, which may be chance."
    elif unknown.present:
        told = "No effect that is known explains what the assumed model lacks."
    else:
        beside = " beside its stiffness" * (diagnosis.stiffness_ratio != 1)
        told = f"The assumed model lacks nothing{beside} that these recordings could show."
    rest = f" {percent(unknown.structured)} of the torque's range have an unknown cause."
    return told + rest * unknown.present


def _without_stand_ins_clause(them: str, outcome: FrictionByBothModels) -> str:
    """Friction without the stand-ins, a clause; empty where that is not known."""
    changes: dict[str, list[str]] = {}
    for ground, ratio in outcome.without_stand_ins.items():
        share = f"{100 * abs(ratio - 1):.0f} %"
        change = "as" if share == "0 %" else f"{share} {'higher' if ratio > 1 else 'lower'} than"
        changes.setdefault(change, []).append(ground)
    told = listed([f"{one} told{f' on {listed(at)}' * any(at)}" for one, at in changes.items()])
    without = f"; without {them} friction would be {told}; the cause itself may change it by more"
    return without * bool(told)


def _sureness(effect: FoundEffect, cause: str) -> str:
    """How sure an effect is that leaves this cause open or not."""
    if effect.grade == "weak":
        return "not confirmed" if is_unconfirmed(effect) else "may be chance"
    if effect.grade != "ambiguous":
        return CERTAIN
    if not effect.indistinguishable_from:
        return "how much is not settled"
    return "one of these, not known which" if " or " in cause else CERTAIN


def _cause(diagnosis: Diagnosis, effect: FoundEffect) -> str:
    """The mechanism of an effect, or the effect; with others that it may be. Empty for a stand-in."""
    if effect.grade == "stands_in":
        return ""
    names = (effect.name, *effect.indistinguishable_from)
    families = [effect.family, *(_family_of(name) for name in names[1:])]
    known = MECHANISMS | {OVER_SPEED: friction_over_speed(diagnosis)}
    if len(names) == 1 and effect.family in MECHANISMS:
        return known[OVER_SPEED] if effect.family == OVER_SPEED else effect_summary(diagnosis, effect)
    known |= {effect.name: f"your effect “{effect_words(effect.name)}”"}  # Of no other family.
    pairs = zip(families, names, strict=True)
    return listed(list(dict.fromkeys(known.get(f, effect_words(name)) for f, name in pairs)), "or")


def has_rival_mechanism(effect: FoundEffect) -> bool:
    """Whether an effect may be one of another mechanism."""
    return any(_family_of(name) != effect.family for name in effect.indistinguishable_from)


def _family_of(name: str) -> str:
    return EFFECTS[name].family if name in EFFECTS else "other"


def known_by_both_models_text(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> str:
    """What the model found changes for friction, in a sentence; empty where it changes nothing."""
    declared, found = (list(outcome.tracks_of(label).values()) for label in (EKF_DECLARED, EKF_FOUND))
    if is_by_declared_vehicle(outcome, diagnosis) or not diagnosis.effects or not declared or not found:
        return ""
    return (
        f"A value of friction comes out in {_known_recordings_text(found)} by the model found;"
        f" in {_known_recordings_text(declared)} by the assumed model."
    )


def _known_recordings_text(tracks: Sequence[FrictionTrack]) -> str:
    """In how many recordings friction is known, since when, and in how many of them not to the end."""
    known = [track for track in tracks if track.last_usable is not None]
    if not known:
        return f"none of {len(tracks)} recordings"
    first = sorted(float(track.t[track.usable_since]) for track in known)
    since = " to ".join(dict.fromkeys(f"{at:.1f}" for at in (first[0], first[-1])))
    part = sum(track.ends_early for track in known)
    ends = f", in {part} lost again before the end" * bool(part)
    return f"{len(known)} of {len(tracks)} recordings (first after {since} s{ends})"


def refitted_per_recording_text(diagnosis: Diagnosis) -> str:
    """What is fitted to each recording that judges, in words."""
    scopes = {e.name for e, p in diagnosis.model.parameters if e and p.scope == "recording"}
    return (
        f"{listed(['friction', *map(effect_words, sorted(scopes))])}, and lengths and load within their"
        " tolerances"
    )


def error_text_and_basis(diagnosis: Diagnosis) -> tuple[str, str]:
    """The torque error stage by stage: with nothing adjusted, if that is known; and how it is told."""
    bare = diagnosis.after.unrefitted
    (kind, judging), count = judging_error_name(diagnosis), len(bare or diagnosis.holdout)
    judged = {
        "validation": f"{count} recording{'s' * (count != 1)} to which no shared value was fitted, but"
        " by which the effects were chosen (no independent test)",
        "left-out": "each recording with the parameters that the others gave",
        "training": "the recordings that it was fitted to, as none was left to judge it",
    }[kind]
    figure = "holdout_torque_nrmse_unrefitted" if bare else judging
    stages = [diagnosis.declared, diagnosis.before, *[diagnosis.after] * bool(diagnosis.effects)]
    assumed, refitted, *found = [percent(errors.summary()[figure]) for errors in stages]
    first = f"{assumed} of its range by the assumed model as given, {refitted}"
    if assumed == percent(None):  # Nothing was fitted that a recording could be left out of.
        first = f"{refitted} of its range by the assumed model"
    told = f"The error of the calculated torque (not of friction): {first} with only k fitted"
    told += "".join(f", {one} by the model found" for one in found)
    values = f"{refitted_per_recording_text(diagnosis)}, fitted to each"
    if not bare:
        return f"{told}.", sentence(f"in {judged}, with {values}")
    left = percent(stages[-1].summary()[judging])
    rest = "is left; the difference is particular to each recording."
    return f"{told}.", f"In {judged}. With {values}, {left} {rest}"
