"""Yaw angle, direction and number of zones over time, as in the source's figures 5.6 and 5.7."""

from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.patches import Patch

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, legend_above, literal, picture
from identification.reading.recordings import Recording
from observers import ZoneHistory

_SHADES = {1: BEFORE, -1: AFTER}
_SHADE = 0.15


def draw_zones(path: Path, recording: Recording, history: ZoneHistory) -> None:
    """The angle with its last reversal, and below it the zones; shaded by the direction of turning."""
    t = recording.t
    with picture(path, 5.2) as figure:
        angle, zones = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for side, colour in _SHADES.items():
            for axes in (angle, zones):
                axes.fill_between(
                    t, 0, 1, where=(history.direction == side).tolist(), step="post", color=colour,
                    alpha=_SHADE, lw=0, transform=axes.get_xaxis_transform(),
                )  # fmt: skip
        lines: list[Artist] = []
        lines += angle.plot(t, recording.psi, color=MEASURED, label="yaw angle ψ")
        label = "$ψ_{max}$, angle of the last reversal"
        lines += angle.step(t, history.psi_max, where="post", color=AFTER, ls="--", label=label)
        label = "zones, every reversal counted"
        lines += zones.step(t, history.true_zones, where="post", color=MEASURED, lw=0.9, label=label)
        label = "zones by the source's state machine"
        lines += zones.step(t, history.zones, where="post", color=BEFORE, lw=2.2, label=label)
        angle.set_title(literal(recording.name))
        angle.set_ylabel("yaw angle [rad]")
        angle.margins(x=0)
        zones.set_ylabel("number of zones [1]")
        most = int(history.true_zones.max())
        zones.set_yticks(np.arange(3, most + 1, 2 * max(1, (most - 3) // 12)))
        zones.set_ylim(2.5, most + 0.5)
        zones.set_xlabel("time t [s]")
        key = [
            Patch(color=_SHADES[side], alpha=_SHADE, lw=0, label=f"{name} direction, by the same")
            for side, name in ((1, "positive"), (-1, "negative"))
        ]
        figure.align_ylabels()
        legend_above(figure, [*lines, *key])
