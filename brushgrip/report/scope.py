"""What a report's friction is valid for, and what the model found changes, in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from brushgrip.estimation.estimates import FrictionTrack
from brushgrip.estimation.friction_before_and_after import EKF_DECLARED, EKF_FOUND, FrictionOutcome
from brushgrip.outputs.provenance import digest_of
from brushgrip.published.bundled_files import demo_folder
from brushgrip.wording.diagnosis_in_words import CLEAR
from brushgrip.wording.formatting import judged_error_percentages, listed, plain
from identification import Diagnosis, FoundEffect
from observers.estimates import BAND_STDS
from symbolic import EFFECTS, InvalidInputError

MECHANISMS = {
    "friction over speed": "that friction changes with the speed of sliding",
    "friction over time": "that friction changes with time or with the angle turned",
    "friction over load": "that friction changes with the load",
    "friction over direction": "that friction differs by the direction of turning",
    "compliance and contact shape": "how the tyre's body yields, or how its pressure is spread",
    "sensor and steering": "what sensor and steering add to the torque",
}
"""What a model without a mechanism leaves out, for somebody who knows no tyre model."""


def simulated_warning(made: Mapping[str, Any] | None) -> str:
    """That recordings are the demo's, by their digests, in one sentence; empty where none is."""
    # Sources of own effects are inputs too.
    inputs = [file for file in (made["inputs"] if made else []) if not file["name"].endswith(".py")]
    try:
        bundled = {digest_of(path) for path in demo_folder().glob("*.csv")}
    except InvalidInputError:
        return ""
    count = sum(file["sha256"] in bundled for file in inputs)
    if not count:
        return ""
    which = "all" if count == len(inputs) else f"{count} of {len(inputs)}"
    return f"Simulated, not measured: {which} recordings come from brushgrip's demo."


def validity(diagnosis: Diagnosis) -> str:
    """What the friction holds for, in one line."""
    loads = [series.F_N[np.isfinite(series.F_N)] for series in diagnosis.series]
    known = np.concatenate(loads) if loads else np.empty(0)
    at = ""
    if known.size and not diagnosis.of_car:
        low, high = f"{known.min():.0f}", f"{known.max():.0f}"
        at = f", at a load of {low} N" if low == high else f", at loads of {low} to {high} N"
    return (
        f"Valid for a wheel that stands still and is turned as in these recordings{at}; not for driving"
        " speed, as friction changes with the speed of sliding."
    )


def missing_effects(diagnosis: Diagnosis) -> str:
    """What the declared model leaves out, in one sentence; empty where nothing is certain."""
    clear, weak = (
        list(dict.fromkeys(_cause(effect) for effect in diagnosis.effects if effect.grade in grades))
        for grades in (CLEAR, ("weak",))
    )
    hints = listed([cause for cause in weak if cause not in clear])
    unsure = f"; less surely, {hints}" * bool(hints)
    sentence = f"The tyre model that was assumed beforehand leaves out {listed(clear)}{unsure}."
    return sentence if clear else ""


def _cause(effect: FoundEffect) -> str:
    """The mechanism of an effect, or the effect; with those of other mechanisms that it may be."""
    names = (effect.name, *effect.indistinguishable_from)
    families = [effect.family, *(_family_of(name) for name in names[1:])]
    pairs = zip(families, names, strict=True)
    return listed(list(dict.fromkeys(MECHANISMS.get(f, plain(name)) for f, name in pairs)), "or")


def several_mechanisms(effect: FoundEffect) -> bool:
    """Whether an effect may be one of another mechanism."""
    return any(_family_of(name) != effect.family for name in effect.indistinguishable_from)


def _family_of(name: str) -> str:
    return EFFECTS[name].family if name in EFFECTS else "other"


def benefit(diagnosis: Diagnosis, outcome: FrictionOutcome) -> str:
    """What the model found changes for friction, in one sentence; empty where it changes nothing."""
    declared, found = (list(outcome.tracks_of(label).values()) for label in (EKF_DECLARED, EKF_FOUND))
    if diagnosis.of_car or not diagnosis.effects or not declared or not found:
        return ""
    return (
        f"With the assumed model friction is usable {_usable(declared)} of the time{_band(declared)},"
        f" with the model found {_usable(found)}{_band(found)}."
    )


def _usable(tracks: Sequence[FrictionTrack]) -> str:
    return _range([100 * track.usable_share for track in tracks], 0) + " %"


def _band(tracks: Sequence[FrictionTrack]) -> str:
    """Half-widths of the last usable bands."""
    halves = [
        BAND_STDS * float(track.mu_std[track.last_usable])
        for track in tracks
        if track.last_usable is not None
    ]
    return f" (± {_range(halves, 2)})" if halves and np.isfinite(halves).all() else ""


def _range(values: Sequence[float], digits: int) -> str:
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def error_to_quote(diagnosis: Diagnosis) -> str:
    """The one torque error to quote, what it was without the effects, and what judged it."""
    kind, before, after = judged_error_percentages(diagnosis)
    count = len(diagnosis.holdout)
    judged = {
        "validation": f"on {count} validation recording{'s' * (count != 1)}, which chose the effects but"
        " not the tyre's parameters",
        "left-out": "on each recording with the parameters that the others gave",
        "training": "on the recordings that it was fitted to, as none was left to judge it",
    }[kind]
    without = f" ({before} without what was found)" if diagnosis.effects else ""
    return f"The model predicts the steering torque to {after} of its range{without}, {judged}."
