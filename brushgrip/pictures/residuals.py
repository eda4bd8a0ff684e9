"""What the models leave of the torque, over time and over the yaw angle."""

from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from brushgrip.pictures.style import (
    AFTER,
    BEFORE,
    MEASURED,
    entitle,
    legend_above,
    ordered,
    picture,
)
from identification.results import Diagnosis, Series

MOST_RECORDINGS = 6
"""Recordings shown; the representative and the held-out ones come first."""


def draw_residuals(path: Path, diagnosis: Diagnosis) -> int:
    """Model minus measured torque, before and after; returns the number of recordings shown."""
    shown = ordered(diagnosis)[:MOST_RECORDINGS]
    with picture(path, 0.9 + 1.9 * len(shown)) as figure:
        grid = figure.add_gridspec(len(shown), 2, width_ratios=[2, 1])
        for row, series in enumerate(shown):
            over_time = figure.add_subplot(grid[row, 0])
            over_angle = figure.add_subplot(grid[row, 1], sharey=over_time)
            artists = _residuals(over_time, over_angle, series)
            over_time.set_ylabel("model − measured\n[N m]")
            entitle(over_time, series)
            over_angle.tick_params(labelleft=False)
        _label_below(figure, over_time, over_angle)
        legend_above(figure, artists)
    return len(shown)


def _residuals(over_time: Axes, over_angle: Axes, series: Series) -> list[Artist]:
    artists: list[Artist] = []
    for torque, colour, label in (
        (series.before, BEFORE, "before: declared structure, refitted"),
        (series.after, AFTER, "after: with the effects found"),
    ):
        residual = torque - series.measured
        artists += over_time.plot(series.t, residual, color=colour, lw=0.9, label=label)
        over_angle.plot(series.psi, residual, color=colour, lw=0.6, alpha=0.85)
    for axes in (over_time, over_angle):
        axes.axhline(0, color=MEASURED, lw=0.7)
    over_time.margins(x=0.01)
    return artists


def _label_below(figure: Figure, over_time: Axes, over_angle: Axes) -> None:
    over_time.set_xlabel("time t [s]")
    over_angle.set_xlabel("yaw angle ψ [rad]")
    figure.align_ylabels()
