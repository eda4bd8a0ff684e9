"""The results for somebody who knows no tyre model: friction by ground, and a paragraph for a mail."""

from collections.abc import Iterable
from math import sqrt
from statistics import fmean

from brushgrip.estimation.estimates import FrictionTrack
from brushgrip.estimation.friction_before_and_after import EKF_FOUND, FrictionOutcome
from brushgrip.report.friction_summary import band_shares, last_usable_friction
from brushgrip.report.scope import missing_effects, reservation, several_mechanisms, validity
from brushgrip.wording.diagnosis_in_words import is_unconfirmed, rest_is_larger
from brushgrip.wording.formatting import band_decimals, listed, percent, plain, unrefitted_error
from brushgrip.wording.friction import further_recording, narrowed_by, prediction_band
from identification import Diagnosis, FoundEffect
from identification.diagnosis.found_effects import OFF_STIFFNESS, UNRECORDED_LOAD
from observers import GroundFriction
from observers.planning.uncertainty_budget import SLOPE
from observers.quality.settling_and_coverage import BAND_95
from observers.quality.tolerances import OF_LENGTHS

MAX_LISTED = 3
"""Recordings of a ground that are named one by one."""
IN_FURTHER = "in 95 of 100 further recordings of this kind on this ground"
ADDRESSED = {SLOPE: (SLOPE, OF_LENGTHS)}
"""Parts of a band that a remedy lowers, where they are more than the one that it is of."""


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


def friction_statements(outcome: FrictionOutcome | None) -> list[tuple[str, str]]:
    """For a page: friction of each ground that has a band, and what it is of, or that none is known."""
    if outcome is None:
        return []
    further = outcome.further()
    never = [ground for ground in filter(None, outcome.grounds) if ground not in further]
    return [
        (
            f"{ground}: friction {prediction_band(one)}{at_speed(outcome)}",
            _next_recording(outcome, ground, one),
        )
        for ground, one in further.items()
        if one.further is not None
    ] + [
        (f"{ground}: friction not known", "no recording on it ends with a value to rely on")
        for ground in never
    ]


def at_speed(outcome: FrictionOutcome) -> str:
    """The sliding speed that friction is stated at, behind a blank; empty where unknown."""
    return f" at {1e3 * outcome.slide_speed:.2g} mm/s sliding" if outcome.slide_speed else ""


def _next_recording(outcome: FrictionOutcome, ground: str, friction: GroundFriction) -> str:
    """Ends of the band, what lies between them, and how far the recordings differ."""
    half = friction.further or 0.0
    # Of the rounded figures, so that they agree with the ± beside them.
    middle, half = round(friction.mu_eff, 2), round(half, 2)
    low, high = max(0.0, middle - half), middle + half
    tracks = [outcome.tracks_of(EKF_FOUND)[name] for name in outcome.grounds[ground]]
    known = [float(t.mu[t.last_usable]) for t in tracks if t.last_usable is not None]
    early = "".join(f", {t.name} up to {t.t[t.last_usable]:.1f} s" for t in _ending_early(tracks))
    return (
        f"between {low:.2f} and {high:.2f} {IN_FURTHER}; its {friction.recordings} recordings gave"
        f" {min(known):.2f} to {max(known):.2f}{early}"
    )


def _ending_early(tracks: Iterable[FrictionTrack]) -> list[FrictionTrack]:
    """Tracks whose last usable sample is not their last."""
    return [track for track in tracks if track.last_usable not in (None, track.t.size - 1)]


def paragraph_to_send(diagnosis: Diagnosis, outcome: FrictionOutcome, warning: str = "") -> str:
    """Friction by ground, what it holds for, the cause, what is not known; a warning goes before all."""
    count, further = len(outcome.before), outcome.further()
    on_grounds = "; ".join(_on_ground(outcome, ground) for ground in outcome.grounds)
    friction = (
        f"Friction between tyre and ground{at_speed(outcome)} is {on_grounds}; from {count}"
        f" recording{'s' * (count != 1)}"
    )
    known = any(track.last_usable is not None for track in outcome.tracks_of(EKF_FOUND).values())
    if known:
        bands = [one.further is not None for one in further.values()]
        within = [IN_FURTHER] * any(bands)
        if len(further) < len(outcome.grounds) or not all(bands):
            named = " where a recording is named" * any(bands)
            within.append(f"the true value{named} in 95 of 100 cases")
        friction += f" (ice has about 0.1, dry asphalt about 1); the ± holds {', and '.join(within)}"
    sentences = [
        warning,
        f"{friction}.",
        reservation(diagnosis) * known,
        validity(diagnosis),
        missing_effects(diagnosis),
        _open_and_next(diagnosis, outcome),
    ]
    return " ".join(filter(None, sentences))


def next_step(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """The measurement or the action that comes next, the most urgent alone, in one sentence."""
    tracks = outcome.tracks_of(EKF_FOUND)
    never = [name for name, track in tracks.items() if track.last_usable is None]
    # A model that misses more than it has found is why friction is not known.
    if never and not rest_is_larger(diagnosis):
        return (
            f"Next: record {listed(never)} again, turning to and fro until the wheel slides both ways."
        )
    if any(note.startswith(OFF_STIFFNESS) for note in diagnosis.notes):
        return "Next: check the torque with a weight, the load and the half-length, and declare k."
    if len(tracks) == 1:
        return "Next: a second recording, without which nothing judges the result."
    if like_load := [
        plain(e.name) for e in diagnosis.effects if UNRECORDED_LOAD in e.indistinguishable_from
    ]:
        return (
            "Next: record the load, as one that changes with the angle would look like"
            f" {listed(like_load)}."
        )
    if diagnosis.unexplained.present:
        proposed = any(e.experiment and e.experiment.feasible for e in diagnosis.effects)
        return (
            "Next: recordings at other speeds, angles and loads"
            f"{', such as the report proposes,' * proposed} as something unknown remains."
        )
    if (error := unrefitted_error(diagnosis)) is not None:
        return (
            "Next: check that the validation recordings are of the same wheel, load and ground, as with"
            f" nothing adjusted to them the error is {percent(error)} of range."
        )
    tests = [e for e in diagnosis.effects if e.experiment and e.experiment.feasible]
    if tests:
        rivals = listed(
            [plain(name) for name in (tests[0].name, *tests[0].indistinguishable_from)], "or"
        )
        return f"Next: the recording that the report proposes, which tells {rivals} apart."
    if unconfirmed := [plain(e.name) for e in diagnosis.effects if is_unconfirmed(e)]:
        return (
            "Next: fit a recording of each ground (with --holdout, leave that out), which settles"
            f" whether {listed(unconfirmed)} is there."
        )
    if weak := [plain(e.name) for e in diagnosis.effects if e.grade in ("weak", "stands_in")]:
        return f"Next: more recordings, which settle whether {listed(weak)} is there."
    cause = next(iter(band_shares(outcome)), "")
    narrower = (
        f"to narrow the ±, {narrowed_by(cause, with_model=True)}{_at_best(outcome, cause)}"
        if cause
        else "nothing"
    )
    rest = [not_separable(e) for e in diagnosis.effects if e.experiment]
    if all(e.grade != "ambiguous" for e in diagnosis.effects):
        rest.append("no further recording is needed to find the model")
    return f"Next: {'; '.join([narrower, *rest])}."


def not_separable(effect: FoundEffect) -> str:
    """That recordings do not settle which of several effects it is."""
    rivals = effect.indistinguishable_from or tuple(e.rival for e in (effect.experiment,) if e)
    others = listed([plain(name) for name in rivals], "or")
    return f"more recordings on this rig would not tell {plain(effect.name)} from {others}"


def told_apart(diagnosis: Diagnosis) -> str:
    """Which effects the proposed recordings would tell from which, and from which not."""
    proposals = [(e, e.experiment) for e in diagnosis.effects if e.experiment and e.experiment.feasible]
    pairs = [f"{plain(e.name)} from {plain(proposal.rival)}" for e, proposal in proposals]
    more = any(set(e.indistinguishable_from) - {proposal.rival} for e, proposal in proposals)
    return listed(pairs) + "; other explanations stay open" * more


def _at_best(outcome: FrictionOutcome, cause: str) -> str:
    """What the band of the only ground is without what a remedy addresses; empty for several grounds."""
    further = [one.further for one in outcome.further().values()]
    if len(outcome.grounds) > 1 or not further or further[0] is None:
        return ""
    shares, own = band_shares(outcome), outcome.tracks_of(EKF_FOUND).values()
    share = sum(shares.get(name, 0.0) for name in ADDRESSED.get(cause, (cause,)))
    squares = [float(t.mu_std[t.last_usable]) ** 2 for t in own if t.last_usable is not None]
    best = sqrt(max(0.0, further[0] ** 2 - share * BAND_95**2 * fmean(squares)))
    digits = band_decimals(further[0])
    return f", which brings ± {further[0]:.{digits}f} to ± {best:.{digits}f} at best"


def _on_ground(outcome: FrictionOutcome, ground: str) -> str:
    """Friction on a ground in a phrase: for a further recording, or else of each."""
    where, further = f" on {ground}" * bool(ground), outcome.further().get(ground)
    if further and further.further is not None:
        by, count = further.recordings, len(outcome.grounds[ground])
        some = f" (by {by} of {count} recordings)" * (by < count)
        return f"{prediction_band(further)}{where}{some}"
    tracks = outcome.tracks_of(EKF_FOUND)
    own = [tracks[name] for name in outcome.grounds[ground] if name in tracks]
    known = sorted((t for t in own if t.last_usable is not None), key=lambda t: t.mu[t.last_usable])
    values = [f"{last_usable_friction(track)} ({track.name})" for track in known]
    if len(values) > MAX_LISTED:
        return f"{values[0]} to {values[-1]}{where} in {len(values)} recordings"
    return (listed(values) or "not known") + where


def _open_and_next(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """Open questions, where there are any, and what comes next, in one sentence."""
    parts = []
    tracks = outcome.tracks_of(EKF_FOUND).values()
    if never := [track.name for track in tracks if track.last_usable is None]:
        parts.append(f"friction in {listed(never)}")
    if early := [f"{t.name} after {t.t[t.last_usable]:.1f} s" for t in _ending_early(tracks)]:
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
    then = next_step(diagnosis, outcome)
    return f"Not known: {'; '.join(parts)}; n{then[1:]}" if parts else then
