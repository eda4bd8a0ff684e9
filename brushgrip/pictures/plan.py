"""A planned path, and what it tells on each ground."""

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LogNorm

from brushgrip.pictures.style import MEASURED, figure_saved_as_png
from observers import Plan


def draw_plan_and_forecast(file: Path, plan: Plan) -> None:
    """The angle over time, and the usable deviation over travel for each friction."""
    path, target = plan.path, 100 * plan.target
    norm, colours = LogNorm(0.6 * min(plan.mus), 1.6 * max(plan.mus)), colormaps["viridis_r"]
    with figure_saved_as_png(file, 3.4) as figure:
        angle, known = figure.subplots(1, 2, width_ratios=(1, 1.4))
        angle.plot(np.append(0, path.t), np.append(path.begin, path.psi), color=MEASURED)
        angle.set(xlabel="time t [s]", ylabel="angle ψ [rad]")
        for mu, at, forecast in zip(plan.mus, plan.reached, plan.forecasts, strict=True):
            colour = colours(norm(mu))
            shown = np.where(forecast.usable, 100 * forecast.deviation, np.nan)
            known.plot(path.travel, shown, color=colour, label=f"μ = {mu:g}")
            if at is not None:
                angle.plot(path.t[at], path.psi[at], "o", color=colour, ms=5)
                known.plot(path.travel[at], shown[at], "o", color=colour, ms=5)
        known.axhline(target, color=MEASURED, ls=":", lw=1)
        known.set_ylim(0, max(4 * target, 10))
        known.set(xlabel="travel [rad]", ylabel="standard deviation of μ over μ [%]")
        known.legend(loc="upper right", ncols=2)
