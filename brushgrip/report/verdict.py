"""Whether the friction of a diagnosis may be used, and why, for somebody who knows no tyre model."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from brushgrip.estimation.assumed_and_found_friction import FrictionOutcome
from brushgrip.estimation.suspicious_recordings import MAY_END, SUSPECTED
from brushgrip.report.friction_summary import load_trend_in_words
from brushgrip.wording.diagnosis_in_words import (
    is_unconfirmed,
    judging_may_be_of_another_wheel,
    unexplained_is_larger,
)
from brushgrip.wording.formatting import effect_words, listed, percent, sentence
from identification import Diagnosis
from identification.diagnosis.declared_values import says_declared_value_is_off
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


def verdict(
    diagnosis: Diagnosis, outcome: FrictionOutcome, stiffness: str = ""
) -> tuple[str, list[str]]:
    """One of the verdicts, and why, an item each; `stiffness` says what k makes of friction."""
    if not any(map(outcome.known_tracks, outcome.grounds)):
        return NOTHING, []
    grave, unknown = _grave(diagnosis, outcome, stiffness), _unknown_cause(diagnosis)
    told = diagnosis.unexplained.present and unknown not in grave
    evidence, effects = _of_evidence(diagnosis, outcome), _of_effects(diagnosis)
    doubts = [*grave, *[unknown] * told, *evidence, *effects, *_of_recordings(diagnosis, outcome)]
    if not doubts:
        return USE, [_provided(diagnosis)]
    said = [one.reason for one in doubts[:MAX_REASONS]]
    first = list(dict.fromkeys(one.before for one in doubts[:2]))
    last = f"Do not specify to it before {', and before '.join(first)}."
    last += " Friction may change then." * diagnosis.unexplained.present
    doubted = {ground for one in doubts for ground in one.grounds}
    sound = listed([ground for ground in outcome.bands() if ground not in doubted])
    if sound and all(one.grounds for one in doubts):
        allowed = f"{sound} may be specified to with the ± told, if what was declared is right"
        last += f" {sentence(allowed)}"
    why = [*map(sentence, said), last] if len(said) > 2 else [f"{sentence('; '.join(said))} {last}"]
    return NOT_YET if grave else CARE, why


def _grave(diagnosis: Diagnosis, outcome: FrictionOutcome, stiffness: str) -> list[Doubt]:
    """Doubts by which friction may be quite another."""
    notes, whole = diagnosis.notes, "car" if diagnosis.of_car else "rig"
    doubts = []
    if any(note.startswith(SUSPECTED) for note in notes):
        doubts.append(Doubt("an input looks wrong, which may make it void", "it is mended"))
    if diagnosis.stiffness_ratio != 1:
        doubts.append(Doubt(stiffness, f"the {whole} is checked"))
    if any(note.startswith(MAY_END) for note in notes):
        doubts.append(
            Doubt(
                "the torque may end by its sensor, and friction may be higher than told",
                "the sensor's range is checked",
            )
        )
    few = sum(len(outcome.known_tracks(ground)) for ground in outcome.grounds) < MIN_RECORDINGS
    unknown = diagnosis.unexplained
    much = unknown.structured > MUCH or (few and unexplained_is_larger(diagnosis))
    return [*doubts, *[_unknown_cause(diagnosis)] * (unknown.present and much)]


def _unknown_cause(diagnosis: Diagnosis) -> Doubt:
    larger = ", more than what was found explains" * unexplained_is_larger(diagnosis)
    return Doubt(
        "the torque shows something of unknown cause,"
        f" {percent(diagnosis.unexplained.structured)} of its range{larger}",
        "recordings at other steering speeds, steering angles and loads have shown the unknown cause",
    )


def _of_evidence(diagnosis: Diagnosis, outcome: FrictionOutcome) -> list[Doubt]:
    """Doubts as there are few recordings."""
    if len(diagnosis.recordings) + len(diagnosis.holdout) == 1:
        return [Doubt("it rests on one recording, which nothing checks", "a second one agrees")]
    known = {ground: len(outcome.known_tracks(ground)) for ground in outcome.grounds}
    if few := [ground for ground, count in known.items() if ground and 0 < count < MIN_RECORDINGS]:
        return [
            Doubt(
                f"on {listed(few)} fewer than {MIN_RECORDINGS} recordings give a value, too few"
                " to say what one more would give",
                f"{MIN_RECORDINGS} recordings on {listed(few)} give one",
                tuple(few),
            )
        ]
    if known.get(""):
        return [
            Doubt(
                "each value is that of its recording alone, as no ground is named",
                f"{MIN_RECORDINGS} recordings of a ground (--ground NAME) give a ± for one more",
            )
        ]
    return []


def _of_effects(diagnosis: Diagnosis) -> list[Doubt]:
    """Doubts by what was found, and by what was declared."""
    doubts = []
    if any(note.startswith(BEYOND_RANGE) for note in diagnosis.notes):
        doubts.append(
            Doubt(
                "full slide is beyond the sensor's range, so that friction is inferred from what"
                " is below",
                "a larger sensor has measured it",
            )
        )
    if diagnosis.inclination is not None:
        doubts.append(
            Doubt(
                "the steering axes seem to be inclined otherwise than declared",
                "their inclination is checked",
            )
        )
    if any(map(says_declared_value_is_off, diagnosis.notes)):
        doubts.append(
            Doubt(
                "the recordings want a length, a load or a zero other than declared",
                "that is measured (see the notes)",
            )
        )
    elif judging_may_be_of_another_wheel(diagnosis):
        doubts.append(
            Doubt(
                "with nothing adjusted what was found hardly helps on the validation recordings",
                "it is checked that they are of the same wheel, load and ground",
            )
        )
    if any(note.startswith(STOPPED_EARLY) for note in diagnosis.notes):
        doubts.append(Doubt("the fit stopped early", "a fit has come to its end"))
    if diagnosis.of_car:  # Its friction is by the vehicle, without the effects found.
        return doubts
    odd = [e for e in diagnosis.effects if e.grade == "stands_in"]
    some = "corrections" if len(odd) > 1 else "a correction"
    groups = {
        f"the model has {some} whose cause is not known": odd,
        "the model allows for {}, which the recordings that judge do not confirm": [
            e for e in diagnosis.effects if is_unconfirmed(e)
        ],
        "the model allows for {}, which may be chance": [
            e for e in diagnosis.effects if e.grade == "weak" and not is_unconfirmed(e)
        ],
    }
    for why, effects in groups.items():
        if names := [effect_words(effect.name) for effect in effects]:
            more = Doubt(why.format(listed(names)), "more recordings have settled that")
            doubts.append(more)
    return doubts


def _of_recordings(diagnosis: Diagnosis, outcome: FrictionOutcome) -> list[Doubt]:
    """Doubts by how recordings differ, or as some give no value."""
    doubts, tracks = [], outcome.tracks_of().values()
    for ground, one in outcome.bands().items():
        half = one.further or 0.0
        if half > WIDE * one.mu_eff and (one.scatter_share or 0.0) > 0.5:
            doubts.append(
                Doubt(
                    f"the {one.recordings} recordings on {ground} differ so much that the ± is"
                    f" {100 * half / one.mu_eff:.0f} % of friction",
                    f"more recordings on {ground} have narrowed its ±",
                    (ground,),
                )
            )
        elif half > WIDE * one.mu_eff:
            doubts.append(
                Doubt(
                    f"the ± on {ground} is {100 * half / one.mu_eff:.0f} % of friction",
                    f"that on {ground} is narrower",
                    (ground,),
                )
            )
    if load_trend_in_words(outcome, diagnosis):
        doubts.append(Doubt("friction goes with the load", "it is known at the load that counts"))
    if never := [track.name for track in tracks if track.last_usable is None]:
        doubts.append(Doubt(f"{_named(never)} gave no value", "it is known why (see below)"))
    ended = [
        track.name
        for track in tracks
        if track.last_usable not in (None, track.t.size - 1) and Status.INCONSISTENT in track.last_status
    ]
    if ended:
        doubts.append(Doubt(f"the model does not explain the end of {_named(ended)}", "it is known why"))
    return doubts


def _named(names: Sequence[str]) -> str:
    return listed(names) if len(names) <= MIN_RECORDINGS else f"{len(names)} recordings"


def _provided(diagnosis: Diagnosis) -> str:
    """What friction without a doubt rests on, in a sentence."""
    assumed = next((note for note in diagnosis.notes if note.startswith(ASSUMED)), "")
    sound = "Nothing in these recordings speaks against it."
    if not assumed:
        return f"{sound} The ± holds if what was declared is right to its tolerance."
    values = re.sub(r" \([^)]*\)| of its fitted value", "", assumed.partition(": ")[2])
    return (
        f"{sound} The ± holds if what was declared is right to {values}: assumed, as nobody said how"
        " well it is known."
    )
