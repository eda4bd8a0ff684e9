"""What the torque tells of friction
=================================

What a sample of the torque tells of mu along a turn out and back: the derivative of M_z by mu.

.. code-block:: sh

    python examples/observability.py [PICTURE.png]

A torque noise of standard deviation s leaves mu open by `s / |dM_z/dmu|` after one sample, and by
s / sqrt(sum of squares) after all samples so far, k and the torque's zero known. In full stick the
torque does not depend on mu at all; in full slide it does most, and one sample leaves
s / (3/8 F_N a), the caster length being 0. After a reversal the derivative passes through zero once
more: the middle of the patch still holds what the turn out has made of it, while its ends already slide
the new way.
"""

import sys
from pathlib import Path

import numpy as np

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from symbolic import Model, full_slide_torque, simulate

A, E, K, MU, LOAD = 0.045, 0.0, 2.4e6, 1.2, 400.0
FARTHEST = 0.3
"""Angle at which the wheel turns back; back it goes as far to the other side [rad]."""
TURN_STEP, DT = 1e-3, 0.01
"""Turn between samples [rad], time between them [s]."""
NOISE = 0.05
"""Standard deviation of the torque noise [N m]."""
LONG_TURN = 10.0
"""Turn that comes close to full slide: the middle of the patch gets there last [rad]."""
ROWS = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3)
"""Turns that the table shows, out and then since the reversal [rad]."""


def turn() -> np.ndarray:
    """Angle of every sample [rad]."""
    count = round(FARTHEST / TURN_STEP)
    return np.concatenate([np.arange(count + 1), count - 1 - np.arange(2 * count)]) * TURN_STEP


def by_mu(psi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M_z [N m] and its derivative by mu [N m], with the whole history."""
    signals = np.vstack([psi, np.gradient(psi, DT), np.full((2, psi.size), [[LOAD], [DT]])])
    only_mu = np.array([[1.0], [0.0]])
    response = simulate(Model(), signals, np.array([MU, K]), np.array([A, E]), only_mu)
    return response.M_z, response.sensitivities[:, 0]


def draw(path: Path, psi: np.ndarray, M_z: np.ndarray, slope: np.ndarray, slide: float) -> None:
    """Torque, its derivative and the standard deviations over the angle."""
    back = int(np.argmax(psi))
    out, home = slice(0, back + 1), slice(back, None)
    with figure_saved_as_png(path, 7.5) as figure:
        torque, share, spread = figure.subplots(3, 1, sharex=True)
        lines = []
        for leg, colour, label in ((out, BEFORE, "out, from rest"), (home, AFTER, "back")):
            lines += torque.plot(psi[leg], M_z[leg], color=colour, label=label)
            share.plot(psi[leg], slope[leg] / slide, color=colour)
            # In a single sample of full stick the standard deviation is beyond every axis.
            one = NOISE / np.maximum(np.abs(slope[leg]), 1e-12)
            spread.semilogy(psi[leg], one, color=colour)
        so_far = NOISE / np.sqrt(np.maximum(np.cumsum(slope**2), 1e-24))
        label = "all samples so far; solid: one sample alone"
        lines += spread.plot(psi, so_far, color=MEASURED, lw=0.9, ls="--", label=label)
        torque.set_ylabel("aligning torque\n$M_z$ [N m]")
        share.axhline(0, color=MEASURED, lw=0.7)
        share.set_ylabel("∂$M_z$/∂μ, share of\n3/8 $F_N$ a [1]")
        spread.set(ylabel="standard deviation\nof μ [1]", ylim=(1e-4, 10), xlabel="yaw angle ψ [rad]")
        figure.align_ylabels()
        legend_above(figure, lines)


def main() -> None:
    """Print the derivative and what it leaves open of mu, out and after the reversal."""
    psi = turn()
    M_z, slope = by_mu(psi)
    slide, back = float(full_slide_torque(LOAD, A)), int(np.argmax(psi))
    information = np.cumsum(slope**2)
    print(f"torque noise {NOISE} N m; 3/8 F_N a = {slide:.2f} N m")
    for title, first in (("out, from rest", 0), ("back, since the reversal", back)):
        print(f"\n{title:26}dM_z/dmu / (3/8 F_N a)   std, one sample   std, this leg so far")
        for angle in ROWS:
            at = first + round(angle / TURN_STEP)
            leg = information[at] - information[first]
            print(
                f"{angle:22.3f} rad{slope[at] / slide:24.4f}"
                f"{NOISE / abs(slope[at]):18.3g}{NOISE / np.sqrt(leg):23.3g}"
            )
    blind = back + int(np.argmin(np.abs(slope[back:])))
    print(f"\nfull stick, first sample: dM_z/dmu = {abs(slope[0]):.1g} N m")
    _, sliding = by_mu(np.linspace(0, LONG_TURN, 1000))
    reached, limit = NOISE / abs(sliding[-1]), NOISE / slide
    print(f"full slide, one sample: std {reached:.4f}, noise / (3/8 F_N a) = {limit:.4f}")
    print(f"blind again {abs(psi[blind] - psi[back]):.3f} rad after the reversal")
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), psi, M_z, slope, slide)


if __name__ == "__main__":
    main()
