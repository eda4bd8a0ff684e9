"""Box charts of friction as in [Györök 2022]."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from brushgrip.comparison.error_and_calculation_time import AUTHOR, CaseScores
from brushgrip.comparison.tables import metrics_by_case
from brushgrip.pictures.style import MEASURED, QUIET, TRACKS, figure_saved_as_png, legend_above
from identification.loop_plot import matplotlib_text

_COLOURS = (*TRACKS, MEASURED, "#c9a500", "#79b4e0")
_BOXES_WIDTH = 0.8
"""Share of a recording's width that its boxes take [1]."""


def draw_method_comparison(path: Path, compared: Sequence[CaseScores], methods: Sequence[str]) -> None:
    """Draw distribution, error and calculation time of each method, as in [Györök 2022], figure 5.10."""
    own = cycle(_COLOURS)
    colours = {name: QUIET if name == AUTHOR else next(own) for name in methods}
    with figure_saved_as_png(path, 7.0) as figure:
        grid = figure.add_gridspec(2, 2, height_ratios=[3.4, 2.6])
        _draw_estimates(figure.add_subplot(grid[0, :]), compared, colours)
        error, time = (figure.add_subplot(grid[1, column]) for column in range(2))
        _draw_metric_boxes(error, compared, colours, "rmse")
        error.set_ylabel("RMSE of μ [1]")
        error.set_ylim(bottom=0)
        _draw_metric_boxes(time, compared, colours, "theta")
        time.set(yscale="log", ylabel="calculation time /\nmeasurement time ϑ [1]")
        key: list[Artist] = [Patch(color=colour, label=name) for name, colour in colours.items()]
        dashes = error.plot([], [], color=MEASURED, lw=1.2, ls="--", label="declared μ")
        legend_above(figure, [*key, *dashes])


def _draw_estimates(axes: Axes, compared: Sequence[CaseScores], colours: dict[str, str]) -> None:
    width = _BOXES_WIDTH / len(colours)
    for place, one in enumerate(compared):
        for score in one.scores:
            at = place - _BOXES_WIDTH / 2 + width * (list(colours).index(score.method) + 0.5)
            _box(axes, score.mu, at, width, colours[score.method])
        axes.plot([place - 0.45, place + 0.45], [one.case.declared] * 2, color=MEASURED, ls="--")
    axes.set_xticks(range(len(compared)), [matplotlib_text(one.case.recording.name) for one in compared])
    axes.set(ylabel="friction coefficient μ [1]", xlim=(-0.5, len(compared) - 0.5))
    axes.grid(visible=False, axis="x")
    # The greatest values of a root solve may lie above the axis.
    high = [np.quantile(score.mu, 0.97) for one in compared for score in one.scores]
    top = 1.1 * float(max([*high, *(one.case.declared for one in compared)]))
    axes.set_ylim(0, top)
    greatest = max(float(score.mu.max()) for one in compared for score in one.scores)
    beyond = f"; cut off, the greatest is {greatest:.3g}" if greatest > top else ""
    axes.set_title(f"Estimate over time: median, quartiles, least and greatest{beyond}")


def _draw_metric_boxes(
    axes: Axes, compared: Sequence[CaseScores], colours: dict[str, str], quantity: str
) -> None:
    """One box per method over the recordings; where there is one recording, its value."""
    for place, (name, colour) in enumerate(colours.items()):
        values = metrics_by_case(compared, name, quantity)
        known = np.array([value for value in values if value is not None])
        if known.size:
            _box(axes, known, place, _BOXES_WIDTH, colour)
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
