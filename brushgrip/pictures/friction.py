"""Friction over time with its band."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from brushgrip.estimation.estimates import FrictionTrack
from brushgrip.pictures.style import AFTER, MEASURED, TRACKS, legend_above, picture
from identification.loops import literal

BAND = 2.0
"""Standard deviations to either side of the estimate."""
DASHES = ("-", "-", (0, (4, 3)), (0, (1, 2)))
"""Strokes in the order of `TRACKS`; where two observers agree, both lines are visible."""
CHANGE = (0, (1, 1.5))
"""Stroke of a change of the ground."""
DOUBTED = "////"
"""Hatch of a band that is too narrow."""
LineStyle = tuple[str, str | tuple[int, tuple[int, int]]]
"""Colour and stroke."""


def draw_friction(path: Path, tracks: Sequence[FrictionTrack]) -> None:
    """Draw one panel per recording; bold where the estimate is usable, pale elsewhere."""
    names = list(dict.fromkeys(track.name for track in tracks))
    labels = list(dict.fromkeys(track.label for track in tracks))
    palette = TRACKS if len(labels) > 1 else (AFTER,)
    line_styles: dict[str, LineStyle] = {
        label: (palette[i % len(palette)], DASHES[i % len(DASHES)]) for i, label in enumerate(labels)
    }
    with picture(path, 1.1 + 2.4 * len(names)) as figure:
        panels = figure.subplots(len(names), 1, squeeze=False)[:, 0]
        for axes, name in zip(panels, names, strict=True):
            own = [track for track in tracks if track.name == name]
            for track in own:
                _track(axes, track, line_styles[track.label])
            axes.set_title(literal(name))
            axes.set_ylabel("effective friction μ_eff [1]")
            axes.set_ylim(*_limits(own))
            axes.margins(x=0.01)
        panels[-1].set_xlabel("time t [s]")
        legend_above(figure, _key(tracks, line_styles))


def _track(axes: Axes, track: FrictionTrack, line_style: LineStyle) -> None:
    colour, stroke = line_style
    low, high = track.mu - BAND * track.mu_std, track.mu + BAND * track.mu_std
    for where, alpha in ((track.usable, 0.18), (~track.usable, 0.06)):
        axes.fill_between(track.t, low, high, where=where.tolist(), color=colour, alpha=alpha, lw=0)
    axes.plot(track.t, track.mu, color=colour, lw=0.8, alpha=0.45)
    axes.plot(track.t, np.where(track.usable, track.mu, np.nan), color=colour, lw=1.8, ls=stroke)
    if track.inconsistent is not None and track.inconsistent.any():
        axes.fill_between(
            track.t, low, high, where=track.inconsistent.tolist(), facecolor="none", edgecolor=colour,
            alpha=0.5, lw=0, hatch=DOUBTED,
        )  # fmt: skip
    for instant in track.changes:
        axes.axvline(instant, color=colour, lw=0.9, ls=CHANGE, alpha=0.7)
    if track.reference is not None:
        axes.axhline(track.reference, color=MEASURED, lw=1.0, ls="--")


def _limits(tracks: Sequence[FrictionTrack]) -> tuple[float, float]:
    """Limits of the axis for the usable estimates; the wide band before may be cut off."""
    low, high = [], []
    for track in tracks:
        chosen = track.usable if track.usable.any() else np.ones(track.t.size, dtype=bool)
        chosen = chosen & np.isfinite(track.mu)
        if chosen.any():
            mu, reach = track.mu[chosen], BAND * np.nan_to_num(track.mu_std[chosen])
            low.append(float(np.quantile(mu - reach, 0.05)))
            high.append(float(np.quantile(mu + reach, 0.95)))
        if track.reference is not None:
            low.append(track.reference)
            high.append(track.reference)
    if not low:
        return 0.0, 2.0
    margin = 0.15 * max(max(high) - min(low), 0.1)
    return max(0.0, min(low) - margin), max(high) + margin


def _key(tracks: Sequence[FrictionTrack], line_styles: dict[str, LineStyle]) -> list[Artist]:
    key: list[Artist] = [
        Line2D([], [], color=colour, lw=1.8, ls=stroke, label=label)
        for label, (colour, stroke) in line_styles.items()
    ]
    if any(np.isfinite(track.mu_std).any() for track in tracks):
        label = f"± {BAND:.0f} standard deviations"
        key.append(Patch(color="#777777", alpha=0.25, lw=0, label=label))
    key.append(Line2D([], [], color="#777777", lw=0.8, alpha=0.6, label="pale: rests on the prior"))
    if any(track.inconsistent is not None and track.inconsistent.any() for track in tracks):
        label = "hatched: model and stated error do not explain it"
        key.append(Patch(facecolor="none", edgecolor="#777777", lw=0, hatch=DOUBTED, label=label))
    if any(track.changes.size for track in tracks):
        key.append(Line2D([], [], color="#777777", lw=0.9, ls=CHANGE, label="change of the ground"))
    references = dict.fromkeys(t.reference_label for t in tracks if t.reference is not None)
    if references:
        label = ", ".join(references)
        key.append(Line2D([], [], color=MEASURED, ls="--", lw=1.0, label=label))
    return key
