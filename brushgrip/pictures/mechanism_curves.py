"""Picture of the mechanisms that were found: friction over speed or load, torque over angle."""

from math import ceil
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.pictures.style import AFTER, BEFORE, legend_above, picture
from brushgrip.wording.formatting import effect_words, listed
from identification import Curve, Diagnosis, FoundFamily

_DECADE = 10.0
"""Ratio of greatest to least place from which an axis is logarithmic [1]."""


def draw_mechanisms(path: Path, diagnosis: Diagnosis) -> None:
    """Draw the curve of each mechanism with its band of two standard deviations."""
    drawn = [(family, family.curve) for family in diagnosis.families if family.curve]
    rows = ceil(len(drawn) / 2)
    with picture(path, 0.6 + 3.6 * rows) as figure:
        for number, (family, curve) in enumerate(drawn):
            artists = _curve(figure.add_subplot(rows, min(2, len(drawn)), number + 1), family, curve)
        legend_above(figure, artists)


def _curve(axes: Axes, family: FoundFamily, curve: Curve) -> list[Artist]:
    artists: list[Artist] = []
    artists += axes.plot(curve.x, curve.declared, color=BEFORE, label="assumed law, same parameters")
    artists += axes.plot(curve.x, curve.y, color=AFTER, label="found, with two standard deviations")
    known = np.isfinite(curve.std)
    if curve.x.min() > 0 and curve.x.max() > _DECADE * curve.x.min():
        axes.set_xscale("log")
    # A loop folds back, so that its band is drawn leg by leg.
    for leg in np.split(np.arange(curve.x.size), 1 + np.flatnonzero(np.diff(np.sign(np.diff(curve.x))))):
        at = leg[known[leg]]
        low, high = curve.y[at] - 2 * curve.std[at], curve.y[at] + 2 * curve.std[at]
        axes.fill_between(curve.x[at], low, high, color=AFTER, alpha=0.25, lw=0)
    unit = "" if curve.y_unit == "1" else f" [{curve.y_unit}]"
    axes.set(xlabel=f"{curve.x_name} [{curve.x_unit}]", ylabel=f"{curve.y_name}{unit}")
    laws = listed([effect_words(name) for name in family.effects])
    axes.set_title(f"{effect_words(family.name)}: {laws}")
    return artists
