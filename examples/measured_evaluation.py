"""The evaluation of measurements of [Györök 2022], section 5.3, again: preprocessing and zones.

    python examples/measured_evaluation.py [DIR] [--pictures FOLDER]

First, raw channels at 4 kHz with offsets, noise and mains hum, made here so that the truth is known,
become a recording at 100 Hz; beside it every fortieth sample, as in the thesis. Then direction and zones
over time (figures 5.6 and 5.7): of the steel recordings in DIR (`brushgrip fetch`; default:
BRUSHGRIP_DATA), else of embedded ones, where more than five zones occur. `--pictures` writes zones.png.
Table 6.1 and figure 5.10 are those of `brushgrip compare`.
"""

import argparse
import os
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.patches import Patch

from brushgrip.comparison.recordings_with_reference_friction import Case, make_case
from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from identification import (
    Channel,
    OffsetRemoved,
    Pipeline,
    Recording,
    Scaled,
    default_pipeline,
    read_recording,
    read_rig,
    recording_from_raw,
)
from identification.loop_plot import matplotlib_text
from observers import Ekf, Observer, RootObserver, ZoneHistory, run, zone_history
from symbolic import Model, Rig, Tyre, simulate

EMBEDDED = Path(__file__).resolve().parent / "recordings"
PLANTED = {"holdout_c": 1.37, "holdout_d": 1.28}
"""Embedded recordings and their friction at the reference sliding speed [1]."""
RIG, TYRE = Rig(a=0.045, e=0.009), Tyre(k=2.4e6, mu=1.3)
RAW_RATE, RATE, DURATION, LOAD = 4000.0, 100.0, 10.0, 400.0
"""[Hz], [Hz], [s], [N]."""
QUIET = (0.0, 0.4)
"""Before the wheel turns [s]."""
VOLTS = {"psi": 0.1, "M_z": -5.0, "F_N": 250.0}
"""Units of a channel a volt: [rad], [N m], [N]."""
SHADES = {1: BEFORE, -1: AFTER}
SHADE = 0.15
OFFSETS = {"psi": 0.7, "M_z": -0.4, "F_N": 0.9}
HUM, NOISE = 0.05, 0.01
"""Amplitude of mains hum, standard deviation of noise, in every channel [V]."""


def true_channels() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """A wheel that is quiet, then swings wider and wider: time and what the sensors should show."""
    t = np.arange(round(DURATION * RAW_RATE) + 1) / RAW_RATE
    turning = np.maximum(t - 0.5, 0.0)
    psi = 0.04 * turning * np.sin(2 * np.pi * turning / 3.0)
    signals = np.vstack([psi, np.gradient(psi, t), np.full((2, t.size), [[LOAD], [1 / RAW_RATE]])])
    theta = np.asarray(Model().theta({"mu": TYRE.mu, "k": TYRE.k})).ravel()
    M_z = simulate(Model(), signals, theta, np.array([RIG.a, RIG.e])).M_z
    return t, {"psi": psi, "M_z": M_z, "F_N": signals[2]}


def raw_channels(t: np.ndarray, truth: dict[str, np.ndarray]) -> dict[str, Channel]:
    """The same as the amplifiers give it, in volts."""
    rng, hum = np.random.default_rng(0), HUM * np.sin(2 * np.pi * 50 * t + 1)
    return {
        name: Channel(
            values=values / VOLTS[name] + OFFSETS[name] + hum + NOISE * rng.standard_normal(t.size),
            rate=RAW_RATE,
        )
        for name, values in truth.items()
    }


def undersampled(raw: Channel, factor: float, level: float) -> Channel:
    """Offset off, then every fortieth sample."""
    clean = OffsetRemoved(start=QUIET[0], stop=QUIET[1], level=level)(Scaled(factor=factor)(raw))
    return Channel(values=clean.values[:: round(RAW_RATE / RATE)], rate=RATE)


def preprocessing() -> None:
    """Print what preprocessing leaves of noise and hum, and what that does to friction."""
    t, truth = true_channels()
    raw = raw_channels(t, truth)
    level = {"psi": 0.0, "M_z": 0.0, "F_N": LOAD}
    with_filter = {n: default_pipeline(VOLTS[n], QUIET, level=level[n], rate=RATE) for n in VOLTS}
    nothing = {n: Pipeline(()) for n in VOLTS}
    bare = {n: undersampled(raw[n], VOLTS[n], level[n]) for n in VOLTS}
    every = round(RAW_RATE / RATE)
    for label, channels, pipelines in (
        ("filtered and resampled", raw, with_filter),
        ("every fortieth sample", bare, nothing),
    ):
        recording = recording_from_raw(label, channels, pipelines, RIG, TYRE)
        psi, M_z = (rms(getattr(recording, n) - truth[n][::every]) for n in ("psi", "M_z"))
        observers = (Ekf(model=Model(), values={"k": TYRE.k}, rig=RIG), RootObserver(rig=RIG, k=TYRE.k))
        ekf, root = (friction_error(recording, observer) for observer in observers)
        print(
            f"{label}: psi off by {1e3 * psi:.3f} mrad, M_z by {M_z:.4f} N m;"
            f" mu off by {ekf:.4f} (EKF), {root:.4f} (root)"
        )


def friction_error(recording: Recording, observer: Observer) -> float:
    """RMSE of mu over the second half."""
    mu = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z).mu
    return rms(mu[mu.size // 2 :] - TYRE.mu)


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def cases(folder: Path | None) -> list[Case]:
    """The steel recordings of a folder with the author's estimates, or the embedded ones."""
    if folder is not None:
        return [make_case(read_recording(p), folder) for p in sorted(folder.glob("fem*.mat"))]
    rig = read_rig(EMBEDDED / "rig.toml")
    return [
        make_case(read_recording(EMBEDDED / f"{name}.csv", rig), None, mu)
        for name, mu in PLANTED.items()
    ]


def zones(case: Case) -> None:
    """Print how the zones are counted, beside the author's columns where he has some."""
    recording, author = case.recording, case.author
    history = zone_history(recording.psi)
    beyond = float((history.true_zones > 5).mean())
    most = history.true_zones.max()
    line = f"{recording.name}: up to {most} zones, more than five {beyond:.1%} of the time"
    if author is not None:
        same = float((history.zones[case.span] == author.zones).mean())
        direction = float((history.direction[case.span] == author.direction).mean())
        line += f"; as the author counts: zones {same:.1%}, direction {direction:.1%}"
    print(line)


def draw_zones(path: Path, recording: Recording, history: ZoneHistory) -> None:
    """Draw angle, last reversal and number of zones as in [Györök 2022], figures 5.6 and 5.7."""
    t = recording.t
    with figure_saved_as_png(path, 5.2) as figure:
        angle, zones = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for side, colour in SHADES.items():
            for axes in (angle, zones):
                axes.fill_between(
                    t, 0, 1, where=(history.direction == side).tolist(), step="post", color=colour,
                    alpha=SHADE, lw=0, transform=axes.get_xaxis_transform(),
                )  # fmt: skip
        lines: list[Artist] = []
        lines += angle.plot(t, recording.psi, color=MEASURED, label="yaw angle ψ")
        label = "$ψ_{max}$, angle of the last reversal"
        lines += angle.step(t, history.psi_max, where="post", color=AFTER, ls="--", label=label)
        label = "zones, with every reversal counted"
        lines += zones.step(t, history.true_zones, where="post", color=MEASURED, lw=0.9, label=label)
        label = "zones by the state machine of [Györök 2022]"
        lines += zones.step(t, history.zones, where="post", color=BEFORE, lw=2.2, label=label)
        angle.set(title=matplotlib_text(recording.name), ylabel="yaw angle [rad]")
        angle.margins(x=0)
        zones.set_ylabel("number of zones [1]")
        most = int(history.true_zones.max())
        zones.set_yticks(np.arange(3, most + 1, 2 * max(1, (most - 3) // 12)))
        zones.set(ylim=(2.5, most + 0.5), xlabel="time t [s]")
        key = [
            Patch(color=SHADES[side], alpha=SHADE, lw=0, label=f"{name} direction, by the state machine")
            for side, name in ((1, "positive"), (-1, "negative"))
        ]
        figure.align_ylabels()
        legend_above(figure, [*lines, *key])


def main() -> None:
    """Print preprocessing and zones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=os.environ.get("BRUSHGRIP_DATA"))
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    preprocessing()
    print()
    selection = cases(None if options.folder is None else Path(options.folder))
    for case in selection:
        zones(case)
    if options.pictures is not None:
        options.pictures.mkdir(parents=True, exist_ok=True)
        first = selection[0].recording
        draw_zones(options.pictures / "zones.png", first, zone_history(first.psi))


if __name__ == "__main__":
    main()
