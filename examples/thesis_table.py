"""The root solve of [Györök 2022] beside EKF and MHE: on published simulations, and beyond five zones.

    python examples/thesis_table.py [--data DIR] [PICTURE.png]

DIR holds the published simulations, default see published.py; without them that table stays
out. Their torque is one sample late against the angle. Who does not know pays for it; who does either
shifts it or declares it, as the effect `sensor_delay`. EKF and MHE are also tuned to a clean torque and
a good model: the default tuning, made for measured torques, hardly learns in five seconds of such files.

The second table stands on our own simulation of a profile with turns inside turns. The picture is the
right half of the thesis's figures 4.9 and 4.10, with the filter in the place of the networks.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from brushgrip.pictures.style import MEASURED, QUIET, TRACKS, figure_saved_as_png, legend_above
from identification import Recording
from observers import Ekf, Mhe, Observer, RootObserver, Tuning, run
from published import published_simulation, simulation_folder
from symbolic import Model, Tyre, effects_named
from thesis_profile import DT, FACTORS, NESTED, RIG, SETTLED, K, rmse, steered, zones

CLEAN = Tuning(noise=1e-3, error=1e-3, error_travel=0.0, mu_walk=1e-3, zero_std=1e-4, zero_walk=0.0)
"""Tuning for a simulated torque: without noise, by the same model."""
DELAYED = Model(effects=effects_named(["sensor_delay"]))
DRAWN = 0.5
"""Friction of the picture; 1, the thesis's, is where our priors stand anyway [1]."""
STEADY = 10
"""Samples after the zones have become more than five, until errors count."""


def estimated(observer: Observer, recording: Recording) -> np.ndarray:
    """Friction over the recording, causally [1]."""
    channels = (recording.t, recording.psi, recording.F_N, recording.M_z)
    return run(observer, *channels).mu


def root() -> RootObserver:
    """The thesis's method."""
    return RootObserver(rig=RIG, k=K)


def ours(kind: type[Ekf] | type[Mhe], *, delayed: bool = False, tuning: Tuning = CLEAN) -> Observer:
    """EKF or MHE alone, from mu = 1.0 +- 0.5; delayed where the torque is known to be late."""
    if delayed:
        values = {"k": K, "sensor_delay.delay": DT}
        return kind(model=DELAYED, values=values, rig=RIG, tuning=tuning, acquire=False)
    return kind(model=Model(), values={"k": K}, rig=RIG, tuning=tuning, acquire=False)


def in_time(late: Recording) -> Recording:
    """The recording with its torque a sample earlier; the last sample has none."""
    return replace(late, M_z=np.append(late.M_z[1:], np.nan))


def published_table(folder: Path) -> None:
    """Print everyone's error on the published simulations."""
    print("published simulations: RMSE of mu from t = 0.5 s on\n")
    print("|     | author | root, torque late | root, shifted | EKF, shifted | MHE, shifted |", end="")
    print(" EKF, delay declared | MHE, delay declared | EKF, shifted, default tuning |")
    print("|---|" + "---:|" * 8)
    worst = []
    for mu in FACTORS:
        if columns := published_simulation(folder, mu):
            author, rate = columns.pop("mu"), np.gradient(columns["psi"], columns["t"])
            tyre = Tyre(k=K, mu=mu)
            late = Recording(name=f"mu = {mu:g}", **columns, psi_dot=rate, rig=RIG, tyre=tyre)
            shifted = in_time(late)
            errors = [
                rmse(late, author),
                rmse(late, estimated(root(), late)),
                *(rmse(shifted, estimated(one, shifted)) for one in (root(), ours(Ekf), ours(Mhe))),
                *(rmse(late, estimated(ours(kind, delayed=True), late)) for kind in (Ekf, Mhe)),
                rmse(shifted, estimated(ours(Ekf, tuning=Tuning()), shifted)),
            ]
            print(f"| {mu:g} |" + "|".join(f" {error:.4f} " for error in errors) + "|")
            off = np.where(late.t >= SETTLED, np.abs(author / mu - 1), 0.0)
            worst.append(f"{off.max():.1%} at {late.t[off.argmax()]:.2f} s (mu = {mu:g})")
    print(f"\nthe author's largest errors: {', '.join(worst)}")


def nested_table() -> dict[str, np.ndarray]:
    """Print everyone's error beyond five zones; returns the tracks for `DRAWN`."""
    print("\nmore than five zones, own simulation: greatest error of mu there, and RMSE\n")
    print("| mu | zones | root | EKF | MHE |\n|---|---|---:|---:|---:|")
    tracks: dict[str, np.ndarray] = {}
    for mu in FACTORS:
        recording = steered(mu, NESTED)
        count = zones(recording.psi)
        beyond = np.arange(count.size) >= np.argmax(count > 5) + STEADY
        cells = []
        for name, observer in {"root": root(), "EKF": ours(Ekf), "MHE": ours(Mhe)}.items():
            track = estimated(observer, recording)
            error = track[beyond] / mu - 1
            cells.append(f"{np.abs(error).max():.2%}, {np.sqrt(np.mean(error**2)):.2%}")
            if mu == DRAWN:
                tracks[name] = track
        print(f"| {mu:g} | up to {count.max()} | {' | '.join(cells)} |")
    return tracks


def draw(path: Path, tracks: dict[str, np.ndarray]) -> None:
    """Angle and zones, and mu by everyone, over the nested profile."""
    recording = steered(DRAWN, NESTED)
    count = zones(recording.psi)
    with figure_saved_as_png(path, 5.0) as figure:
        angle, friction = figure.subplots(2, 1, sharex=True)
        angle.plot(recording.t, recording.psi, color=MEASURED)
        angle.set_ylabel("yaw angle ψ [rad]")
        lines = [friction.axhline(DRAWN, color=QUIET, label="true")]
        for (name, track), colour, style in zip(tracks.items(), TRACKS, ("-", "-", "--"), strict=False):
            lines += friction.plot(recording.t, track, style, color=colour, label=name)
        for axes in (angle, friction):
            beyond = axes.fill_between(
                recording.t, 0, 1, where=count > 5, transform=axes.get_xaxis_transform(),
                color=QUIET, alpha=0.3, lw=0, label="more than five zones",
            )  # fmt: skip
        friction.set(ylabel="friction coefficient μ [1]", xlabel="time [s]", ylim=(0, 2))
        figure.align_ylabels()
        legend_above(figure, [*lines, beyond])


def main() -> None:
    """Print both tables, and draw the second if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--data", type=Path, default=simulation_folder())
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args()
    if any(options.data.glob("sim_mu_*.csv")):
        published_table(options.data)
    else:
        print(f"no published simulations in {options.data}")
    tracks = nested_table()
    if options.picture:
        draw(options.picture, tracks)


if __name__ == "__main__":
    main()
