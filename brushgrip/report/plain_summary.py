"""The results for somebody who knows no tyre model: friction by ground, and lines for a mail."""

from collections.abc import Sequence
from math import degrees

from brushgrip.estimation.friction_by_both_models import (
    EKF_DECLARED,
    EKF_FOUND,
    FrictionByBothModels,
    found_model,
)
from brushgrip.estimation.recording_warnings import direction_deficit_and_note
from brushgrip.report.friction_and_found_stiffness import (
    friction_if_stiffness_is_wrong,
    stiffness_doubt_and_range,
    stiffness_explanations,
    stiffness_tolerance_sentence,
)
from brushgrip.report.friction_summary import (
    IN_PLAIN_WORDS,
    common_load_clause,
    common_load_text,
    ground_comparison_text,
    is_band_mostly_from_spread,
    is_by_declared_vehicle,
    last_usable_friction_text,
    load_trend_in_words,
    note_on_highest_loads,
    variance_shares_by_cause,
)
from brushgrip.report.friction_verdict import NOT_YET, verdict
from brushgrip.report.next_steps import CHECKS, limits_of_further_recordings, next_steps
from brushgrip.report.validity_and_missing_effects import (
    ALLOWED_FOR,
    LEFT_OUT,
    band_caveats,
    error_text_and_basis,
    has_rival_mechanism,
    known_by_both_models_text,
    missing_effects,
    unclear_result_text,
    validity_text,
)
from brushgrip.wording.diagnosis_in_words import doubtful_effects
from brushgrip.wording.formatting import effect_words, listed, percent, sentence
from brushgrip.wording.recording_remarks import further_recording_band_line, prediction_band
from identification import Diagnosis
from observers import GroundFriction

UNLIKE = "asymmetric_friction"
"""The effect by which friction differs by direction."""
ARE_RIGHT = "if model and tolerances are right"
"""What the ± of a recording rests on."""
FRICTION = "friction between tyre and ground"
Parts = list[tuple[str, list[str]]]
"""Labels, each with its items."""
AGREE = 0.25
"""Share of a band's variance up to which recordings do not differ [1]."""
MAX_LISTED = 3
"""Recordings of a ground that are named one by one."""


def friction_and_notes(outcome: FrictionByBothModels | None) -> tuple[list[str], list[str]]:
    """Friction of named grounds for a further recording, and notes on those without a band."""
    known: list[str] = []
    notes: list[str] = []
    if outcome is None:
        return known, notes
    further, bands = outcome.last_usable_by_ground(), outcome.prediction_band_by_ground()
    for ground in filter(None, outcome.grounds):
        names = outcome.grounds[ground]
        line = further_recording_band_line(
            ground + common_load_text(outcome), further.get(ground), len(names)
        )
        line += f"; {told}" if (told := _found_vehicle_note(outcome, [ground])) else ""
        (known if ground in bands else notes).append(line)
    return known, notes


def summary_mail_parts(
    diagnosis: Diagnosis, outcome: FrictionByBothModels | None, warning: str = ""
) -> tuple[Parts, Parts]:
    """A mail of a few lines, what is acted on first, and what is to be known before acting on it.

    Each is a list of parts, a label and its items.
    """
    told = outcome or FrictionByBothModels(before={}, after={}, grounds={})
    known = told.is_known_in_any_recording
    asked = next_steps(diagnosis, told)
    # Names of grounds and recordings may hold a full stop.
    parted = ". " if asked[:1] == [CHECKS[diagnosis.of_car]] else "\n"
    steps = [f"({i}) " * (len(asked) > 1) + sentence(step) for i, step in enumerate(asked, 1)]
    one = "(1)" if len(steps) > 1 else "that"
    first, after = [text.strip() for text in "".join(steps[:1]).partition(parted)[::2]]
    reserved = band_caveats(diagnosis)
    wide = [_spread_on_ground(told, ground, one) for ground, one in told.last_usable_by_ground().items()]
    also = [*wide, _weaker_direction_text(diagnosis, told), *reserved]
    missing = missing_effects(diagnosis, told if known and not diagnosis.of_car else None)
    label = LEFT_OUT + ALLOWED_FOR * (known and not is_by_declared_vehicle(told, diagnosis))
    error, judged = error_text_and_basis(diagnosis)
    provisional = known and bool(diagnosis.stiffness_ratio != 1)
    finding = {label: missing} if missing else {"Result": [unclear_result_text(diagnosis)]}
    judged_use, why = verdict(diagnosis, told)
    held = f" The ± holds only if the {'car' if diagnosis.of_car else 'rig'} proves right." * provisional
    friction = {judged_use: [_friction(told) + held], "Why": why}
    cases = stiffness_explanations(diagnosis)
    for at, value in enumerate(friction_if_stiffness_is_wrong(diagnosis, told), 1):
        cases[at] = f"{cases[at].removesuffix('.')}: then {value}."
    valid = validity_text(diagnosis, told.slide_rate if known else None, told.slide_speed)
    benefit, trend = known_by_both_models_text(diagnosis, told), load_trend_in_words(told, diagnosis)
    *sure, caution = _band_meaning_lines(told, "force" if diagnosis.of_car else "torque")
    if judged_use == NOT_YET:
        sure = [line.replace(ARE_RIGHT, f"{ARE_RIGHT}, which is in doubt here") for line in sure]
    if provisional:
        sure.insert(0, stiffness_doubt_and_range(diagnosis, told)[1])
        benefit = f"Whether it is right rests on what is to do first. {benefit}" * bool(benefit)
    mail = {
        "Note": [warning],
        **(friction if outcome else finding),
        "Grounds": [ground_comparison_text(told, diagnosis)],
        "By which vehicle": [sentence(_found_vehicle_note(told, list(told.grounds)))] if known else [],
        "How sure": [" ".join(filter(None, [*sure, trend]))] if known else [*cases[:1], *reserved[:-1]],
        "To do first": [sentence(first)] if first else [],
        **finding,
        "Torque, not friction": [error],
        "Valid for": [valid],
    }
    details = {
        "What the stiffness may mean" if provisional else "Stiffness": cases[not known :]
        or [stiffness_tolerance_sentence(diagnosis)],
        "More on how sure": [caution, *also] if known else [],
        "To do then": [f"After {one}, {after[:1].lower()}{after[1:]}" * bool(after), *steps[1:]],
        "Further recordings": [limits_of_further_recordings(diagnosis, asked)],
        "Recordings with a value": [benefit],
        "How the torque's error is told": [judged],
        "Not known": [sentence("; ".join(_open_questions(diagnosis, told)))],
    }
    return _nonempty_parts(mail), _nonempty_parts(details)


def repeatability_in_words(diagnosis: Diagnosis) -> str:
    """How well recordings that replicate each other repeat, and what that may make of the error."""
    if (known := diagnosis.repeatability) is None:
        return ""
    spreads = known.spreads or (known.spread,) * len(known.replicates)
    which = "; ".join(
        f"{listed([f'“{name}”' for name in names])} by {percent(spread)}"
        for names, spread in zip(known.replicates, spreads, strict=True)
    )
    return (
        "Recordings of one ground and load differ in the torque at which the tyre slides (standard"
        f" deviation): {which}. Up to {percent(known.nrmse)} of the torque's range may come from that"
        " in an error with nothing adjusted to a recording. Part of it may be how fast they turn."
    )


def _nonempty_parts(parts: dict[str, list[str]]) -> Parts:
    """The parts that say something."""
    filled = {label: [item for item in items if item] for label, items in parts.items()}
    return [(label, items) for label, items in filled.items() if items]


def _friction(outcome: FrictionByBothModels) -> str:
    """Friction of every ground, and what it is made of."""
    grounds = "; ".join(_friction_on_ground(outcome, ground) for ground in outcome.grounds)
    bands = outcome.prediction_band_by_ground().values()
    count, of, each = str(len(outcome.before)), "from", ""
    if bands and len(bands) == len(outcome.grounds):
        counts = [str(one.recordings) for one in bands]
        count = listed(counts) if len(set(counts)) > 1 else counts[0]
        of, each = "mean of", " each" * (len(bands) > 1)
    if outcome.slide_rate:
        each += f", turning at {outcome.slide_rate:.2g} rad/s"
    line = f"{grounds} ({of} {count} recording{'s' * (count != '1')}{each})"
    line = ", ".join(filter(None, [line, common_load_clause(outcome)]))
    return f"{FRICTION} {line}."


def _found_vehicle_note(outcome: FrictionByBothModels, grounds: Sequence[str]) -> str:
    """By which vehicle friction is told that was found, and what the declared one gives; else empty."""
    if outcome.inclination is None:
        return ""
    declared = "; ".join(_friction_on_ground(outcome, ground, EKF_DECLARED) for ground in grounds)
    return (
        "use this one: by these recordings the steering axes are inclined by"
        f" {degrees(outcome.inclination):.1f}° (inclination = {outcome.inclination:.3f} in the vehicle"
        f" file), not as declared; by the vehicle as declared friction would be {declared}"
    )


def _band_meaning_lines(outcome: FrictionByBothModels, read: str) -> list[str]:
    """How often the ± of grounds and of recordings that are named holds; what is read gives both."""
    bands = outcome.prediction_band_by_ground()
    lines = [
        "In 95 of 100 cases one more recording like these would give friction within the ±."
        f"{_why_band_is_wide(outcome)} Nobody has checked friction in another way."
    ]
    lines *= bool(bands)
    if len(bands) < len(outcome.grounds):
        lines.append(
            f"{'Where a recording is named, t' if bands else 'T'}he truth lies within ± in 95 of"
            f" 100 cases, {ARE_RIGHT}."
        )
    lines.append(
        f"A {read} that reads 5 % too high makes friction 5 % too high, a load that is too low about as"
        " much; beyond what is declared, that comes on top of the ±."
    )
    return lines


def _why_band_is_wide(outcome: FrictionByBothModels) -> str:
    """What makes the ± wide where recordings agree, in a sentence; empty where they do not."""
    shares = variance_shares_by_cause(outcome)
    if not shares or any(
        (one.scatter_share or 0.0) > AGREE for one in outcome.prediction_band_by_ground().values()
    ):
        return ""
    cause = next(iter(shares))
    words = IN_PLAIN_WORDS.get(cause, f"how well the {cause} is known")
    return f" The recordings agree; what makes the ± wide is, above all, {words}."


def _weaker_direction_text(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> str:
    """How much less the ground holds in one direction by the model found; empty for both alike."""
    found = found_model(diagnosis)
    told: dict[str, list[str]] = {}
    for ground in outcome.grounds:
        _, note = direction_deficit_and_note(found.values_for_estimation(ground or None))
        told.setdefault(note.partition(":")[0], []).append(ground)
    told.pop("", None)
    parts = [f"{less}{f' on {listed(grounds)}' * (len(told) > 1)}" for less, grounds in told.items()]
    line = (
        f"Friction is the mean of both directions of turning; by the model found it is {listed(parts)}"
    )
    line = line.replace("than mu_eff turning to positive psi", "while the angle rises")
    line = line.replace("than mu_eff turning to negative psi", "while the angle falls")
    unproven = any(e.name == UNLIKE and e.grade == "stands_in" for e in diagnosis.effects)
    return sentence(f"{line} (unproven)" if unproven else line) * bool(parts)


def _spread_on_ground(outcome: FrictionByBothModels, ground: str, friction: GroundFriction) -> str:
    """How recordings on a ground differ, where that is most of its band's variance; else empty."""
    if not is_band_mostly_from_spread(friction):
        return ""
    values = [float(track.mu[at]) for track, at in outcome.known_tracks(ground)]
    return (
        f"The ±{f' on {ground}' * bool(ground)} is wide because {len(values)} recordings differ, from"
        f" {min(values):.2f} to {max(values):.2f}, and for so few it must be."
    )


def _friction_on_ground(outcome: FrictionByBothModels, ground: str, label: str = EKF_FOUND) -> str:
    """Friction on a ground in a phrase: for a further recording, or else of each."""
    where = f" on {ground}" * bool(ground)
    if band := outcome.prediction_band_by_ground(label).get(ground):
        by, count = band.recordings, len(outcome.grounds[ground])
        some = f" (by {by} of {count} recordings)" * (by < count)
        return f"{prediction_band(band)}{where}{some}"
    known = sorted(outcome.known_tracks(ground, label), key=lambda own: own[0].mu[own[1]])
    values = [f"{last_usable_friction_text(track)} ({track.name})" for track, _ in known]
    if len(values) > MAX_LISTED:
        return f"{values[0]} to {values[-1]}{where} in {len(values)} recordings"
    return (listed(values) or "not known") + where


def _open_questions(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[str]:
    """What the recordings leave open, each in a phrase."""
    parts = []
    if never := outcome.recordings_without_friction():
        parts.append(f"friction in {listed(never)}")
    ending = [track for track in outcome.tracks_of().values() if track.ends_early]
    if early := [f"{t.name} after {t.t[t.last_usable]:.1f} s" for t in ending]:
        heaviest = note_on_highest_loads(diagnosis, [track.name for track in ending])
        parts.append(f"friction in {listed(early)} (told is the value until then{heaviest})")
    for e in diagnosis.effects:
        rivals = listed([effect_words(name) for name in (e.name, *e.indistinguishable_from)], "or")
        if e.grade == "ambiguous" and has_rival_mechanism(e):
            parts.append(f"which of {rivals} it is")
    unconfirmed, weak, odd = doubtful_effects(diagnosis)
    if unconfirmed:
        parts.append(f"whether {listed(unconfirmed)} is there, as only the fitted recordings demand it")
    if weak:
        parts.append(f"whether the weak signs of {listed(weak)} are chance")
    if odd:
        parts.append(f"the cause that {listed(odd)} {'copies' if len(odd) == 1 else 'copy'}")
    if diagnosis.unexplained.present and not missing_effects(diagnosis):
        parts.append(f"what makes {percent(diagnosis.unexplained.structured)} of range")
    return parts
