"""Hysteresis loops, measured beside both models."""

from math import ceil
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.formatting import percent
from brushgrip.pictures.style import (
    AFTER,
    BEFORE,
    MEASURED,
    entitle,
    legend_above,
    literal,
    ordered,
    picture,
)
from identification.results import Diagnosis, Series

_MOST_COLUMNS = 4


def draw_loops(path: Path, diagnosis: Diagnosis) -> None:
    """Torque over yaw angle: one recording large, all others small below it."""
    first, *others = ordered(diagnosis)
    rows = ceil(len(others) / _MOST_COLUMNS)
    columns = max(2, ceil(len(others) / rows)) if rows else 1
    with picture(path, 4.8 + 2.2 * rows) as figure:
        grid = figure.add_gridspec(rows + 1, columns, height_ratios=[4.4] + [2.2] * rows)
        large = figure.add_subplot(grid[0, :])
        artists = _loop(large, first, diagnosis)
        large.set_xlabel("yaw angle ψ [rad]")
        large.set_ylabel("aligning torque $M_z$ [N m]")
        for number, series in enumerate(others):
            small = figure.add_subplot(grid[1 + number // columns, number % columns])
            _loop(small, series, diagnosis, width=0.8)
            if number + columns >= len(others):
                small.set_xlabel("ψ [rad]")
            if number % columns == 0:
                small.set_ylabel("$M_z$ [N m]")
        legend_above(figure, artists)


def _loop(axes: Axes, series: Series, diagnosis: Diagnosis, width: float = 1.2) -> list[Artist]:
    curves = (
        (series.measured, MEASURED, "measured", 2.2),
        (series.before, BEFORE, "before: declared structure, refitted", 0.9),
        (series.after, AFTER, "after: with the effects found", 0.9),
    )
    artists: list[Artist] = []
    for torque, colour, label, share in curves:
        artists += axes.plot(series.psi, torque, color=colour, lw=width * share, label=label)
    before, after = diagnosis.before.nrmse[series.name], diagnosis.after.nrmse[series.name]
    if width < 1:
        axes.set_title(f"{literal(series.name)}\n{percent(before)} → {percent(after)}", fontsize=8)
    else:
        entitle(axes, series, f", error {percent(before)} → {percent(after)} of range")
    return artists
