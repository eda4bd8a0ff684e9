"""What a method makes of a wrong angle or torque: [Györök 2022], section 4.3, for every method.

    python examples/thesis_sensitivity.py [--mesh N] [PICTURE.png]

The thesis takes the simulation with mu = 1 after its first reversal, at psi_max = 0.7126 rad, and lets
angle and torque run over a mesh, everything else constant. Most of the mesh cannot happen; what does
lies on a line. For a method without memory of torques that is one evaluation a point. A filter has seen
the samples before, so its sensitivity is one of two things, and both are drawn:

- one sample alone: the memory of the patch holds the turn up to psi_max, but of mu the filter has only
  its prior, 0.6 +- 0.5. Its estimate shows the information in one sample; where it is not informed it
  does not answer, where the others do.
- one false sample in a stream: the filter has followed the simulation half way back, and then one sample
  of the mesh comes in. This is how wrong one sample can make it. An error that lasts is another matter.

Printed: the share of the mesh within 10 % of mu and the torque error at the true angle up to which a
method stays within 10 % (the nearer of both signs), in the median over the line.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from numpy.typing import NDArray

from brushgrip.comparison.methods import (
    neural_network_inputs,
    root_mu_correction_inputs,
    train_neural_network,
    train_root_correction_network,
)
from brushgrip.pictures.style import BEFORE, MEASURED, figure_saved_as_png
from observers import Ekf, Mhe, Sample, Tuning
from observers.thesis.root_observer import CLOSE, nearest_root
from observers.thesis.zone_state_machine import zone_torque_curve
from symbolic import Model, full_slide_torque
from thesis_profile import DT, LOAD, RIG, K, steered
from thesis_table import CLEAN

REACH = (0.75, 1.5)
"""The mesh goes this far to either side: yaw angle [rad], torque M = -M_z [N m]."""
PRIOR = Tuning(
    mu=0.6, noise=1e-2, error=1e-2, error_travel=0.0, mu_walk=1e-3, zero_std=1e-4, zero_walk=0.0,
    psi_rate_limit=float("inf"),
)  # fmt: skip
"""Tuning for one sample alone, whose angle may jump; its torque is good to 1 % of full slide."""
ITERATIONS = 10
"""Linearisations of that sample, which tells all there is."""
NEAR = 0.1
"""An estimate so near, relatively, counts as right [1]."""
SIMULATION = steered(1.0)
TURN = int(np.argmax(SIMULATION.psi))
BACK = slice(TURN + 1, int(np.argmin(SIMULATION.psi)) + 1)
"""Samples of the line: from the first reversal to the second."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
    """What a method makes of points, shape (points,): estimates [1], and where it answers."""

    mu: np.ndarray
    informed: NDArray[np.bool_]

    @property
    def right(self) -> NDArray[np.bool_]:
        """Where it answers, and within `NEAR`."""
        return self.informed & (np.abs(self.mu - 1) <= NEAR)


def always(mu: np.ndarray) -> Surface:
    """The surface of a method that always answers."""
    return Surface(mu=mu, informed=np.full(mu.shape, True))


def root(psi: np.ndarray, M: np.ndarray) -> np.ndarray:
    """The root solve in five zones, from the last estimate, which is right."""
    close, psi_max = CLOSE * full_slide_torque(LOAD, RIG.a), SIMULATION.psi[TURN]
    roots = []
    for angle, torque in zip(psi, M, strict=True):
        of_mu = zone_torque_curve((psi_max, angle - psi_max), LOAD, K, RIG)
        roots.append(nearest_root(of_mu, -torque, 1.0, (0.02, 4.0), close)[0])
    return np.array(roots)


def filtered(
    observer: Ekf | Mhe, psi: np.ndarray, M: np.ndarray, after: int, *, measured: bool
) -> Surface:
    """Estimates after one sample of the mesh, its angle [rad] and torque [N m], shape (points,) each.

    The simulation up to the sample `after` goes before it, with its torques or without.
    """
    state = None
    for angle, rate, M_z in zip(
        SIMULATION.psi[: after + 1], SIMULATION.psi_dot, SIMULATION.M_z, strict=False
    ):
        torque = M_z if measured else np.nan
        sample = Sample(psi=angle, psi_dot=rate, F_N=LOAD, dt=DT, M_z=torque)
        state = observer.step(observer.init(sample) if state is None else state, sample)
    rate = float(SIMULATION.psi_dot[after])
    estimates = []
    for angle, torque in zip(psi, M, strict=True):
        sample = Sample(psi=angle, psi_dot=rate, F_N=LOAD, dt=DT, M_z=-torque)
        estimates.append(observer.estimate(observer.step(state, sample)))
    return Surface(
        mu=np.array([one.mu for one in estimates]),
        informed=np.array([one.informed for one in estimates]),
    )


def surfaces(psi: np.ndarray, M: np.ndarray) -> dict[str, Surface]:
    """Every method on these points."""
    training = [steered(0.5), steered(1.8)]
    plain, correcting = train_neural_network(training), train_root_correction_network(training)
    mu = root(psi, M)
    # All that the mesh does not vary stays as half way back.
    middle = (BACK.start + BACK.stop) // 2
    few, many = (
        np.tile(make(SIMULATION)[middle], (psi.size, 1))
        for make in (neural_network_inputs, root_mu_correction_inputs)
    )
    for rows in (few, many):
        rows[:, 0], rows[:, 2] = psi, M
    many[:, -1] = mu
    common = {"model": Model(), "values": {"k": K}, "rig": RIG, "acquire": False}
    alone = Ekf(**common, tuning=PRIOR, iterations=ITERATIONS)
    follow = {"EKF": Ekf(**common, tuning=CLEAN), "MHE": Mhe(**common, tuning=CLEAN)}
    return {
        "root": always(mu),
        "neural network": always(plain.predict_friction(few)),
        "root and network": always(correcting.predict_friction(many)),
        "EKF, one sample alone": filtered(alone, psi, M, TURN, measured=False),
        **{
            f"{name}, one false sample in a stream": filtered(one, psi, M, middle, measured=True)
            for name, one in follow.items()
        },
    }


def tolerated(psi: np.ndarray, M: np.ndarray, right: NDArray[np.bool_]) -> float:
    """Least torque error that takes a method out of `NEAR`, median over the line [N m].

    psi and M are those of the mesh, shape (n,); where it is right has the shape (n, n), rows by torque.
    """
    along = np.argsort(SIMULATION.psi[BACK])
    back, torque = SIMULATION.psi[BACK][along], -SIMULATION.M_z[BACK][along]
    columns = np.flatnonzero((psi > back[0]) & (psi < back[-1]))
    wide = []
    for column in columns:
        miss = np.abs(M - np.interp(psi[column], back, torque))
        wide.append(miss[~right[:, column]].min(initial=np.ptp(M)))
    return float(np.median(wide))


def draw(path: Path, psi: np.ndarray, M: np.ndarray, results: dict[str, Surface]) -> None:
    """The estimate over the mesh, the right tenth outlined, what is not answered left white."""
    with figure_saved_as_png(path, 6.6) as figure:
        panels: list[Axes] = list(figure.subplots(2, 3, sharex=True, sharey=True).ravel())
        for axes, (name, surface) in zip(panels, results.items(), strict=True):
            mu, right = (
                np.ma.masked_where(~shown, surface.mu).reshape(M.size, psi.size)
                for shown in (surface.informed, surface.right)
            )
            shade = axes.pcolormesh(psi, M, mu, cmap="cividis", vmin=0, vmax=2)
            axes.pcolormesh(psi, M, right, cmap=ListedColormap(["#00c08b"]))
            axes.plot(SIMULATION.psi[BACK], -SIMULATION.M_z[BACK], "--", color=BEFORE, lw=0.9)
            axes.set(
                title=name, xlim=(-REACH[0], REACH[0]), ylim=(-REACH[1], REACH[1]), xticks=(-0.5, 0, 0.5)
            )
            axes.grid(False)
        for axes in panels[3:]:
            axes.set_xlabel("yaw angle ψ [rad]")
        for axes in panels[::3]:
            axes.set_ylabel("torque M [N m]")
        figure.colorbar(shade, ax=panels, label="estimated μ [1]; above 2 as 2", shrink=0.7)
        figure.suptitle(
            "green: within 10 % of μ = 1;  orange: what the simulation passes through;"
            "  white: the filter says it is not informed",
            color=MEASURED, fontsize=9,
        )  # fmt: skip


def main() -> None:
    """Print the shares and the tolerances, and draw the surfaces if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--mesh", type=int, default=100)
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args()
    psi, M = (np.linspace(-reach, reach, options.mesh) for reach in REACH)
    print(f"psi_max = {SIMULATION.psi[TURN]:.4f} rad; {options.mesh} x {options.mesh} points")
    results = surfaces(*(axis.ravel() for axis in np.meshgrid(psi, M)))
    line = surfaces(SIMULATION.psi[BACK], -SIMULATION.M_z[BACK])
    print("\n| method | answers | right, mesh | answers, line | right, line | torque error tolerated |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, surface in results.items():
        shares = [np.mean(part) for one in (surface, line[name]) for part in (one.informed, one.right)]
        most = tolerated(psi, M, surface.right.reshape(M.size, psi.size))
        limit = f"{most:.2f} N m" if most < np.ptp(M) else "any"
        print(f"| {name} | " + " | ".join(f"{share:.0%}" for share in shares) + f" | {limit} |")
    if options.picture:
        draw(options.picture, psi, M, results)


if __name__ == "__main__":
    main()
