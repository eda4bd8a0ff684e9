"""Friction of a diagnosis in words: each recording and ground, what the figures mean, a text to send."""

from collections.abc import Callable, Mapping

from brushgrip.estimation.estimates import FrictionTrack
from brushgrip.estimation.friction_outcome import FIGURES, FOUND, FrictionOutcome
from brushgrip.wording.formatting import error_percentages, listed, percent, plain
from brushgrip.wording.friction import band, meaning
from brushgrip.wording.verdict import GRADES
from identification import Diagnosis

MOST_NAMED = 3
"""Recordings of a ground that are named one by one."""
GROUP_LABELS = {"training": "training", "holdout": "held out"}
"""Labels of `FrictionOutcome.groups`."""


def known_friction(track: FrictionTrack) -> str:
    """Friction by the last usable sample with its 95 % band; a dash where there is none."""
    at = track.last_usable
    return "–" if at is None else band(float(track.mu[at]), float(track.mu_std[at]))


def usable_until(track: FrictionTrack) -> str:
    """How much of a track is usable, until when, and what is wrong at its end."""
    at, end = track.last_usable, track.t.size - 1
    if at == end:
        return f"{_share(track)}, to the end"
    why = meaning(track.last_status)
    if at is None and track.usable.any():
        since = f"{track.changes[-1]:.1f} s"
        return f"{_share(track)}, but not since a new ground was noticed at {since}: {why}"
    if at is None:
        return f"never: {why}"
    return f"{_share(track)}, to {track.t[at]:.1f} of {track.t[end]:.1f} s: {why}"


def _share(track: FrictionTrack) -> str:
    return f"{100 * track.usable.mean():.0f} %"


def friction_of_ground(outcome: FrictionOutcome, ground: str) -> str:
    """Friction of the recordings on a ground, in one phrase; those without a usable sample are named."""
    tracks = outcome.by(FOUND)
    own = [tracks[name] for name in outcome.grounds[ground] if name in tracks]
    known = sorted((t for t in own if t.last_usable is not None), key=lambda t: t.mu[t.last_usable])
    never = [t.name for t in own if t.last_usable is None]
    parts = []
    if known:
        values = [f"{known_friction(track)} ({track.name})" for track in known]
        if len(known) <= MOST_NAMED:
            parts.append(listed(values))
        else:
            parts.append(f"{values[0]} to {values[-1]} in {len(known)} recordings")
    if never:
        parts.append(f"not known in {listed(never)}")
    return "; ".join(parts)


def _percent(share: float | None, digits: int) -> str:
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def _seconds(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f} s"


_WORDS: Mapping[str, tuple[str, Callable[[float | None], str], str]] = {
    "settling": (
        "time to settle",
        _seconds,
        "From then on the estimate stays within 10 % of where it ends.",
    ),
    "drift": (
        "movement after half-time",
        lambda share: _percent(share, 0),
        "Largest minus smallest estimate in the second half of a recording, over the last one.",
    ),
    "relative_band": (
        "standard deviation",
        lambda share: _percent(share, 1),
        "As a share of μ_eff, median of the informed samples: the 95 % band reaches twice as far to"
        " either side.",
    ),
    "coverage": (
        "bands that hold the end",
        lambda share: _percent(share, 0),
        "Share of the informed samples whose 95 % band holds the last estimate. Far below 95 % the bands"
        " are too narrow. The filter is compared with itself: necessary, no evidence of accuracy.",
    ),
    "reference_coverage": (
        "bands that hold the fit",
        lambda share: _percent(share, 0),
        "The same for the friction that was afterwards fitted to the whole recording: independent of the"
        " filter, not of the recording.",
    ),
}
"""Label, text and meaning of each of `FIGURES`."""


def friction_groups(outcome: FrictionOutcome) -> list[str]:
    """Labels of the groups that `friction_figures` has values of: those held out first."""
    return [GROUP_LABELS[group] for group in list(outcome.groups())[::-1]]


def friction_figures(outcome: FrictionOutcome) -> list[tuple[str, list[str], str]]:
    """Rows of a table: a label, the figure before → after for each group, and what it means."""
    rows = []
    groups = list(outcome.groups().values())[::-1]
    stages = outcome.stages.values()
    for figure in FIGURES:
        label, text, words = _WORDS[figure]
        means = [[text(outcome.means(stage, names)[figure]) for stage in stages] for names in groups]
        rows.append((label, [" → ".join(pair) for pair in means], words))
    return rows


def ground_spreads(outcome: FrictionOutcome) -> str:
    """How much the recordings on each ground differ, in a sentence; empty where that is not known."""
    before, after = (outcome.spread(stage) for stage in outcome.stages.values())
    parts = [
        f"{_percent(before[ground], 1)} → {_percent(after[ground], 1)} on {ground}"
        for ground in before
        if before[ground] is not None
    ]
    if not parts:
        return ""
    return (
        f"Between recordings the last estimates differ by {listed(parts)}: their standard deviation over"
        " their mean, all recordings."
    )


def paragraph_to_send(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """What came out, in words for somebody who knows no tyre model."""
    count = len(outcome.before)
    early = [t.name for t in outcome.by(FOUND).values() if t.last_usable not in (None, t.t.size - 1)]
    parts = [
        f"From {count} recording{'s' * (count != 1)} of a wheel that was steered while standing still:"
        " the coefficient of friction between tyre and ground is"
        f" {'; '.join(_on_ground(outcome, ground) for ground in outcome.grounds)}."
        " The ± is the 95 % band: it holds the true value in 95 of 100 cases, as far as loads, lengths"
        " and the model's error are stated rightly.",
        f"Of {listed(early)} it is the last value that could be relied on." if early else "",
        *_causes(diagnosis),
        _errors(diagnosis),
    ]
    return " ".join(filter(None, parts))


def _on_ground(outcome: FrictionOutcome, ground: str) -> str:
    return f"{f'on {ground} ' if ground else ''}{friction_of_ground(outcome, ground)}"


def _causes(diagnosis: Diagnosis) -> list[str]:
    """What the model lacks, each only as sure as its grade."""
    by_grade = {grade: [e for e in diagnosis.effects if e.grade == grade] for grade in GRADES}
    clear = [*by_grade["strong"], *by_grade["ambiguous"]]
    sentences = []
    if clear:
        causes = [f"{plain(e.name)} ({e.summary.partition(';')[0]})" for e in clear]
        sentences.append(f"The tyre model as it was declared leaves out {listed(causes)}.")
    for e in by_grade["ambiguous"]:
        rivals = listed([plain(name) for name in e.indistinguishable_from], "or")
        sentences.append(f"These recordings do not tell {plain(e.name)} from {rivals}.")
    if weak := [plain(e.name) for e in by_grade["weak"]]:
        sentences.append(f"There are weak signs of {listed(weak)}, which may be chance.")
    if odd := [plain(e.name) for e in by_grade["stands_in"]]:
        sentences.append(f"Something unknown was described by {listed(odd)}.")
    return sentences


def _errors(diagnosis: Diagnosis) -> str:
    """Error before and after, what judged it, and what is left."""
    kind, before, after = error_percentages(diagnosis)
    judged = {
        "held-out": "on recordings that the tyre's parameters were not fitted to,"
        " though they chose the effects",
        "left-out": "on each recording by the parameters of the others",
        "training": "on the very recordings that it was fitted to, as none was left to judge it",
    }[kind]
    size = f"{after} of its range instead of {before}" if diagnosis.effects else f"{after} of its range"
    rest = diagnosis.unexplained
    left = (
        f"{percent(rest.structured)} of range remain that no known effect explains."
        if rest.present
        else "What remains looks like the sensor's noise."
    )
    return f"The model now predicts the torque to {size}, {judged}. {left}"
