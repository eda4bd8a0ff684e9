"""Friction by towing a block
==========================

The friction of three plates by towing a loaded block over them, as in [Györök 2022], section 5.2.1.

.. code-block:: sh

    python examples/towing.py [PICTURE.png]

The tows come from a seeded generator, planted with the thesis's values (table 5.1); its recordings are
not published. Each tow has its own place on the plate, its own zero of the sensor and its own slant.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures.style import MEASURED, TRACKS, figure_saved_as_png, legend_above
from identification import Tow, TowedFriction, friction_by_towing
from reference_rig import Towing, make_tows

PLATES = {"steel plate": 1.674, "red emery paper": 1.9003, "black emery paper": 0.6757}
"""The thesis's coefficients of friction, table 5.1 [1]."""
RUNS = 400
"""Sets of tows that the interval is counted on, a plate."""


def towed(seed: int, towing: Towing) -> TowedFriction:
    """What one set of ten tows says."""
    return friction_by_towing([Tow(F_x=x, F_y=y, F_z=z) for x, y, z in make_tows(seed, towing)])


def draw(path: Path, results: dict[str, TowedFriction]) -> None:
    """Every tow and the fitted lines with their intervals, the thesis's figure 5.3."""
    with figure_saved_as_png(path, 4.2) as figure:
        axes = figure.subplots()
        loads = np.array([0.0, 170.0])
        lines = []
        for (name, friction), colour in zip(results.items(), TRACKS, strict=False):
            low, high = friction.interval()
            label = f"{name}: μ = {friction.mu.value:.3f} ± {friction.mu.std:.3f}"
            lines += axes.plot(loads, friction.mu.value * loads, color=colour, label=label)
            axes.fill_between(loads, low * loads, high * loads, color=colour, alpha=0.15, lw=0)
            dots = axes.plot(friction.N, friction.F, "o", color=colour, ms=4, mec=MEASURED, mew=0.4)
        lines += axes.plot([], [], "o", color="none", mec=MEASURED, ms=4, label="one tow")
        dots[0].set_zorder(3)
        axes.set(
            xlim=(0, 170), ylim=(0, None), xlabel="normal force N [N]", ylabel="friction force F [N]"
        )
        legend_above(figure, lines)


def main() -> None:
    """Print what was planted, what was found, and how often the interval held the truth."""
    results = {}
    for seed, (name, mu) in enumerate(PLATES.items()):
        friction = results[name] = towed(seed, Towing(mu=mu))
        low, high = friction.interval()
        print(
            f"{name}: planted {mu}, F = mu N gives {friction.mu.value:.4f} ± {friction.mu.std:.4f},"
            f" 95 % interval {low:.3f} to {high:.3f}"
        )
        offset, slope = friction.offset, friction.mu_with_offset
        word = "within" if friction.proportional else "outside of"
        print(
            f"  with an offset: {slope.value:.4f} ± {slope.std:.4f} and"
            f" {offset.value:+.2f} ± {offset.std:.2f} N, {word} its 95 % interval of zero"
        )
        runs = [towed(seed, Towing(mu=mu)).interval() for seed in range(RUNS)]
        inside = np.mean([low <= mu <= high for low, high in runs])
        print(f"  the interval held the planted mu in {inside:.1%} of {RUNS} sets")
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), results)


if __name__ == "__main__":
    main()
