"""Friction of a diagnosis in words: each recording, and what the figures mean."""

from collections.abc import Mapping, Sequence
from itertools import chain, combinations

import numpy as np

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.wording.formatting import band_decimals, listed, sentence
from brushgrip.wording.friction_in_words import status_in_words, with_95_band
from identification import Diagnosis
from identification.residuals.full_slide_repeatability import SAME_LOAD
from observers import GroundFriction, Status
from observers.planning.uncertainty_budget import REST, SLOPE
from observers.quality.friction_across_recordings import kendall_load_test
from observers.tuning import OF_LENGTHS, OF_LOAD, OF_SCALE, OF_TUNING

IN_PLAIN_WORDS = {
    SLOPE: "that the tyre may be stiffer or softer than its parameters say",
    REST: "noise of the torque, and what the model gets wrong",
    OF_LENGTHS: "what the lengths of contact and caster may be off",
    OF_LOAD: "what the load may be off",
    OF_SCALE: "that the torque's scale may be off, as the tread stiffness is not the declared one",
    OF_TUNING: "a reserve for errors that nobody declared",
}
"""Causes of a band for somebody who knows no tyre model."""
GROUP_LABELS = {"training": "training", "holdout": "validation"}
"""Labels of `FrictionByBothModels.names_by_group`."""


LEAST_TOLD = 0.5
"""Percentage of a band from which on a part of it is told."""
OVER_TIME = "friction over time"
"""Family of effects by which friction changes within a recording."""
UNEXPLAINED = 0.2
"""Share of the turn that is not explained from which on that is why nothing is usable [1]."""
MAX_PAIRS = 3
"""Pairs of grounds whose ratios are all told."""
MAX_TOLD, CHANCE = 6, 0.01
"""Recordings of a ground whose loads are told; chance up to which an order is told [1]."""


def last_usable_friction_text(track: FrictionTrack) -> str:
    """Friction by the last usable sample with its 95 % band; a dash where there is none."""
    at = track.last_usable
    return "–" if at is None else with_95_band(float(track.mu[at]), float(track.mu_std[at]))


def variance_shares_by_cause(
    outcome: FrictionByBothModels, ground: str | None = None
) -> dict[str, float]:
    """Shares of the variance of the last usable friction by cause, on a ground or on all [1]."""
    squares: dict[str, float] = {}
    grounds = outcome.grounds if ground is None else [ground]
    for track, _ in chain.from_iterable(map(outcome.known_tracks, grounds)):
        for cause, half in track.budget.items():
            squares[cause] = squares.get(cause, 0.0) + half**2
    whole = sum(squares.values())
    return {cause: square / whole for cause, square in sorted(squares.items(), key=lambda s: -s[1])}


def causes_of_band_text(outcome: FrictionByBothModels) -> str:
    """What the bands are made of, and what of it all recordings share; empty where that is not known."""
    shares = variance_shares_by_cause(outcome)
    if not shares:
        return ""
    without = {cause: 100 * (1 - np.sqrt(1 - share)) for cause, share in shares.items()}
    told = {cause: less for cause, less in without.items() if less >= LEAST_TOLD}
    parts = [f"{IN_PLAIN_WORDS.get(cause, cause)}, {less:.0f} %" for cause, less in told.items()]
    line = (
        "What makes the ± of a recording wide, and by how much it would be smaller without that alone:"
        f" {'; '.join(parts)} (these do not add up to 100 %)."
    )
    if outcome.prediction_band_by_ground():
        line = f"The ± of a ground also covers how its recordings differ. {line}"
    measurable = min(1.0, sum(shares.get(cause, 0.0) for cause in (OF_LENGTHS, OF_LOAD)))
    if len(outcome.before) > 1 and not told.keys().isdisjoint((OF_LENGTHS, OF_LOAD)):
        line += (
            " All recordings share the errors of lengths and load; without both it would be"
            f" {100 * (1 - np.sqrt(1 - measurable)):.0f} % smaller."
        )
    return line


def usable_span_text(track: FrictionTrack) -> str:
    """From when to when a track is usable, and what is wrong at its end."""
    at, end = track.last_usable, track.t.size - 1
    if at is not None:
        first = track.usable_since
        gaps = " with gaps" * (not track.usable[first : at + 1].all())
        since = f"from {track.t[first]:.1f} s"
    if at == end:
        return f"{since} to the end{gaps}"
    why = status_in_words(_why_not_usable(track))
    if at is not None:
        return f"{since} to {track.t[at]:.1f} of {track.t[end]:.1f} s{gaps}; then {why}"
    if not track.usable.any():
        return f"never: {why}"
    lasted = f"for {float(np.diff(track.t, append=track.t[-1])[track.usable].sum()):.1f} s only"
    if not track.changes.size:
        return f"{lasted}, but contradicted later: {status_in_words(Status.INCONSISTENT)}"
    return f"{lasted}, but not since a new ground was noticed at {track.changes[-1]:.1f} s: {why}"


def _why_not_usable(track: FrictionTrack) -> Status:
    """The last status of a track; of one that was never usable too that the model explains it too badly.

    What the model does not explain is not acquired either, however far the wheel slides.
    """
    inconsistent = track.inconsistent
    if track.usable.any() or inconsistent is None or Status.SUSPECT in track.last_status:
        return track.last_status
    turn = np.ones(inconsistent.size) if track.turn is None else track.turn
    unexplained = float(turn @ inconsistent) > UNEXPLAINED * float(turn.sum())
    return track.last_status | Status.INCONSISTENT if unexplained else track.last_status


def is_by_declared_vehicle(outcome: FrictionByBothModels, diagnosis: Diagnosis) -> bool:
    """Whether friction is told by a vehicle as declared, not by what was found."""
    return diagnosis.of_car and outcome.inclination is None


def model_behind_friction_text(outcome: FrictionByBothModels, diagnosis: Diagnosis) -> str:
    """What friction is told by: the model found, or the vehicle as declared."""
    declared = is_by_declared_vehicle(outcome, diagnosis)
    return f"by the {'vehicle as declared' if declared else 'model found'}"


def load_trend_in_words(outcome: FrictionByBothModels, diagnosis: Diagnosis) -> str:
    """That friction goes with the load from recording to recording, in sentences; else empty."""
    loads = median_loads(diagnosis)
    known = {
        ground: [(loads[t.name], t.mu[at]) for t, at in outcome.known_tracks(ground) if t.name in loads]
        for ground in filter(None, outcome.grounds)
    }
    chance, falls = kendall_load_test(list(known.values()))
    if chance > CHANCE:
        return ""
    ways = {ground: kendall_load_test([own]) for ground, own in known.items()}
    on = listed(
        [
            ground
            + f" ({', '.join(f'{mu:.2f} at {load:.0f} N' for load, mu in _thin_pairs(known[ground]))})"
            * (outcome.load is None)
            for ground, (alone, way) in ways.items()
            if alone < 1 and way == falls
        ]
    )
    told = f", though the model found tells it{common_load_text(outcome)}" * (outcome.load is not None)
    return (
        f"On {on}, recordings at higher load gave {'lower' if falls else 'higher'} friction{told}"
        f" (by chance in 1 of {1 / max(chance, 1e-6):.0f} cases);"
        " whether load is the cause is not known; the ± of the ground covers these loads, no others."
    )


def is_band_mostly_from_spread(friction: GroundFriction) -> bool:
    """Whether how recordings on a ground differ makes most of the variance of its band."""
    return (friction.scatter_share or 0.0) > 0.5


def _thin_pairs(values: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """At most `MAX_TOLD` of these pairs, in order, the ends among them."""
    ordered = sorted(values)
    at = np.linspace(0, len(ordered) - 1, min(len(ordered), MAX_TOLD)).round().astype(int)
    return [ordered[i] for i in at]


def common_load_text(outcome: FrictionByBothModels) -> str:
    """The load that all friction is told at, where it changes with the load; else empty."""
    return "" if outcome.load is None else f" at a load of {outcome.load:.0f} N"


def common_load_clause(outcome: FrictionByBothModels) -> str:
    """That all friction is told at one load, a clause after a value; else empty."""
    told = common_load_text(outcome).removeprefix(" at")
    return f"all converted to{told}, as friction changes with it" * bool(told)


def note_on_changing_friction(diagnosis: Diagnosis) -> str:
    """That friction changes in a recording by the model found, so that its figures tell that too."""
    if all(effect.family != OVER_TIME for effect in diagnosis.model.effects):
        return ""
    return (
        ". The model found lets friction change with time or travel: the figures after the arrow contain"
        " that change, and the fitted value is that of the end"
    )


def ground_comparison_text(outcome: FrictionByBothModels, diagnosis: Diagnosis) -> str:
    """By how much grounds differ, and which these recordings do not tell apart, in sentences.

    Of many grounds that differ, only over that of the least friction. Empty for fewer than two.
    """
    bands = dict(sorted(outcome.prediction_band_by_ground().items(), key=lambda own: own[1].mu_eff))
    pairs, same, more = list(combinations(bands, 2)), [], []
    for low, high in pairs:
        ratio, half = bands[high].ratio_to(bands[low], len(pairs))
        if ratio - half <= 1:
            same.append(f"{low} from {high}")
        elif len(pairs) <= MAX_PAIRS or low == next(iter(bands)):
            apart = _loads_differ_note(outcome, diagnosis, low, high)
            digits = band_decimals(half)
            more.append(
                f"{high} grips {ratio:.{digits}f} ± {half:.{digits}f} times as much as {low}{apart}"
            )
    sentences = []
    if more:
        share = "both" if len(bands) == 2 else "all"
        shared = f"errors of lengths, load, torque and stiffness that {share} share cancel"
        sentences.append(f"{sentence(listed(more)).removesuffix('.')} (in 95 of 100 cases; {shared}).")
    if same:
        chance = "the difference may be chance"
        sentences.append(f"These recordings do not tell {listed(same, 'or')}: {chance}.")
    return " ".join(sentences)


def _loads_differ_note(outcome: FrictionByBothModels, diagnosis: Diagnosis, *grounds: str) -> str:
    """That loads on two grounds are so far apart that they may be why friction differs; else empty."""
    loads = median_loads(diagnosis)
    low, high = sorted(
        [loads[track.name] for track, _ in outcome.known_tracks(ground) if track.name in loads]
        for ground in grounds
    )
    apart = bool(low and high) and min(high) > SAME_LOAD * max(low)
    return ", if it is not the load, which differs too" * apart


def median_loads(diagnosis: Diagnosis) -> dict[str, float]:
    """The median load of each recording that has one [N]."""
    loads = {s.name: s.F_N[np.isfinite(s.F_N)] for s in diagnosis.series}
    return {name: float(np.median(load)) for name, load in loads.items() if load.size}


def note_on_highest_loads(diagnosis: Diagnosis, names: Sequence[str]) -> str:
    """That several recordings, not all, have a higher median load than every other one; else empty."""
    loads = median_loads(diagnosis)
    own = [loads.pop(name, 0.0) for name in names]
    highest = len(own) > 1 and min(own) > max(loads.values(), default=np.inf)
    return "; theirs are the highest loads" * highest


def has_unusable_gap(outcome: FrictionByBothModels) -> bool:
    """Whether a track of the model found is not usable somewhere after its first usable sample."""
    tracks = outcome.tracks_of().values()
    return any((np.diff(track.usable.astype(int)) < 0).any() for track in tracks)


FIGURE_TEXTS: Mapping[str, tuple[str, float, str, str]] = {
    "settling": (
        "time to settle",
        *(1, "{:.1f} s"),
        "From then on the estimate stays within 10 % of where it ends.",
    ),
    "drift": (
        "movement after half-time",
        *(100, "{:.0f} %"),
        "Largest minus smallest estimate in the second half of a recording, divided by the last one.",
    ),
    "relative_band": (
        "standard deviation",
        *(100, "{:.1f} %"),
        "As a share of μ_eff, median of the informed samples: the 95 % band reaches twice as far to"
        " either side.",
    ),
    "reference_coverage": (
        "bands that hold the fitted value (no check)",
        *(100, "{:.0f} %"),
        "Share of the informed samples whose 95 % band holds the friction that was afterwards fitted to"
        " the whole recording, which is no independent measurement. Far below 95 % they are too narrow,"
        " at 100 % rather wide.",
    ),
}
"""Label, factor, text and meaning of those of `FIGURES` that compare the EKF with more than itself."""
