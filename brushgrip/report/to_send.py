"""The results for somebody who knows no tyre model: friction by ground, and a paragraph for a mail."""

from brushgrip.estimation.friction_outcome import EKF_FOUND, FrictionOutcome
from brushgrip.report.friction_words import band_shares, known_friction
from brushgrip.wording.formatting import error_percentages, listed, percent, plain
from brushgrip.wording.friction import further_band, further_recording
from identification import Diagnosis, FoundEffect
from observers.planning.uncertainty_budget import REST, SLOPE
from observers.quality.tolerances import OF_LENGTHS, OF_LOAD, OF_TUNING
from symbolic import EFFECTS

IN_PLAIN_WORDS = {
    SLOPE: "the torque rises with the angle otherwise than the tyre's stiffness says",
    REST: "noise of the torque, and what the model gets wrong",
    OF_LENGTHS: "how well the length of the contact patch is known",
    OF_LOAD: "how well the load is known",
    OF_TUNING: "a share that is always added",
}
"""Causes of a band for somebody who knows no tyre model."""
MAX_LISTED = 3
"""Recordings of a ground that are named one by one."""


def friction_lines(outcome: FrictionOutcome | None) -> list[str]:
    """Friction of each named ground for a further recording, a line each; none without an outcome."""
    if outcome is None:
        return []
    further = outcome.further()
    grounds = {ground: len(names) for ground, names in outcome.grounds.items() if ground}
    return [further_recording(ground, further.get(ground), count) for ground, count in grounds.items()]


def paragraph_to_send(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """Friction by ground, the cause, the error before and after, and what is not known."""
    count, further = len(outcome.before), [g.further for g in outcome.further().values()]
    one_more = ", and that of one further recording made like these," * any(further)
    return " ".join(
        [
            "The coefficient of friction between tyre and ground is"
            f" {'; '.join(_on_ground(outcome, ground) for ground in outcome.grounds)}, from"
            f" {count} recording{'s' * (count != 1)} of a wheel that was steered while it stood still."
            " For comparison: ice has about 0.1, dry asphalt about 1.",
            f"In 95 of 100 cases the true value{one_more} lies within the ±, as far as loads, lengths"
            " and the model's error are stated rightly.",
            *_widest(outcome),
            *_cause(diagnosis),
            _errors(diagnosis),
            *_unknown(diagnosis, outcome),
            next_step(diagnosis, outcome),
        ]
    )


def _widest(outcome: FrictionOutcome) -> list[str]:
    """What most of the bands comes from, in one sentence; none where that is not known."""
    shares = band_shares(outcome)
    cause = next(iter(shares), "")
    if cause not in IN_PLAIN_WORDS:
        return [f"The largest part of the ± comes from this: {cause}."] if cause else []
    return [f"The largest part of the ± comes from this: {IN_PLAIN_WORDS[cause]}."]


def next_step(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """The measurement or the action that comes next, the most urgent alone, in one sentence."""
    tracks = outcome.tracks_of(EKF_FOUND)
    if never := [name for name, track in tracks.items() if track.last_usable is None]:
        return (
            f"Next: record {listed(never)} again, turning to and fro until the wheel slides both ways."
        )
    if len(tracks) == 1:
        return "Next: a second recording, without which nothing judges the result."
    if diagnosis.unexplained.present:
        return (
            "Next: recordings at other speeds, angles and loads, as something unknown remains; until"
            " then keep to the bands and rely on no cause."
        )
    tests = [e for e in diagnosis.effects if e.experiment and e.experiment.times is not None]
    if tests:
        rivals = listed(
            [plain(name) for name in (tests[0].name, *tests[0].indistinguishable_from)], "or"
        )
        return f"Next: the recording that the report proposes, which tells {rivals} apart."
    if weak := [plain(e.name) for e in diagnosis.effects if e.grade in ("weak", "stands_in")]:
        return f"Next: more recordings, which settle whether {listed(weak)} is there."
    return (
        "Next: nothing has to be measured; brushgrip estimate --model model.json gives the friction of"
        " recordings made like these."
    )


def _on_ground(outcome: FrictionOutcome, ground: str) -> str:
    """Friction on a ground in a phrase: for a further recording, or else of each."""
    where, further = f"on {ground} " * bool(ground), outcome.further().get(ground)
    if further and further.further is not None:
        of = f" (from {further.recordings} recordings)" * (further.recordings < len(outcome.before))
        return f"{where}{further_band(further)}{of}"
    tracks = outcome.tracks_of(EKF_FOUND)
    own = [tracks[name] for name in outcome.grounds[ground] if name in tracks]
    known = sorted((t for t in own if t.last_usable is not None), key=lambda t: t.mu[t.last_usable])
    values = [f"{known_friction(track)} ({track.name})" for track in known]
    if len(values) > MAX_LISTED:
        return f"{where}{values[0]} to {values[-1]} in {len(values)} recordings"
    return where + (listed(values) or "not known")


def _cause(diagnosis: Diagnosis) -> list[str]:
    """Missing effects that are certain, in one sentence."""
    clear = [e for e in diagnosis.effects if e.grade in ("strong", "ambiguous")]
    found = {e.name for e in clear}
    causes = []
    for e in clear:
        # What was found beside it needs no second mention.
        names = [e.name, *(name for name in e.indistinguishable_from if name not in found)]
        causes.append(listed([_explained(name, e) for name in names], "or"))
    return [f"The tyre model as it was declared leaves out {listed(causes)}."] if clear else []


def _explained(name: str, found: FoundEffect) -> str:
    """An effect, or one that a found one cannot be told from, with what it is."""
    known = found.summary if name == found.name else EFFECTS[name].summary if name in EFFECTS else ""
    return f"{plain(name)} ({known.partition(';')[0]})" if known else plain(name)


def _errors(diagnosis: Diagnosis) -> str:
    """Error before and after, and what judged it."""
    kind, before, after = error_percentages(diagnosis)
    judged = {
        "validation": "on recordings to which the tyre's parameters were not fitted, though they chose"
        " the effects",
        "left-out": "on each recording with the parameters that the others gave",
        "training": "on the very recordings that it was fitted to, as none was left to judge it",
    }[kind]
    size = f"{after} of its range"
    if diagnosis.effects:
        size += f", {before} without what was found"
    return f"The model now predicts the steering torque to {size}, {judged}."


def _unknown(diagnosis: Diagnosis, outcome: FrictionOutcome) -> list[str]:
    """Open questions in one sentence; none where nothing is open."""
    parts = []
    tracks = outcome.tracks_of(EKF_FOUND).values()
    if never := [track.name for track in tracks if track.last_usable is None]:
        parts.append(f"friction in {listed(never)}")
    if early := [t.name for t in tracks if t.last_usable not in (None, t.t.size - 1)]:
        parts.append(f"friction at the end of {listed(early)}, whose last value to rely on is earlier")
    for e in diagnosis.effects:
        if e.grade == "ambiguous":
            rivals = listed([plain(name) for name in (e.name, *e.indistinguishable_from)], "or")
            parts.append(f"which of {rivals} it is")
    if weak := [plain(e.name) for e in diagnosis.effects if e.grade == "weak"]:
        parts.append(f"whether the weak signs of {listed(weak)} are chance")
    if odd := [plain(e.name) for e in diagnosis.effects if e.grade == "stands_in"]:
        parts.append(f"what {listed(odd)} stand{'s' * (len(odd) == 1)} in for")
    if diagnosis.unexplained.present:
        parts.append(
            f"what makes the {percent(diagnosis.unexplained.structured)} of range that no known effect"
            " explains"
        )
    return [f"Not known: {'; '.join(parts)}."] if parts else []
