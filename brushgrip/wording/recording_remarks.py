"""What is told of recordings beside their friction, in a table and counted."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from math import inf, nan
from statistics import median
from typing import Any

import numpy as np

from brushgrip.wording.formatting import is_number
from brushgrip.wording.friction_in_words import (
    WAYS,
    friction_before_change,
    ground_change_text,
    with_95_band,
)
from observers import Estimates, GroundFriction, ground_friction
from observers.estimates import BAND_STDS
from observers.quality.friction_across_recordings import MIN_RECORDINGS
from observers.quality.when_usable import last_usable

SIGNS = dict(zip(WAYS, "+−", strict=True))
FEW = 0.1
"""Share of usable samples below which friction is remarked upon [1]."""
MAX_NAMED = 10
"""Most recordings that are named behind a remark which they share."""
EARLY, MOST = 0.25, 3
"""Share of the median length below which a recording ends early [1]; least number of recordings."""
FIGURES = re.compile(
    r" from [\d.e+]+ to [\d.e+]+ s|(?<=ends early), after [\d.e+]+ s|(?<=changed| to fit) at [\d.e+]+ s"
)
"""Times in a remark, which differ between recordings."""
OVER_LOAD = "by the model friction changes with the load"
"""How the remark on the load that friction belongs to begins."""
MAP = ": --map "
"""What goes before a map that is proposed."""
BETWEEN = " | "
"""Between two remarks of a row."""


def recording_remark(estimates: Estimates, why: str, note: str, *, of_way: bool = False) -> str:
    """What is told of a recording beside its friction.

    Few or (why) no usable samples, a change of the ground, then the note. What friction was before is
    left out where it is of a direction.
    """
    changed = ground_change_text(estimates)
    if (before := friction_before_change(estimates)) and not of_way:
        changed += f": before, {before}"
    if last_usable(estimates) is None:
        return BETWEEN.join(filter(None, (f"not known: {why}", changed, note)))
    few = f"usable in under {100 * FEW:.0f} %" * (estimates.usable_share < FEW)
    return BETWEEN.join(filter(None, (few, why, changed, note)))


def short_remarks(text: str) -> list[str]:
    """Each remark of a row in short; why friction is not known, with what to do first or the map."""
    each = [one for one in text.split(BETWEEN) if one]
    heads = [one if MAP in one else one.partition("; ")[0] for one in each]
    return [one if one.startswith("not known") else one.partition(": ")[0] for one in heads]


def remark_counts(rows: Sequence[Mapping[str, Any]], *, named: bool = False) -> str:
    """Of how many recordings there is which remark, whatever its figures, in one line.

    Named: with the names of those recordings, where they are few.
    """
    names: dict[str, list[str]] = {}
    for row in rows:
        for head in short_remarks(row["remark"]):
            kind = FIGURES.sub("", ": ".join(head.split(": ")[:2]))
            kind = re.sub(r"[\d.]+(?= times)", "so many", kind)
            kind = re.sub(r", down to [\d.]+", "", kind)
            names.setdefault(kind, []).append(row["recording"] if named else "")
    return "; ".join(
        f"{len(own)} of {len(rows)}: {kind}" + f" ({', '.join(own)})" * (named and len(own) <= MAX_NAMED)
        for kind, own in sorted(names.items(), key=lambda one: -len(one[1]))
    )


def row_with_map_for_it_alone(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """The row of a recording without friction; a map that it proposes is for this recording alone."""
    own = f"; for this recording alone{MAP}"
    return {**row, **{name: row.get(name, "").replace(MAP, own, 1) for name in ("fault", "remark")}}


def unknown_friction_lines(rows: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """A line for each recording that could not be estimated, or whose friction is not known."""
    for row in rows:
        if row["fault"] or not is_number(row["mu_eff"]):
            begin = f"{row['recording']}: "
            yield begin + (row["fault"].removeprefix(begin) or row["remark"])


def usual_duration(durations: Collection[float]) -> float:
    """The median of the lengths of recordings [s]; 0 where they are too few."""
    return median(durations) if len(durations) >= MOST else 0.0


def row_with_early_end_remark(row: Mapping[str, Any], usual: float) -> Mapping[str, Any]:
    """The row, with a remark where it is much shorter than the usual duration [s]."""
    seconds = row["duration"]
    if not (is_number(seconds) and seconds < EARLY * usual):
        return row
    text = f"ends early, after {seconds:.2g} s: half of all last {usual:.2g} s or more"
    return {**row, "remark": BETWEEN.join(filter(None, (row["remark"], text)))}


def prediction_band(friction: GroundFriction) -> str:
    """Friction of a ground with the band of a further recording; no friction is below nothing."""
    low, half = friction.mu_eff, inf if friction.further is None else friction.further
    return with_95_band(low, half / BAND_STDS) if half < low else f"up to {low + half:.2f}"


def further_recording_band_line(ground: str, friction: GroundFriction | None, recordings: int) -> str:
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


def friction_lines_by_ground(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Friction of each ground with several recordings, of which one is usable, in a line."""
    lines = []
    ways = WAYS if any(row.get("direction") for row in rows) else ("",)
    grounds = dict.fromkeys(row["ground"] for row in rows if row["ground"])
    for ground, way in product(grounds, ways):
        names = [f"{name}_{way}" if way else name for name in ("mu_eff", "mu_eff_std")]
        own = [[row.get(name, nan) for name in names] for row in rows if row["ground"] == ground]
        known = np.array(own, dtype=float)
        # A recording that was given twice, under two names, counts once.
        known = np.unique(known[np.isfinite(known).all(axis=1)], axis=0)
        if known.size and len(own) > 1:
            told = f"{ground}, turning to {way} psi" if way else str(ground)
            loads = any(OVER_LOAD in row.get("remark", "") for row in rows if row["ground"] == ground)
            told += ", each at its own load" * loads
            lines.append(further_recording_band_line(told, ground_friction(*known.T), len(own)))
    return lines


def friction_range(rows: Sequence[Mapping[str, object]]) -> str:
    """Of how many rows of a summary friction is known, of how many not at the end, and its range."""
    names = ("mu_eff", *(f"mu_eff_{way}" for way in WAYS))
    known, early, mus = 0, 0, list[float]()
    for row in rows:
        if is_number(row["mu_eff"]):
            known += 1
            early += bool(row.get("since_usable"))
            mus += [mu for name in names if is_number(mu := row.get(name))]
    told = f"friction is known of {known}" + f", {early} of them not at the end" * bool(early)
    return told + (f", mu_eff {min(mus):.2f} to {max(mus):.2f}" if mus else "")


def printed_rows(rows: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Headings and rows of the table on the screen."""
    cells: list[tuple[str, ...]] = []
    for row in rows:
        usable = f"{100 * float(row['usable']):.0f} %" if row["usable"] != "" else "–"
        beside = row["fault"] or "; ".join(short_remarks(row["remark"]))
        cells.append((row["recording"], row["ground"] or "–", _friction(row), usable, beside))
    return ("recording", "ground", "mu_eff", "usable", "remark"), cells


def _friction(row: Mapping[str, Any]) -> str:
    """Friction of a row, of each direction the weaker one first; when it was, if not at the end."""
    if not is_number(row["mu_eff"]):
        return "–"
    told = with_95_band(row["mu_eff"], row["mu_eff_std"])
    if row.get("direction"):
        own = {way: (row.get(f"mu_eff_{way}", nan), row.get(f"mu_eff_std_{way}", nan)) for way in WAYS}
        if not is_number(own[row["direction"]][0]):
            own[row["direction"]] = row["mu_eff"], row["mu_eff_std"]
        weaker_first = sorted(
            ((m, s, way) for way, (m, s) in own.items()), key=lambda one: (one[0] >= 0, one[0])
        )
        told = ", ".join(f"{with_95_band(m, s)} ({SIGNS[way]}psi)" for m, s, way in weaker_first)
    return told + f" at {row['last_usable']:.4g} s" * bool(row.get("since_usable"))
