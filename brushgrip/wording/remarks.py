"""What is told of recordings beside their friction, in a table and counted."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from brushgrip.wording.formatting import is_figure
from brushgrip.wording.friction import further_recording, last_usable, with_95_band
from observers import Estimates, ground_friction

FEW = 0.1
"""Share of usable samples below which friction is remarked upon [1]."""
BETWEEN = " | "
"""Between two remarks of a row."""


def remark(estimates: Estimates, why: str, note: str) -> str:
    """What is told of a recording beside its friction: few or (why) no usable samples, then the note."""
    if last_usable(estimates) is None:
        return f"not known: {why}"
    few = f"usable in under {100 * FEW:.0f} %" * (estimates.usable_share < FEW)
    return BETWEEN.join(filter(None, (few, why, note)))


def remark_heads(text: str) -> list[str]:
    """Each remark of a row in short; why friction is not known, with what to do first."""
    heads = [one.partition("; ")[0] for one in text.split(BETWEEN) if one]
    return [one if one.startswith("not known") else one.partition(": ")[0] for one in heads]


def remark_counts(rows: Sequence[Mapping[str, Any]]) -> str:
    """Of how many recordings there is which remark, whatever its figures, in one line."""
    heads = [": ".join(h.split(": ")[:2]) for row in rows for h in remark_heads(row["remark"])]
    counts = Counter(re.sub(r"[\d.]+(?= times)", "so many", head) for head in heads)
    return "; ".join(f"{count} of {len(rows)}: {head}" for head, count in counts.most_common())


def friction_of_grounds(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Friction of each ground with several recordings, of which one is usable, in a line."""
    lines = []
    for ground in dict.fromkeys(row["ground"] for row in rows if row["ground"]):
        own = [(row["mu_eff"], row["mu_eff_std"]) for row in rows if row["ground"] == ground]
        known = np.array(own, dtype=float)
        # A recording that was given twice, under two names, counts once.
        known = np.unique(known[np.isfinite(known).all(axis=1)], axis=0)
        if known.size and len(own) > 1:
            lines.append(further_recording(str(ground), ground_friction(*known.T), len(own)))
    return lines


def printed_rows(rows: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Headings and rows of the table on the screen."""
    cells: list[tuple[str, ...]] = []
    for row in rows:
        mu, std = row["mu_eff"], row["mu_eff_std"]
        usable = f"{100 * float(row['usable']):.0f} %" if row["usable"] != "" else "–"
        beside = row["fault"] or "; ".join(remark_heads(row["remark"]))
        friction = with_95_band(mu, std) if is_figure(mu) else "–"
        cells.append((row["recording"], row["ground"] or "–", friction, usable, beside))
    return ("recording", "ground", "mu_eff", "usable", "remark"), cells
