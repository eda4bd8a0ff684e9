"""Box charts of estimates of friction, as in the source's figure 5.10."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from brushgrip.comparison.scores import AUTHOR, Compared
from brushgrip.pictures.style import MEASURED, QUIET, TRACKS, legend_above, literal, picture

_COLOURS = (*TRACKS, MEASURED, "#c9a500", "#79b4e0")
_ROOM = 0.8
"""Share of a recording's width that its boxes take."""


def draw_boxes(path: Path, compared: Sequence[Compared], methods: Sequence[str]) -> None:
    """The estimate's distribution, its error and the time it takes, a box or a dot a method.

    Args:
        path: PNG.
        compared: the recordings.
        methods: names of the methods, in the order of the boxes.
    """
    own = [name for name in methods if name != AUTHOR]
    colours = {name: QUIET for name in methods if name == AUTHOR}
    colours |= {name: _COLOURS[i % len(_COLOURS)] for i, name in enumerate(own)}
    with picture(path, 7.0) as figure:
        grid = figure.add_gridspec(2, 2, height_ratios=[3.4, 2.6])
        _estimates(figure.add_subplot(grid[0, :]), compared, colours)
        error, time = (figure.add_subplot(grid[1, column]) for column in range(2))
        _over_recordings(error, compared, colours, "rmse")
        error.set_ylabel("RMSE of μ [1]")
        error.set_ylim(bottom=0)
        _over_recordings(time, compared, colours, "theta")
        time.set_yscale("log")
        time.set_ylabel("calculation time /\nmeasurement time ϑ [1]")
        key: list[Artist] = [Patch(color=colour, label=name) for name, colour in colours.items()]
        dashes = error.plot([], [], color=MEASURED, lw=1.2, ls="--", label="declared μ")
        legend_above(figure, [*key, *dashes])


def _estimates(axes: Axes, compared: Sequence[Compared], colours: dict[str, str]) -> None:
    width = _ROOM / len(colours)
    for place, one in enumerate(compared):
        for score in one.scores:
            at = place - _ROOM / 2 + width * (list(colours).index(score.method) + 0.5)
            _box(axes, score.mu, at, width, colours[score.method])
        axes.plot([place - 0.45, place + 0.45], [one.subject.declared] * 2, color=MEASURED, ls="--")
    axes.set_xticks(range(len(compared)), [literal(one.subject.recording.name) for one in compared])
    axes.set_ylabel("friction coefficient μ [1]")
    axes.set_xlim(-0.5, len(compared) - 0.5)
    axes.grid(visible=False, axis="x")
    axes.set_ylim(0, top := _top(compared))
    greatest = max(float(score.mu.max()) for one in compared for score in one.scores)
    beyond = f"; cut off, the greatest is {greatest:.3g}" if greatest > top else ""
    axes.set_title(f"Estimate over time: median, quartiles, least and greatest{beyond}")


def _top(compared: Sequence[Compared]) -> float:
    """Room for the boxes; the greatest values of a root solve may leave the picture."""
    high = [np.quantile(score.mu, 0.97) for one in compared for score in one.scores]
    return 1.1 * float(max([*high, *(one.subject.declared for one in compared)]))


def _over_recordings(
    axes: Axes, compared: Sequence[Compared], colours: dict[str, str], figure: str
) -> None:
    """A box a method over the recordings; where there is one recording, its value."""
    for place, (name, colour) in enumerate(colours.items()):
        values = [
            getattr(score, figure) for one in compared for score in one.scores if score.method == name
        ]
        known = np.array([value for value in values if value is not None])
        if known.size:
            _box(axes, known, place, _ROOM, colour)
    axes.set_xticks(range(len(colours)), colours, rotation=20, ha="right", rotation_mode="anchor")
    axes.set_xlim(-0.5, len(colours) - 0.5)
    axes.grid(visible=False, axis="x")


def _box(axes: Axes, values: np.ndarray, at: float, width: float, colour: str) -> None:
    axes.boxplot(
        [values],
        positions=[at],
        widths=0.8 * width,
        whis=(0, 100),
        manage_ticks=False,
        patch_artist=True,
        boxprops={"facecolor": colour, "edgecolor": colour, "alpha": 0.7},
        whiskerprops={"color": colour},
        capprops={"color": colour},
        medianprops={"color": "black", "linewidth": 1.2},
    )
