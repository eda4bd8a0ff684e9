"""Friction of a ground in words, for a further recording on it."""

import math

from brushgrip.wording.friction_in_words import with_95_band
from observers import GroundFriction
from observers.estimates import BAND_STDS
from observers.quality.friction_across_recordings import MIN_RECORDINGS


def prediction_band(friction: GroundFriction) -> str:
    """Friction of a ground with the band of a further recording; no friction is below nothing."""
    low, half = friction.mu_eff, math.inf if friction.further is None else friction.further
    return with_95_band(low, half / BAND_STDS) if half < low else f"up to {low + half:.2f}"


def further_recording(ground: str, friction: GroundFriction | None, recordings: int) -> str:
    """Friction of a ground for a further recording, of so many, in one line."""
    known = 0 if friction is None else friction.recordings
    if friction is None or friction.further is None:
        return (
            f"note on {ground}: no band for a further recording yet, which takes {MIN_RECORDINGS}"
            f" recordings with usable friction; here {known} of {recordings}"
        )
    of = "" if known == recordings else f" of {recordings}"
    band = prediction_band(friction)
    return f"{ground}: mu_eff {band} for a further recording, from {known}{of} recordings"
