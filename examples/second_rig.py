"""Somebody else's rig: a friction damper with backlash, diagnosed from its harmonic runs [Coble 2024].

    python examples/second_rig.py [DIR] [--pictures FOLDER]

reads the damper's recordings from DIR (`brushgrip fetch friction-damper --out DIR`; default:
../shared/second_rig where there is one, else where `fetch` puts them). Thirteen harmonic runs train, two
earthquakes are held out: they choose among effects, none is fitted to them. Prints what the residual of
the declared model follows, the errors before and after by effect, and those on the recorded forces at
1024 Hz; `--pictures` draws them. Without the recordings it says so and ends.

A force at the rim of a drum of radius r and the rim's displacement are a torque F r and an angle x / r.
The wheel's model serves as it is: a patch that slides from its ends is a band that slides from its ends.
Forces are in kN here and torques in kN m, which brings them to a size that the effects' bounds are for;
no load was recorded, and a nominal one only sets the unit of mu.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from numpy.typing import NDArray

from brushgrip.friction_damper import EARTHQUAKES, HARMONIC, damper_folder
from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, legend_above, picture
from identification import (
    Channel,
    Diagnosis,
    LowPass,
    Pipeline,
    Recording,
    Resampled,
    Series,
    diagnose,
    recording_from_raw,
)
from symbolic import Rig, Tyre

Array = NDArray[np.float64]
BESIDE = Path("../shared/second_rig")
RAW_RATE, RADIUS, LOAD, KILO = 1024.0, 0.1, 50.0, 1e3
"""[Hz], [m], [kN], newtons in a kilonewton."""
RIG, TYRE = Rig(a=0.1, e=0.0), Tyre(k=1e5, mu=1.0)
CYCLES_RATE, EARTHQUAKE_RATE, CUTOFF = 896.0, 128.0, 30.0
"""Samples of a harmonic run, so that each counts alike; rate of an earthquake, highest low-pass [Hz]."""
WINDOWS = {"earthquake_DuzceMCE": (4608, 12288), "earthquake_KocaeliDBE": (6144, 14336)}
"""Samples over which the makers score an earthquake."""


def raw(folder: Path, name: str) -> dict[str, Array]:
    """Time [s], force [kN] against the motion's opposite, and displacement [m], as recorded."""
    with np.load(folder / f"{name}.npz") as arrays:
        return {"t": arrays["t"], "F": arrays["F"] / KILO, "x": arrays["x"]}


def read(folder: Path, name: str) -> Recording:
    """The recording as torque and angle: low-pass, then fewer samples."""
    columns = raw(folder, name)
    seconds = columns["t"][-1]
    rate = EARTHQUAKE_RATE if name in EARTHQUAKES else CYCLES_RATE / seconds
    pipeline = Pipeline((LowPass(cutoff=min(0.4 * rate, CUTOFF)), Resampled(rate=rate)))
    values = {
        "psi": columns["x"] / RADIUS,
        "M_z": -columns["F"] * RADIUS,
        "F_N": np.full(columns["t"].size, LOAD),
    }
    channels = {channel: Channel(values=v, rate=RAW_RATE) for channel, v in values.items()}
    return recording_from_raw(name, channels, dict.fromkeys(channels, pipeline), RIG, TYRE)


def scored(folder: Path, series: Series, torque: Array) -> tuple[float, float]:
    """Error of a torque over the range of the recorded force [1]: whole path, the makers' window."""
    columns = raw(folder, series.name)
    error = -np.interp(columns["t"], series.t, torque) / RADIUS - columns["F"]
    places = slice(None), slice(*WINDOWS[series.name])
    whole, window = (
        float(np.sqrt(np.mean(error[place] ** 2)) / np.ptp(columns["F"][place])) for place in places
    )
    return whole, window


def print_errors(diagnosis: Diagnosis, folder: Path) -> None:
    """Errors over range, per stage and per effect."""
    stages = {"declared": diagnosis.declared, "before": diagnosis.before, "after": diagnosis.after}
    print("\nstage      harmonic  earthquakes  [% of range, low-passed]")
    for name, errors in stages.items():
        summary = errors.summary()
        print(f"{name:10}{_percent(summary['torque_nrmse'])}{_percent(summary['holdout_torque_nrmse'])}")
    print("\nadded effect           earthquakes  indistinguishable from")
    for effect in diagnosis.effects:
        rivals = ", ".join(effect.indistinguishable_from) or "-"
        print(f"{effect.name:22}{_percent(effect.holdout_nrmse_after)}  {rivals}")
        for name, p in effect.parameters.items():
            if "[" not in name:
                print(f"  {name} = {p.value:.4g} ± {p.std or np.nan:.2g} {p.unit}")
    print("\nrecorded force, 1024 Hz   before: path, window   after: path, window")
    for series in diagnosis.series:
        if series.held_out:
            figures = [*scored(folder, series, series.before), *scored(folder, series, series.after)]
            print(f"{series.name:24}{' '.join(map(_percent, figures))}")
    print(f"\nunexplained: {diagnosis.unexplained.present}. {diagnosis.unexplained.evidence}")


def _percent(share: float | None) -> str:
    return f"{100 * (share or np.nan):11.2f}"


def draw(diagnosis: Diagnosis, out: Path) -> None:
    """Loops of harmonic runs, and the earthquakes within the makers' windows."""
    series = {each.name: each for each in diagnosis.series}
    with picture(out / "loops.png", 3.6) as figure:
        axes = figure.subplots(1, 3)
        for axis, name in zip(axes, ("harmonic_02", "harmonic_06", "harmonic_11"), strict=True):
            lines = _lines(axis, series[name], series[name].psi * RADIUS * KILO, slice(None))
            axis.set(title=name, xlabel="displacement [mm]", ylabel="force [kN]")
        legend_above(figure, lines)
    with picture(out / "earthquakes.png", 5.0) as figure:
        for axis, name in zip(figure.subplots(len(EARTHQUAKES), 1), EARTHQUAKES, strict=True):
            ends = np.searchsorted(series[name].t, np.array(WINDOWS[name]) / RAW_RATE)
            lines = _lines(axis, series[name], series[name].t, slice(*ends))
            axis.set(title=f"{name}, held out", xlabel="time [s]", ylabel="force [kN]")
        legend_above(figure, lines)


def _lines(axis: Axes, series: Series, along: Array, place: slice) -> list[Artist]:
    styles: Mapping[str, tuple[Array, str]] = {
        "measured": (series.measured, MEASURED),
        "declared model, refitted": (series.before, BEFORE),
        "with the effects found": (series.after, AFTER),
    }
    return [
        axis.plot(along[place], -torque[place] / RADIUS, color=colour, label=label, linewidth=0.9)[0]
        for label, (torque, colour) in styles.items()
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Diagnose the damper."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args(arguments)
    folder = options.folder or (BESIDE if BESIDE.is_dir() else damper_folder())
    absent = [n for n in (*HARMONIC, *EARTHQUAKES) if not (folder / f"{n}.npz").is_file()]
    if absent:
        print(f"skipped: no {absent[0]}.npz in {folder}; 'brushgrip fetch friction-damper' gets it")
        return
    training, held_out = ([read(folder, name) for name in names] for names in (HARMONIC, EARTHQUAKES))
    diagnosis = diagnose(training, held_out, jobs=1)
    print(f"before: {diagnosis.signatures_before.reading}")
    print_errors(diagnosis, folder)
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        draw(diagnosis, options.pictures)


if __name__ == "__main__":
    main()
