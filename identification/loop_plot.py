"""Torque over the angle, drawn into axes of matplotlib, which is imported when something is drawn."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from symbolic.errors import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ALIGNING = "aligning torque $M_z$ [N m]"


def draw_loops(
    axes: "Axes | None",
    psi: NDArray[np.float64],
    torques: Mapping[str, NDArray[np.float64]],
    torque_label: str = ALIGNING,
) -> "Axes":
    """Draw torques [N m] by their labels over the angle [rad]; into new axes of pyplot where None."""
    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots(layout="constrained")[1]
    for label, torque in torques.items():
        axes.plot(psi, torque, lw=1.0, label=matplotlib_text(label))
    axes.set(xlabel="yaw angle ψ [rad]", ylabel=torque_label)
    axes.legend()
    return axes


def matplotlib_text(text: str) -> str:
    """Text for matplotlib: without formulas, and in a legend even where it begins with an underscore."""
    visible = printable(text).replace("$", r"\$")
    return "\u200b" * visible.startswith("_") + visible
