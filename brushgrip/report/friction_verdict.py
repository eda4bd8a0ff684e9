"""Whether the friction of a diagnosis may be used, and why, for somebody who knows no tyre model."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.estimation.recording_warnings import MAY_END, SUSPECTED
from brushgrip.report.friction_and_found_stiffness import stiffness_deviation_phrase
from brushgrip.report.friction_summary import is_band_mostly_from_spread, load_trend_in_words
from brushgrip.wording.diagnosis_in_words import (
    doubtful_effects,
    find_note,
    is_single_recording,
    is_validation_wheel_doubtful,
    unexplained_is_larger,
)
from brushgrip.wording.formatting import listed, percent, sentence
from identification import Diagnosis
from identification.diagnosis.contradicted_declared_values import says_declared_value_is_off
from identification.diagnosis.from_search import BEYOND_RANGE
from identification.diagnosis.graded_effects import ASSUMED, STOPPED_EARLY
from observers import Status
from observers.quality.friction_across_recordings import MIN_RECORDINGS

USE = "Use it within its ±"
CARE = "Use it with care"
NOT_YET = "Do not use it yet"
NOTHING = "Nothing to use yet"
"""The verdicts; the last where friction is not known."""
WIDE = 0.25
"""Share of friction from which on a ± that recordings which differ make is wide [1]."""
MUCH = 0.05
"""Share of the torque's range of unknown cause from which on friction is not to be used [1]."""
MAX_REASONS = 4
"""Reasons that are told."""


class Doubt(NamedTuple):
    """A reason not to take friction as it is told, a phrase, and what comes before specifying to it."""

    reason: str
    before: str
    grounds: tuple[str, ...] = ()
    """Those that alone it is of; empty where it is of all."""


def verdict(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> tuple[str, list[str]]:
    """One of the verdicts, and why, an item each."""
    if not outcome.is_known_in_any_recording:
        return NOTHING, []
    grave, unknown = _grave_doubts(diagnosis, outcome), _unknown_cause_doubt(diagnosis)
    told = diagnosis.unexplained.present and unknown not in grave
    evidence, effects = _doubts_of_few_recordings(diagnosis, outcome), _effect_doubts(diagnosis)
    doubts = [*grave, *[unknown] * told, *evidence, *effects, *_recording_doubts(diagnosis, outcome)]
    if not doubts:
        return USE, [_proviso_sentence(diagnosis)]
    said = [one.reason for one in doubts[:MAX_REASONS]]
    first = list(dict.fromkeys(one.before for one in doubts[:2]))
    last = f"Do not specify to it before {', and before '.join(first)}."
    last += " Friction may change then." * diagnosis.unexplained.present
    doubted = {ground for one in doubts for ground in one.grounds}
    sound = listed([ground for ground in outcome.prediction_band_by_ground() if ground not in doubted])
    if sound and all(one.grounds for one in doubts):
        allowed = f"{sound} may be specified to with the ± told, if what was declared is right"
        last += f" {sentence(allowed)}"
    why = [*map(sentence, said), last] if len(said) > 2 else [f"{sentence('; '.join(said))} {last}"]
    return NOT_YET if grave else CARE, why


def _doubts_that_hold(*cases: tuple[object, str, str]) -> list[Doubt]:
    """The doubts of those cases that hold: a case holds by what comes first in it."""
    return [Doubt(reason, before) for holds, reason, before in cases if holds]


def _grave_doubts(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[Doubt]:
    """Doubts by which friction may be quite another."""
    whole, unknown = "car" if diagnosis.of_car else "rig", diagnosis.unexplained
    few = sum(len(outcome.known_tracks(ground)) for ground in outcome.grounds) < MIN_RECORDINGS
    much = unknown.structured > MUCH or (few and unexplained_is_larger(diagnosis))
    stiffness = stiffness_deviation_phrase(diagnosis, outcome)
    ends = "the torque may end by its sensor, and friction may be higher than told"
    doubts = _doubts_that_hold(
        (
            find_note(diagnosis, SUSPECTED),
            "an input looks wrong, which may make it void",
            "it is mended",
        ),
        (diagnosis.stiffness_ratio != 1, stiffness, f"the {whole} is checked"),
        (find_note(diagnosis, MAY_END), ends, "the sensor's range is checked"),
    )
    return [*doubts, *[_unknown_cause_doubt(diagnosis)] * (unknown.present and much)]


def _unknown_cause_doubt(diagnosis: Diagnosis) -> Doubt:
    larger = ", more than what was found explains" * unexplained_is_larger(diagnosis)
    return Doubt(
        "the torque shows something of unknown cause,"
        f" {percent(diagnosis.unexplained.structured)} of its range{larger}",
        "recordings at other steering speeds, steering angles and loads have shown the unknown cause",
    )


def _doubts_of_few_recordings(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[Doubt]:
    """Doubts as there are few recordings."""
    if is_single_recording(diagnosis):
        return [Doubt("it rests on one recording, which nothing checks", "a second one agrees")]
    known = {ground: len(outcome.known_tracks(ground)) for ground in outcome.grounds}
    if few := [ground for ground, count in known.items() if ground and 0 < count < MIN_RECORDINGS]:
        reason = (
            f"on {listed(few)} fewer than {MIN_RECORDINGS} recordings give a value, too few to say what"
            " one more would give"
        )
        return [Doubt(reason, f"{MIN_RECORDINGS} recordings on {listed(few)} give one", tuple(few))]
    unnamed = "each value is that of its recording alone, as no ground is named"
    named = f"{MIN_RECORDINGS} recordings of a ground (--ground NAME) give a ± for one more"
    return _doubts_that_hold((known.get(""), unnamed, named))


def _effect_doubts(diagnosis: Diagnosis) -> list[Doubt]:
    """Doubts by what was found, and by what was declared."""
    off = any(map(says_declared_value_is_off, diagnosis.notes))
    doubts = _doubts_that_hold(
        (
            find_note(diagnosis, BEYOND_RANGE),
            "full slide is beyond the sensor's range, so that friction is inferred from what is below",
            "a larger sensor has measured it",
        ),
        (
            diagnosis.inclination is not None,
            "the steering axes seem to be inclined otherwise than declared",
            "their inclination is checked",
        ),
        (
            off,
            "the recordings want a length, a load or a zero other than declared",
            "that is measured (see the notes)",
        ),
        (
            not off and is_validation_wheel_doubtful(diagnosis),
            "with nothing adjusted what was found hardly helps on the validation recordings",
            "it is checked that they are of the same wheel, load and ground",
        ),
        (find_note(diagnosis, STOPPED_EARLY), "the fit stopped early", "a fit has come to its end"),
    )
    if diagnosis.of_car:  # Its friction is by the vehicle, without the effects found.
        return doubts
    unconfirmed, weak, odd = doubtful_effects(diagnosis)
    some = "corrections" if len(odd) > 1 else "a correction"
    allows, settled = "the model allows for", "more recordings have settled that"
    return doubts + _doubts_that_hold(
        (odd, f"the model has {some} whose cause is not known", settled),
        (
            unconfirmed,
            f"{allows} {listed(unconfirmed)}, which the recordings that judge do not confirm",
            settled,
        ),
        (weak, f"{allows} {listed(weak)}, which may be chance", settled),
    )


def _recording_doubts(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[Doubt]:
    """Doubts by how recordings differ, or as some give no value."""
    doubts = []
    for ground, one in outcome.prediction_band_by_ground().items():
        half = one.further or 0.0
        if half <= WIDE * one.mu_eff:
            continue
        reason, before = f"the ± on {ground} is", f"that on {ground} is narrower"
        if is_band_mostly_from_spread(one):
            reason = f"the {one.recordings} recordings on {ground} differ so much that the ± is"
            before = f"more recordings on {ground} have narrowed its ±"
        share = f"{100 * half / one.mu_eff:.0f} % of friction"
        doubts.append(Doubt(f"{reason} {share}", before, (ground,)))
    never, tracks = outcome.recordings_without_friction(), outcome.tracks_of().values()
    ended = [t.name for t in tracks if t.ends_early and Status.INCONSISTENT in t.last_status]
    trend = load_trend_in_words(outcome, diagnosis)
    return doubts + _doubts_that_hold(
        (trend, "friction goes with the load", "it is known at the load that counts"),
        (never, f"{_names_or_count(never)} gave no value", "it is known why (see below)"),
        (ended, f"the model does not explain the end of {_names_or_count(ended)}", "it is known why"),
    )


def _names_or_count(names: Sequence[str]) -> str:
    return listed(names) if len(names) <= MIN_RECORDINGS else f"{len(names)} recordings"


def _proviso_sentence(diagnosis: Diagnosis) -> str:
    """What friction without a doubt rests on, in a sentence."""
    assumed = find_note(diagnosis, ASSUMED)
    sound = "Nothing in these recordings speaks against it."
    if not assumed:
        return f"{sound} The ± holds if what was declared is right to its tolerance."
    values = re.sub(r" \([^)]*\)| of its fitted value", "", assumed.partition(": ")[2])
    return (
        f"{sound} The ± holds if what was declared is right to {values}: assumed, as nobody said how"
        " well it is known."
    )
