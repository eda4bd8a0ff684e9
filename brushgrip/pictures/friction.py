"""Friction over time with its band."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.pictures.style import AFTER, MEASURED, QUIET, TRACKS, figure_saved_as_png, legend_above
from identification.loop_plot import matplotlib_text
from observers.estimates import BAND_STDS

CHANGE = (0, (1, 1.5))
"""Stroke of a change of the ground."""
STRIP = 0.025
"""Height of a strip below a picture where the model does not explain the torque, over the picture's."""
RECORDINGS = ("#0063a8", "#e07b00", "#008f6b", "#a0559c", "#6b4a2b", "#c0392b", "#4d5966", "#8aa01f")
"""Colours of recordings; where there are more, they begin again."""
MAX_GROUNDS = 4
"""Grounds in the overview; all stand in the table beside it."""
OVERVIEW_WIDTH = 4.2
"""Width of the overview, so that its letters can be read on a telephone [in]."""


BESIDE = 0.02
"""Distance between the bars of recordings in the overview, over the duration [1]."""


class LineStyle(NamedTuple):
    """How a track is drawn.

    Where two observers agree, a thin red line of dashes lies on a broad light one, and a band that is an
    outline on one that is filled: both are visible.
    """

    colour: str
    stroke: str | tuple[int, tuple[float, float]] = "-"
    width: float = 1.8
    filled: bool = True


STYLES = (
    LineStyle(TRACKS[0]),
    LineStyle("#5fa8dc", width=4.0),
    LineStyle("#c2185b", (0, (2.0, 1.6)), 1.5, filled=False),
    LineStyle(TRACKS[3], (0, (4, 3)), 1.2, filled=False),
)
"""Styles in the order of labels; a single track has the second's colour."""


def draw_friction(path: Path, tracks: Sequence[FrictionTrack]) -> None:
    """Draw one panel per recording; bold where the estimate is usable, pale elsewhere."""
    names = list(dict.fromkeys(track.name for track in tracks))
    labels = list(dict.fromkeys(track.label for track in tracks))
    styles = STYLES if len(labels) > 1 else (LineStyle(AFTER),)
    line_styles = {label: styles[i % len(styles)] for i, label in enumerate(labels)}
    limits = _axis_limits([track for track in tracks if track.usable.any()] or tracks)
    with figure_saved_as_png(path, 1.7 + 2.4 * len(names)) as figure:
        panels = figure.subplots(len(names), 1, squeeze=False)[:, 0]
        for axes, name in zip(panels, names, strict=True):
            own = [track for track in tracks if track.name == name]
            for row, track in enumerate(own):
                _draw_track(axes, track, line_styles[track.label], row)
            axes.set(title=matplotlib_text(name), ylabel="effective friction μ_eff [1]", ylim=limits)
            axes.margins(x=0.01)
        panels[-1].set_xlabel("time t [s]")
        legend_above(figure, _friction_legend(tracks, line_styles))


def _draw_track(axes: Axes, track: FrictionTrack, line_style: LineStyle, row: int) -> None:
    colour, stroke, width, filled = line_style
    low, high = track.mu - BAND_STDS * track.mu_std, track.mu + BAND_STDS * track.mu_std
    if filled:
        for where, alpha in ((track.usable, 0.2), (~track.usable, 0.09)):
            axes.fill_between(track.t, low, high, where=where.tolist(), color=colour, alpha=alpha, lw=0)
    else:
        for edge in (low, high):
            shown = np.where(track.usable, edge, np.nan)
            axes.plot(track.t, shown, color=colour, lw=0.6 * width, ls=stroke, alpha=0.6)
    axes.plot(track.t, track.mu, color=colour, lw=0.8, alpha=0.6, ls=stroke)
    axes.plot(track.t, np.where(track.usable, track.mu, np.nan), color=colour, lw=width, ls=stroke)
    if track.inconsistent is not None and track.inconsistent.any():
        axes.fill_between(
            track.t, row * STRIP, (row + 0.8) * STRIP, where=track.inconsistent.tolist(), color=colour,
            lw=0, transform=axes.get_xaxis_transform(),
        )  # fmt: skip
    for instant in track.changes:
        axes.axvline(instant, color=colour, lw=0.9, ls=CHANGE, alpha=0.7)
    if track.reference is not None:
        axes.axhline(track.reference, color=MEASURED, lw=1.0, zorder=1.5)


def draw_friction_by_ground(
    path: Path,
    tracks_by_ground: Mapping[str, Sequence[FrictionTrack]],
    bands: Mapping[str, tuple[float, float]],
) -> None:
    """Draw one panel per ground with a line for each recording, bold where the estimate is usable.

    A bar at the last usable sample is its 95 % band; `bands` are the middle and half-width of a ground.
    """
    grounds = list(tracks_by_ground.items())[:MAX_GROUNDS]
    colours = cycle(RECORDINGS)
    shown = [track for _, tracks in grounds for track in tracks]
    ends = [bands[ground] for ground, _ in grounds if ground in bands]
    limits = _axis_limits(shown, [mu + side * half for mu, half in ends for side in (-1, 1)])
    with figure_saved_as_png(path, 0.7 + 2.2 * len(grounds), OVERVIEW_WIDTH) as figure:
        panels = figure.subplots(len(grounds), 1, squeeze=False, sharex=True)[:, 0]
        for axes, (ground, tracks) in zip(panels, grounds, strict=True):
            named = len(tracks) <= len(RECORDINGS)
            for place, track in enumerate(tracks):
                _draw_recording_line(axes, track, next(colours), place)
            if ground or not named:
                count = "" if named else f", {len(tracks)} recordings"
                axes.set_title(matplotlib_text(ground or "all grounds") + count)
            axes.set(ylabel="friction μ_eff [1]", ylim=limits)
            if ground in bands:
                middle, half = bands[ground]
                axes.axhspan(middle - half, middle + half, color=QUIET, alpha=0.35, lw=0, zorder=0.5)
                axes.axhline(middle, color=MEASURED, lw=1.0, ls=CHANGE, zorder=1.5)
            axes.margins(x=0.03)
            if named:
                axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, handlelength=1.2)
        panels[-1].set_xlim(left=0)
        panels[-1].set_xlabel("time since the beginning [s]")


def _draw_recording_line(axes: Axes, track: FrictionTrack, colour: str, place: int) -> None:
    t, at = track.t - track.t[0], track.last_usable
    if at is not None:
        half = BAND_STDS * track.mu_std[at]
        # Beside one another where recordings end together.
        axes.errorbar(
            t[at] + place * BESIDE * t[-1],
            track.mu[at],
            half,
            fmt="o",
            ms=4,
            color=colour,
            lw=1.3,
            capsize=3,
        )
    # Before the first usable sample a line tells nothing.
    shown = np.where(np.logical_or.accumulate(track.usable), track.mu, np.nan)
    axes.plot(t, shown if track.usable.any() else track.mu, color=colour, lw=1.3, alpha=0.45)
    usable = np.where(track.usable, track.mu, np.nan)
    axes.plot(t, usable, color=colour, lw=2.0, label=matplotlib_text(track.name))


def _axis_limits(tracks: Sequence[FrictionTrack], beside: Sequence[float] = ()) -> tuple[float, float]:
    """Limits of the axis for the usable estimates and these values; a wide band may be cut off."""
    ends = [*beside]
    for track in tracks:
        chosen = track.usable if track.usable.any() else np.ones(track.t.size, dtype=bool)
        chosen = chosen & np.isfinite(track.mu)
        if chosen.any():
            mu, reach = track.mu[chosen], BAND_STDS * np.nan_to_num(track.mu_std[chosen])
            ends += [float(np.quantile(mu - reach, 0.05)), float(np.quantile(mu + reach, 0.95))]
        if track.reference is not None:
            ends.append(track.reference)
    if not ends:
        return 0.0, 2.0
    margin = 0.15 * max(max(ends) - min(ends), 0.1)
    return max(0.0, min(ends) - margin), max(ends) + margin


def _friction_legend(tracks: Sequence[FrictionTrack], line_styles: dict[str, LineStyle]) -> list[Artist]:
    key: list[Artist] = [
        Line2D([], [], color=style.colour, lw=style.width, ls=style.stroke, label=label)
        for label, style in line_styles.items()
    ]
    if any(np.isfinite(track.mu_std).any() for track in tracks):
        label = f"± {BAND_STDS:.0f} standard deviations, in the colour of their line"
        key.append(Patch(color="#777777", alpha=0.25, lw=0, label=label))
    key.append(Line2D([], [], color="#777777", lw=0.8, alpha=0.6, label="pale: not usable"))
    if any(track.inconsistent is not None and track.inconsistent.any() for track in tracks):
        label = "strip at the bottom: torque not explained, by the observer of its colour"
        key.append(Patch(color="#777777", lw=0, label=label))
    if any(track.changes.size for track in tracks):
        key.append(Line2D([], [], color="#777777", lw=0.9, ls=CHANGE, label="change of the ground"))
    references = dict.fromkeys(t.reference_label for t in tracks if t.reference is not None)
    if references:
        key.append(Line2D([], [], color=MEASURED, lw=0.8, label=", ".join(references)))
    return key
