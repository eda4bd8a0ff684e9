"""The simulation of [Györök 2022], figures 2.5 and 2.6: a wheel turned by a torque, and its patch.

    python examples/thesis_simulation.py [PICTURE.png]

The parameters are those of table 2.1. The thesis does not print its steering torque; the one here is
linear between four corners, chosen so that the wheel turns back at the thesis's 1.25 s and 2.4 s and the
patch has the thesis's zones: three, five, seven, and three again once the inner loop has closed. Beside
it stands the thesis's own scheme: 201 bristles and a fixed step.

Where the published simulations are at hand (see published.py), both
are held against them. Their steering torque is not published either: it is what psi and M_z leave of
(2.14), which is linear between four corners at round numbers. Their M_z is written one sample late.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, QUIET, figure_saved_as_png, legend_above
from published import published_simulation, simulation_folder
from symbolic import (
    Rig,
    TorqueProfile,
    Tyre,
    WheelMotion,
    deformation_limit,
    lateral_deformation,
    simulate_motion,
    zone_boundaries,
)

RIG, TYRE, LOAD = Rig(a=0.02, e=0.01, J_A=0.1, b_t=0.4827), Tyre(k=6e4, mu=0.5), 180.0
PROFILE = TorqueProfile(t=(0.0, 0.7, 1.3, 5.1), M=(0.0, 0.5, 0.0, 0.5))
INSTANTS = (0.5, 1.75, 3.0, 5.1)
"""Of the figure of the deformation [s]. The second is the thesis's 2.75 s, see the page."""
RATE = 1000.0
BRISTLES = 201
PUBLISHED = {0.5: 1.0, 1.8: 3.0}
"""Friction of the published files, and how many times the torque below they were driven with [1]."""
DRIVEN = TorqueProfile(t=(0.0, 1.99, 3.99, 4.99), M=(0.4, 0.8, -0.9, 0.2))


class Bristles:
    """Evenly spaced bristles, both edges among them, each a stop: [Györök 2022], (2.15) and (2.16)."""

    def __init__(self, rig: Rig, tyre: Tyre, load: float, count: int) -> None:
        """A virgin patch; the torque (2.3) is summed by the trapezoidal rule."""
        x = np.linspace(-rig.a, rig.a, count)
        self.q, self.lever = np.zeros(count), x - rig.e
        self.limit = 3 * load * (tyre.mu or 0.0) / (4 * rig.a**3 * tyre.k) * (rig.a**2 - x**2)
        weight = np.full(count, 2 * rig.a / (count - 1))
        weight[[0, -1]] /= 2
        self._share, self._lowest = tyre.k * weight * self.lever, -self.limit
        self._move = np.empty(count)

    def turn(self, angle: float) -> float:
        """M_z after a turn [rad]; in place, which in NumPy takes half the time of `clip`."""
        np.multiply(self.lever, angle, out=self._move)
        np.subtract(self.q, self._move, out=self.q)
        np.minimum(self.q, self.limit, out=self.q)
        np.maximum(self.q, self._lowest, out=self.q)
        return float(self._share @ self.q)


def first_order(
    rig: Rig, tyre: Tyre, load: float, torque: np.ndarray, step: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Angle and M_z by the semi-implicit Euler rule; torque at every step, shape (n,)."""
    patch, J_A, b_t = Bristles(rig, tyre, load, count), rig.J_A or 1.0, rig.b_t or 0.0
    psi, M_z = np.zeros(len(torque)), np.zeros(len(torque))
    angle, rate, moment = 0.0, 0.0, 0.0
    for i, M in enumerate(torque[:-1].tolist()):
        rate += step * (M + moment - b_t * rate) / J_A
        angle += step * rate
        moment = patch.turn(step * rate)
        psi[i + 1], M_z[i + 1] = angle, moment
    return psi, M_z


def second_order(
    rig: Rig, tyre: Tyre, load: float, torque: np.ndarray, step: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """The same by velocity Verlet: half a kick, a turn, half a kick; one turn a step too."""
    patch, J_A, b_t = Bristles(rig, tyre, load, count), rig.J_A or 1.0, rig.b_t or 0.0
    psi, M_z = np.zeros(len(torque)), np.zeros(len(torque))
    half = 0.5 * step / J_A
    angle, rate, moment = 0.0, 0.0, 0.0
    torques = torque.tolist()
    for i in range(1, len(torques)):
        middle = rate + half * (torques[i - 1] + moment - b_t * rate)
        angle += step * middle
        moment = patch.turn(step * middle)
        rate = (middle + half * (torques[i] + moment)) / (1 + half * b_t)
        psi[i], M_z[i] = angle, moment
    return psi, M_z


def share(values: np.ndarray, exact: np.ndarray) -> float:
    """Largest difference over the exact range [1]."""
    return float(np.max(np.abs(values - exact)) / np.ptp(exact))


def published(folder: Path) -> Iterator[str]:
    """How far both schemes are from the published files."""
    rig = Rig(a=0.04, e=0.01, J_A=0.1, b_t=0.4827)
    for mu, times in PUBLISHED.items():
        columns = published_simulation(folder, mu)
        if columns is None:
            return
        t, psi, late = (columns[name] for name in ("t", "psi", "M_z"))
        profile = TorqueProfile(t=DRIVEN.t, M=tuple(times * M for M in DRIVEN.M))
        tyre = Tyre(k=6e4, mu=mu)
        exact = simulate_motion(rig, tyre, profile, LOAD, duration=float(t[-1]), rate=100.0)
        fine = np.arange(10 * (t.size - 1) + 1) / RATE
        rows = second_order(rig, tyre, LOAD, profile.torque_at(fine), 1 / RATE, BRISTLES)
        angle, M_z = (values[::10] for values in rows)
        for scheme, values, torque in (
            ("exact", exact.psi, exact.M_z),
            (f"{BRISTLES} bristles", angle, M_z),
        ):
            errors = f"psi {share(values, psi):.1e}, M_z {share(torque[:-1], late[1:]):.1e} of range"
            yield f"sim_mu_{10 * mu:02.0f} against {scheme}: {errors}"


def draw(path: Path, motion: WheelMotion) -> None:
    """The motion on the left, figure 2.5; the patch at four instants on the right, figure 2.6."""
    with figure_saved_as_png(path, 5.6) as figure:
        grid = figure.add_gridspec(4, 2, width_ratios=[5, 4])
        left = [figure.add_subplot(grid[0:2, 0]), figure.add_subplot(grid[2, 0])]
        left.append(figure.add_subplot(grid[3, 0]))
        for axes, signal, label in zip(
            left,
            (motion.psi, motion.psi_dot, motion.M),
            ("yaw angle ψ [rad]", "yaw rate\n$\\dotψ$ [rad/s]", "torque [N m]"),
            strict=True,
        ):
            axes.plot(motion.t, signal, color=AFTER)
            axes.set_ylabel(label)
            axes.margins(x=0.01)
            for instant in INSTANTS:
                axes.axvline(instant, color=QUIET, lw=0.8, ls="--", zorder=0)
        left[2].plot(motion.t, -motion.M_z, color=BEFORE)
        left[2].text(0.35, 0.42, "M", color=AFTER)
        left[2].text(1.35, 0.36, "$-M_z$", color=BEFORE)
        for axes in left[:2]:
            axes.tick_params(labelbottom=False)
        left[2].set_xlabel("time [s]")
        figure.align_ylabels(left)
        x = np.linspace(-RIG.a, RIG.a, 801)
        limit = deformation_limit(x, LOAD, RIG, TYRE)
        lines = []
        for row, instant in enumerate(INSTANTS):
            axes = figure.add_subplot(grid[row, 1])
            i = int(np.argmin(np.abs(motion.t - instant)))
            q = lateral_deformation(x, float(motion.psi[i]), motion.memory[i], LOAD, RIG, TYRE)
            bound = axes.plot(1e3 * x, 1e3 * limit, color=MEASURED, lw=0.9, ls="--")
            axes.plot(1e3 * x, -1e3 * limit, color=MEASURED, lw=0.9, ls="--")
            curve = axes.plot(1e3 * x, 1e3 * q, color=AFTER, lw=1.6)
            ends = zone_boundaries(float(motion.psi[i]), motion.memory[i], LOAD, RIG, TYRE)
            dots = axes.plot(1e3 * ends, 1e3 * np.interp(ends, x, q), "o", color=BEFORE, ms=3.5)
            axes.set_ylim(-12, 24)
            axes.axvline(1e3 * RIG.e, color=QUIET, lw=0.8)
            axes.set(title=f"t = {instant:g} s: {motion.zone_count[i]} zones", ylabel="q [mm]")
            axes.tick_params(labelbottom=row == len(INSTANTS) - 1)
            if not lines:
                bound[0].set_label("friction's limit ± $q_{cr}$")
                curve[0].set_label("lateral deformation q of the patch (grey: kingpin)")
                dots[0].set_label("end of a zone")
                lines = [*curve, *dots, *bound]
        axes.set_xlabel("place in the patch x [mm], front on the right")
        legend_above(figure, lines)


def main() -> None:
    """Print what the wheel does, and how far the thesis's scheme is from it."""
    motion = simulate_motion(RIG, TYRE, PROFILE, LOAD, rate=RATE)
    opens = motion.t[1:][np.diff(motion.zone_count) > 0][1:]
    closes = motion.t[1:][np.diff(motion.zone_count) < 0]
    print(
        f"turns back at {', '.join(f'{t:.2f} s' for t in opens)}; the loop closes at {closes[0]:.2f} s"
    )
    for instant in INSTANTS:
        i = int(np.argmin(np.abs(motion.t - instant)))
        print(f"t = {instant} s: {motion.zone_count[i]} zones, psi = {motion.psi[i]:.4f} rad")
    exact = simulate_motion(RIG, TYRE, PROFILE, LOAD, rate=RATE, tolerance=1e-11)
    print(f"error of M_z over its range: {share(motion.M_z, exact.M_z):.0e} in {motion.steps} steps")
    for name, rule in (("Euler", first_order), ("second order", second_order)):
        _, M_z = rule(RIG, TYRE, LOAD, motion.M, 1 / RATE, BRISTLES)
        print(f"{BRISTLES} bristles, {name}, {motion.t.size - 1} steps: {share(M_z, exact.M_z):.0e}")
    for line in published(simulation_folder()):
        print(line)
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), motion)


if __name__ == "__main__":
    main()
