"""One look for all pictures: the palette, the paper and the order of recordings."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from identification.results import Diagnosis, Series

MEASURED, BEFORE, AFTER, QUIET = "#3c3c3c", "#e07b00", "#0063a8", "#b9bec4"
"""Dark grey, orange, blue and a grey for what stands back: told apart by every kind of eye."""
TRACKS = (BEFORE, AFTER, "#008f6b", "#a0559c")
"""Colours of estimates of friction; the declared model comes first."""
WIDTH = 10.0
"""Width of every picture [in]."""

_DPI = 110
_LETTERS_ACROSS, _LETTERS_PER_SIGN = 135, 8
_LOOK: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8ea",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
}


@contextmanager
def picture(path: Path, height: float) -> Iterator[Figure]:
    """An empty figure of the common width, written to `path` (PNG) in the end; height in inches."""
    with rc_context(_LOOK):
        figure = Figure(figsize=(WIDTH, height), layout="constrained", facecolor="white")
        yield figure
        figure.savefig(path, dpi=_DPI, metadata={"Software": None})


def legend_above(figure: Figure, artists: list[Artist]) -> None:
    """A legend over the whole figure, outside of every axes, so that it covers no data."""
    labels = [str(artist.get_label()) for artist in artists]
    room = _LETTERS_ACROSS - _LETTERS_PER_SIGN * len(labels)
    rows = 1 + sum(map(len, labels)) // max(room, 1)
    columns = max(1, ceil(len(labels) / rows))
    figure.legend(artists, labels, loc="outside upper center", ncols=columns)


def representative(diagnosis: Diagnosis) -> Series:
    """The recording that stands for all: median final error among the held-out, else of all."""
    held_out = [series for series in diagnosis.series if series.held_out]
    ranked = sorted(held_out or diagnosis.series, key=lambda s: diagnosis.after.nrmse[s.name])
    return ranked[(len(ranked) - 1) // 2]


def ordered(diagnosis: Diagnosis) -> list[Series]:
    """Every recording: the representative one, the other held-out ones, the training ones."""
    first = representative(diagnosis)
    others = [series for series in diagnosis.series if series is not first]
    return [first, *sorted(others, key=lambda series: not series.held_out)]


def entitle(axes: Axes, series: Series, text: str = "") -> None:
    """The name of a recording and what it was used for, over the axes."""
    role = "held out" if series.held_out else "training"
    axes.set_title(f"{literal(series.name)} ({role}){text}")


def literal(text: str) -> str:
    """The text as it stands: a dollar sign in a file's name begins no formula."""
    return text.replace("$", r"\$")
