"""How well the parameters of free vibrations are determined."""

from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from identification import FreeDecay, VibrationFit
from identification.loop_plot import matplotlib_text
from identification.thesis import DecrementIdentification

MAX_VIBRATIONS = 3
"""Most recordings in the picture, evenly spaced from the shortest contact to the longest."""


def draw_free_decay(path: Path, result: FreeDecay, decrement: DecrementIdentification) -> None:
    """Draw fit and residual of some recordings, and the curves of [Györök 2022] over contact length."""
    by_length = sorted(result.vibrations, key=lambda v: v.a)
    places = np.linspace(0, len(by_length) - 1, min(MAX_VIBRATIONS, len(by_length)))
    shown = [by_length[round(place)] for place in places]
    with figure_saved_as_png(path, 3.4 + 2.0 * len(shown)) as figure:
        grid = figure.add_gridspec(len(shown) + 1, 2, height_ratios=[2.0] * len(shown) + [2.8])
        artists: list[Artist] = []
        for row, vibration in enumerate(shown):
            angle, residual = (figure.add_subplot(grid[row, column]) for column in range(2))
            artists = _vibration(angle, residual, vibration, result.encoder_step)
            if row == len(shown) - 1:
                for axes in (angle, residual):
                    axes.set_xlabel("time t [s]")
        frequency, damping = (figure.add_subplot(grid[-1, column]) for column in range(2))
        artists += _draw_over_contact_length(frequency, damping, result, decrement)
        figure.align_ylabels()
        legend_above(figure, artists)


def _vibration(angle: Axes, residual: Axes, vibration: VibrationFit, step: float) -> list[Artist]:
    readings = 1000 * (vibration.psi - vibration.centre)
    fitted = 1000 * (vibration.fitted - vibration.centre)
    artists: list[Artist] = []
    artists += angle.plot(vibration.t, readings, color=MEASURED, lw=2.0, label="encoder")
    artists += angle.plot(vibration.t, fitted, color=AFTER, lw=1.0, label="fit, with sliding ends")
    title = f"{matplotlib_text(vibration.name)}, a = {1000 * vibration.a:g} mm"
    angle.set(title=title, ylabel="ψ from its centre\n[mrad]")
    residual_steps = (vibration.psi - vibration.fitted) / step
    residual.plot(vibration.t, residual_steps, color=AFTER, lw=0.6)
    for edge in (-0.5, 0.5):
        residual.axhline(edge, color=MEASURED, lw=0.7, ls="--")
    residual.set_ylabel("encoder − fit\n[steps]")
    return artists


def _draw_over_contact_length(
    frequency: Axes, damping: Axes, result: FreeDecay, decrement: DecrementIdentification
) -> list[Artist]:
    """Points by the method of [Györök 2022], and the sticking patch with k and b_t as identified."""
    swings = decrement.vibrations
    a = np.array([1000 * swing.a for swing in swings])
    order = np.argsort(a)
    rigid = np.array([v.sticking for v in result.vibrations])
    artists: list[Artist] = []
    for axes, points, curve, label in (
        (frequency, [s.omega_n for s in swings], rigid[:, 0], "natural frequency\n$ω_n$ [rad/s]"),
        (damping, [s.zeta for s in swings], rigid[:, 1], "relative damping\nζ [1]"),
    ):
        dots = axes.plot(a, points, "x", color=BEFORE, label="FFT and decrement, a recording each")
        line = axes.plot(
            a[order], curve[order], color=AFTER, lw=1.4, label="identified, whole patch sticking"
        )
        axes.set(xlabel="contact half-length a [mm]", ylabel=label)
        artists = [*dots, *line]
    return artists
