"""The results for somebody who knows no tyre model: friction by ground, and lines for a mail."""

from math import sqrt
from statistics import fmean

from brushgrip.estimation.anomalies import SUSPECTED
from brushgrip.estimation.friction_before_and_after import FrictionOutcome
from brushgrip.report.findings_and_reservations import (
    LEFT_OUT,
    benefit,
    doubts,
    error_to_quote,
    missing_effects,
    reservation,
    several_mechanisms,
    validity,
)
from brushgrip.report.friction_summary import (
    band_shares,
    grounds_alike,
    last_usable_friction,
    order_with_load,
)
from brushgrip.wording.diagnosis_in_words import (
    headline,
    is_unconfirmed,
    proposed_recordings,
    rest_is_larger,
)
from brushgrip.wording.formatting import (
    band_decimals,
    listed,
    percent,
    plain,
    sentence,
    unrefitted_error,
)
from brushgrip.wording.friction import further_recording, narrowed_by, prediction_band
from identification import Diagnosis, FoundEffect
from identification.diagnosis.found_effects import ASSUMED, UNRECORDED_LOAD
from observers import GroundFriction
from observers.quality.settling_and_coverage import BAND_95

MAX_LISTED = 3
"""Recordings of a ground that are named one by one."""
MAX_STEPS = 4
"""What to do next that is told."""
CHECKS = {
    False: "at the rig, check three things: the torque, with a known weight on a lever; the gear ratio"
    " between sensor and wheel; the half-length of the contact, on a print. If one is wrong, correct it"
    " and run this again, as the result is then void, before anything else; if all are right, declare"
    " the stiffness found (k under [tyre] in the rig file)",
    True: "check the force's unit and motor_ratio: steer from lock to lock on ground of known friction,"
    " which gives scale and stiffness (brushgrip identify --lock-to-lock)",
}
"""What a stiffness far from the declared one asks for, of a rig and of a car."""


def friction_and_notes(outcome: FrictionOutcome | None) -> tuple[list[str], list[str]]:
    """Friction of named grounds for a further recording, and notes on those without a band."""
    known: list[str] = []
    notes: list[str] = []
    if outcome is None:
        return known, notes
    further = outcome.further()
    for ground in filter(None, outcome.grounds):
        one = further.get(ground)
        line = further_recording(ground, one, len(outcome.grounds[ground]))
        (known if one and one.further is not None else notes).append(line)
    return known, notes


def lines_to_send(
    diagnosis: Diagnosis, outcome: FrictionOutcome | None, warning: str = ""
) -> list[tuple[str, str]]:
    """A mail, each line a label and a text; what is acted on comes first."""
    told = outcome or FrictionOutcome(before={}, after={}, grounds={})
    known = any(map(told.known_tracks, told.grounds))
    steps = next_steps(diagnosis, told)
    numbered = [f"({i}) " * (len(steps) > 1) + step for i, step in enumerate(steps, 1)]
    certainty = (_holds(told), order_with_load(told, diagnosis), reservation(diagnosis))
    sure = " ".join(filter(None, certainty if known else doubts(diagnosis)))
    missing = missing_effects(diagnosis)
    finding = {LEFT_OUT: missing} if missing else {"Result": headline(diagnosis)}
    friction = {"Friction between tyre and ground": _friction(diagnosis, told, known=known)}
    lines = {
        "Note": warning,
        **(friction if outcome else finding),
        "How sure": sure,
        "To do": sentence(";\n".join(numbered)),
        **finding,
        "Gain": " ".join(filter(None, (benefit(diagnosis, told), error_to_quote(diagnosis)))),
        "Valid for": validity(diagnosis),
        "Not known": sentence("; ".join(_open_questions(diagnosis, told))),
    }
    return [(label, text) for label, text in lines.items() if text]


def _friction(diagnosis: Diagnosis, outcome: FrictionOutcome, *, known: bool) -> str:
    """Friction of every ground, and what it is where the torque reads as wrong as k seems to say."""
    count, ratio = len(outcome.before), diagnosis.stiffness_ratio
    speed = f"at {1e3 * outcome.slide_speed:.2g} mm/s sliding, " if known and outcome.slide_speed else ""
    grounds = "; ".join(_on_ground(outcome, ground) for ground in outcome.grounds)
    in_all = " in all" * (len(outcome.grounds) > 1)
    line = f"{speed}{grounds} (from {count} recording{'s' * (count != 1)}{in_all})"
    # Suspension and column make the k of a car small, and leave its friction as it is.
    if not known or ratio == 1 or (diagnosis.of_car and ratio < 1):
        return sentence(line)
    bands = {g: one for g, one in outcome.further().items() if one.further is not None}
    other = [f"{one.mu_eff / ratio:.2f} on {ground}" for ground, one in bands.items()]
    value = listed(other) if len(bands) == len(outcome.grounds) else f"{1 / ratio:.2g} times as much"
    return (
        f"Provisional until {'the force is' if diagnosis.of_car else 'torque and half-length are'}"
        f" checked: {line}; if the torque reads"
        f" {'too high' if ratio > 1 else 'too low'}, as the stiffness found may mean, about {value}."
    )


def _holds(outcome: FrictionOutcome) -> str:
    """How often the ± of the grounds and of the recordings that are named holds, and why it is wide."""
    further = outcome.further()
    bands = [one.further is not None for one in further.values()]
    within = ["One more recording of this kind on this ground comes out within ±"] * any(bands)
    if len(further) < len(outcome.grounds) or not all(bands):
        within.append(f"{'w' if any(bands) else 'W'}here a recording is named, the truth lies within ±")
    wide = [
        f" Most of the ± on {ground} comes from {differ}."
        for ground, one in further.items()
        if (differ := _differences(outcome, ground, one))
    ]
    shared = (
        "in 95 of 100 cases; an error beyond the tolerances, which all recordings share, is not in it"
    )
    return f"{', and '.join(within)} {shared}.{''.join(wide)}{grounds_alike(outcome)}"


def _differences(outcome: FrictionOutcome, ground: str, friction: GroundFriction) -> str:
    """How recordings on a ground differ, where that is most of its band's variance; else empty."""
    if (friction.scatter_share or 0.0) <= 0.5:
        return ""
    values = [float(track.mu[at]) for track, at in outcome.known_tracks(ground)]
    scatter = friction.scatter or 0.0
    times = sqrt(friction.scatter_share or 0.0) * (friction.further or 0.0) / scatter
    return (
        f"how {len(values)} recordings differ ({min(values):.2f} to {max(values):.2f});"
        f" a band from so few is {times:.1f} times their standard deviation of {scatter:.2f}"
    )


def next_steps(diagnosis: Diagnosis, outcome: FrictionOutcome) -> list[str]:
    """What comes next, most urgent first, at most `MAX_STEPS` phrases; else what narrows the ±."""
    tracks = outcome.tracks_of()
    steps = []
    if diagnosis.notes and diagnosis.notes[0].startswith(SUSPECTED):
        steps.append("mend the input that looks wrong, or leave its recording out, and run this again")
    elif doubts(diagnosis):
        steps.append(CHECKS[diagnosis.of_car])
    never = [name for name, track in tracks.items() if track.last_usable is None]
    # A model that misses more than it has found is why friction is not known.
    if never and not rest_is_larger(diagnosis):
        steps.append(
            f"record {listed(never)} again, turning to and fro until the wheel slides both ways"
        )
    if len(diagnosis.recordings) + len(diagnosis.holdout) == 1:
        steps.append("make a second recording, without which nothing judges the result")
    like_load = [plain(e.name) for e in diagnosis.effects if UNRECORDED_LOAD in e.indistinguishable_from]
    if like_load:
        steps.append(
            f"record the load, as one that changes with the angle would look like {listed(like_load)}"
        )
    apart, unrefitted = told_apart(diagnosis), unrefitted_error(diagnosis)
    proposed = f"stands under “Next recording”: expected to tell {apart}"
    if diagnosis.unexplained.present:
        steps.append(
            "as something unknown remains, record at other speeds, angles and loads"
            + f", first what {proposed}" * bool(apart)
        )
    elif unrefitted is not None:
        steps.append(
            "check that the validation recordings are of the same wheel, load and ground, as with"
            f" nothing adjusted to them the error is {percent(unrefitted)} of range"
        )
    elif apart:
        steps.append(f"record what {proposed}")
    if unconfirmed := [plain(e.name) for e in diagnosis.effects if is_unconfirmed(e)]:
        steps.append(
            "fit a recording of each ground (with --holdout, leave that out), which settles whether"
            f" {listed(unconfirmed)} is there"
        )
    weak = [plain(e.name) for e in diagnosis.effects if e.grade in ("weak", "stands_in")]
    if weak and not steps:
        steps.append(f"make more recordings, which settle whether {listed(weak)} is there")
    assumed = any(note.startswith(ASSUMED) for note in diagnosis.notes)
    what = "the other values that are" if doubts(diagnosis) else "what is"
    to_declare = [f"at the rig, measure {what} assumed, and declare the tolerance"] * assumed
    more = _more_recordings(outcome)
    if not steps and (band_shares(outcome) or not [*more, *to_declare]):
        steps = [_to_narrow(diagnosis, outcome)]
    return [*steps[: MAX_STEPS - len(more)], *more, *to_declare][:MAX_STEPS]


def _more_recordings(outcome: FrictionOutcome) -> list[str]:
    """That more recordings narrow the widest ± of those that are wide by how recordings differ."""
    wide = {g: one for g, one in outcome.further().items() if (one.scatter_share or 0.0) > 0.5}
    if not wide:
        return []
    ground, one = max(wide.items(), key=lambda own: own[1].further or 0.0)
    count, half = one.recordings, one.further or 0.0
    return [
        f"record {ground} {count} more times, at the load that matters: ± {half:.2f} would come to about"
        f" ± {one.further_with(2 * count):.2f} if they differ as much"
    ]


def _to_narrow(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """What narrows the ± of friction, and what no recording would settle."""
    cause = next(iter(band_shares(outcome)), "")
    narrower = f"to narrow the ±, {narrowed_by(cause)}{_at_best(outcome, cause)}" if cause else "nothing"
    rest = [not_separable(e) for e in diagnosis.effects if e.experiment]
    if all(e.grade != "ambiguous" for e in diagnosis.effects):
        rest.append("no further recording is needed to find the model")
    return "; ".join([narrower, *rest])


def not_separable(effect: FoundEffect) -> str:
    """That recordings do not settle which of several effects it is."""
    rivals = effect.indistinguishable_from or tuple(e.rival for e in (effect.experiment,) if e)
    others = listed([plain(name) for name in rivals], "or")
    return f"more recordings on this rig would not tell {plain(effect.name)} from {others}"


def told_apart(diagnosis: Diagnosis) -> str:
    """Which effects the proposed recordings would tell from which, and from which not."""
    proposed = proposed_recordings(diagnosis)
    pairs = [f"{plain(e.name)} from {plain(p.rival)} ({at})" for at, (e, p) in proposed.items()]
    more = any(set(e.indistinguishable_from) - {p.rival} for e, p in proposed.values())
    return listed(pairs) + "; other explanations stay possible" * more


def _at_best(outcome: FrictionOutcome, cause: str) -> str:
    """What the band of the only ground is without what a remedy addresses; empty for several grounds."""
    further = [one.further for one in outcome.further().values()]
    if len(outcome.grounds) > 1 or not further or further[0] is None:
        return ""
    own = (known for ground in outcome.grounds for known in outcome.known_tracks(ground))
    shares, squares = band_shares(outcome), [float(track.mu_std[at]) ** 2 for track, at in own]
    best = sqrt(max(0.0, further[0] ** 2 - shares[cause] * BAND_95**2 * fmean(squares)))
    digits = band_decimals(further[0])
    return f", which brings ± {further[0]:.{digits}f} to ± {best:.{digits}f} at best"


def _on_ground(outcome: FrictionOutcome, ground: str) -> str:
    """Friction on a ground in a phrase: for a further recording, or else of each."""
    where, further = f" on {ground}" * bool(ground), outcome.further().get(ground)
    if further and further.further is not None:
        by, count = further.recordings, len(outcome.grounds[ground])
        some = f" (by {by} of {count} recordings)" * (by < count)
        return f"{prediction_band(further)}{where}{some}"
    known = sorted(outcome.known_tracks(ground), key=lambda own: own[0].mu[own[1]])
    values = [f"{last_usable_friction(track)} ({track.name})" for track, _ in known]
    if len(values) > MAX_LISTED:
        return f"{values[0]} to {values[-1]}{where} in {len(values)} recordings"
    return (listed(values) or "not known") + where


def _open_questions(diagnosis: Diagnosis, outcome: FrictionOutcome) -> list[str]:
    """What the recordings leave open, each in a phrase."""
    parts = []
    tracks = outcome.tracks_of().values()
    if never := [track.name for track in tracks if track.last_usable is None]:
        parts.append(f"friction in {listed(never)}")
    ending = [t for t in tracks if t.last_usable not in (None, t.t.size - 1)]
    if early := [f"{t.name} after {t.t[t.last_usable]:.1f} s" for t in ending]:
        parts.append(f"friction in {listed(early)}")
    for e in diagnosis.effects:
        rivals = listed([plain(name) for name in (e.name, *e.indistinguishable_from)], "or")
        if e.grade == "ambiguous" and several_mechanisms(e):
            parts.append(f"which of {rivals} it is")
    if unconfirmed := [plain(e.name) for e in diagnosis.effects if is_unconfirmed(e)]:
        parts.append(f"whether {listed(unconfirmed)} is there, as only the fitted recordings demand it")
    hints = [e for e in diagnosis.effects if e.grade == "weak" and not is_unconfirmed(e)]
    if weak := [plain(e.name) for e in hints]:
        parts.append(f"whether the weak signs of {listed(weak)} are chance")
    if odd := [plain(e.name) for e in diagnosis.effects if e.grade == "stands_in"]:
        parts.append(f"what {listed(odd)} stand{'s' * (len(odd) == 1)} in for")
    if diagnosis.unexplained.present and not missing_effects(diagnosis):
        parts.append(f"what makes {percent(diagnosis.unexplained.structured)} of range")
    return parts
