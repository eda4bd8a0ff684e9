"""The experiment that would tell two effects apart: what to steer, and what both models make of it."""

import re
from pathlib import Path
from textwrap import fill

from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.formatting import percent, plain
from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, legend_above, picture
from identification.experiments.discriminating_experiment import Proposal

WIDTH = 130
"""Letters of a title that fit above the picture."""


def draw_experiment(path: Path, proposal: Proposal) -> None:
    """Angle and load over time, the torques of the two models, and their difference."""
    manoeuvre = proposal.manoeuvre
    with picture(path, 7.2) as figure:
        rows = figure.subplots(4, 1, sharex=True, height_ratios=[2.0, 1.0, 2.4, 1.4])
        angle, load, torques, difference = rows
        angle.plot(manoeuvre.t, manoeuvre.psi, color=MEASURED)
        angle.set_ylabel("yaw angle ψ\n[rad]")
        angle.set_title(_title(manoeuvre.instruction))
        load.plot(manoeuvre.t, manoeuvre.F_N, color=MEASURED)
        load.set_ylabel("load $F_N$\n[N]")
        _widen(load)
        artists: list[Artist] = []
        for torque, name, colour, width in (
            (proposal.rival_torque, proposal.rival, BEFORE, 2.0),
            (proposal.torque, proposal.found, AFTER, 1.0),
        ):
            artists += torques.plot(manoeuvre.t, torque, color=colour, lw=width, label=plain(name))
        torques.set_ylabel("aligning torque\n$M_z$ [N m]")
        difference.plot(manoeuvre.t, proposal.torque - proposal.rival_torque, color=MEASURED)
        difference.set_ylabel("difference\n[N m]")
        difference.set_xlabel("time [s]")
        difference.set_title(
            f"difference {percent(proposal.separation)} of range,"
            f" in the recordings that are there {percent(proposal.now)}"
        )
        figure.align_ylabels(rows)
        legend_above(figure, artists)


def _title(instruction: str) -> str:
    """In lines that fit, a unit on the line of its number."""
    return fill(re.sub(r"(?<=\d) (?=(?:rad|s|N)\b)", "\N{NO-BREAK SPACE}", instruction), WIDTH)


def _widen(axes: Axes) -> None:
    """A load that is held shall not look as if it wandered."""
    low, high = axes.get_ylim()
    middle, half = (low + high) / 2, max((high - low) / 2, 0.05 * (low + high) / 2)
    axes.set_ylim(middle - half, middle + half)
