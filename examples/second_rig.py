"""Somebody else's rig: a friction damper with backlash, diagnosed from its harmonic runs [Coble 2024].

    python examples/second_rig.py [DIR] [--stops] [--trials FOLDER] [--pictures FOLDER]

reads the damper's recordings from DIR (`brushgrip fetch friction-damper --out DIR`; default:
../shared/second_rig where there is one, else where `fetch` puts them). Of thirteen harmonic runs ten
train and three judge. Two earthquakes choose nothing: only what belongs to a recording (mu, a torque
zero, the place in the gap) is fitted to them, effect by effect, then nothing at all, then the place in
the gap is read off the first sample. Prints what the residual of the declared model follows, these
errors, and those on the recorded forces at 1024 Hz; `--pictures` draws them. `--stops` lets the search
replace the parabola by stops in parallel, which it tries only on request; `--trials` keeps trials, so
that an interrupted search goes on. Without the recordings it says so and ends.

A force at the rim of a drum of radius r and the rim's displacement are a torque F r and an angle x / r.
The wheel's model serves as it is: a patch that slides from its ends is a band that slides from its ends.
Forces are in kN here and torques in kN m, which brings them to a size that the effects' bounds are for;
no load was recorded, and a nominal one only sets the unit of mu.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from brushgrip.published.friction_damper import EARTHQUAKES, HARMONIC, damper_folder
from identification import (
    Channel,
    Diagnosis,
    FitOptions,
    Journal,
    LowPass,
    Pipeline,
    Recording,
    Resampler,
    Values,
    diagnose,
    fit,
    initial_guess,
    recording_from_raw,
)
from identification.diagnosis.unrefitted_prediction import simulated_minus_measured, values_from_training
from symbolic import CANDIDATES, Model, Rig, Tyre, effects_named
from symbolic.elements_in_series import series_deflection

BESIDE = Path("../shared/second_rig")
RAW_RATE, RADIUS, LOAD, KILO = 1024.0, 0.1, 50.0, 1e3
"""[Hz], [m], [kN], newtons in a kilonewton."""
RIG, TYRE = Rig(a=0.1, e=0.0), Tyre(k=1e5, mu=1.0)
CYCLES_RATE, EARTHQUAKE_RATE, CUTOFF = 896.0, 128.0, 30.0
"""Samples of a harmonic run, so that each counts alike; rate of an earthquake, highest low-pass [Hz]."""
JUDGES = ("harmonic_02", "harmonic_07", "harmonic_11")
"""Held out, one of each amplitude."""
WINDOWS = {"earthquake_DuzceMCE": (4608, 12288), "earthquake_KocaeliDBE": (6144, 14336)}
"""Samples over which the makers score an earthquake."""


def raw(folder: Path, name: str) -> dict[str, np.ndarray]:
    """Time [s], force [kN] against the motion's opposite, and displacement [m], as recorded."""
    with np.load(folder / f"{name}.npz") as arrays:
        columns = {name: np.asarray(arrays[name], dtype=float) for name in ("t", "F", "x")}
    return columns | {"F": columns["F"] / KILO}


def read(folder: Path, name: str) -> Recording:
    """The recording as torque and angle: low-pass, then fewer samples."""
    columns = raw(folder, name)
    rate = EARTHQUAKE_RATE if name in EARTHQUAKES else CYCLES_RATE / columns["t"][-1]
    return at_rate(name, columns, rate)


def at_rate(name: str, columns: Mapping[str, np.ndarray], rate: float) -> Recording:
    """What `raw` read as a recording with so many samples a second."""
    pipeline = Pipeline((LowPass(cutoff=min(0.4 * rate, CUTOFF)), Resampler(rate=rate)))
    values = {
        "psi": columns["x"] / RADIUS,
        "M_z": -columns["F"] * RADIUS,
        "F_N": np.full(columns["t"].size, LOAD),
    }
    channels = {channel: Channel(values=v, rate=RAW_RATE) for channel, v in values.items()}
    return recording_from_raw(name, channels, dict.fromkeys(channels, pipeline), RIG, TYRE)


def scored(folder: Path, recording: Recording, torque: np.ndarray) -> tuple[float, float]:
    """Error of a torque over the range of the recorded force [1]: whole path, the makers' window."""
    columns = raw(folder, recording.name)
    error = -np.interp(columns["t"], recording.t, torque) / RADIUS - columns["F"]
    places = slice(None), slice(*WINDOWS[recording.name])
    whole, window = (
        float(np.sqrt(np.mean(error[place] ** 2)) / np.ptp(columns["F"][place])) for place in places
    )
    return whole, window


def on_unseen(
    names: Sequence[str], training: Sequence[Recording], unseen: Sequence[Recording]
) -> Sequence[Mapping[str, np.ndarray]]:
    """Residuals of unseen recordings, shared values as the training runs have them [kN m].

    First those with what belongs to a recording fitted, then with nothing fitted: in the middle of the
    gap, and at the place in it that the first sample's torque tells.
    """
    model = Model(effects=effects_named(names), discretised=True)
    known = fit(model, training, options=FitOptions(tolerance=1e-4))
    start = Values(tyre=known.values.tyre, own=initial_guess(model, unseen).own)
    own = fit(model, unseen, start, FitOptions(free_shared=False))
    predicted = {r.name: values_from_training(known, training, r).of(r) for r in unseen}
    begun = {r.name: predicted[r.name] | place_in_gap(model, predicted[r.name], r) for r in unseen}
    parts = (
        {r.name: simulated_minus_measured(model, r, v[r.name]) for r in unseen}
        for v in (predicted, begun)
    )
    return own.residuals, *parts


def place_in_gap(model: Model, values: Mapping[str, float], recording: Recording) -> dict[str, float]:
    """The pretwist of a wheel that rests under the first sample's torque; none without a gap."""
    deflection = series_deflection(model)
    if deflection is None or "pretwist.psi_0" not in values:
        return {}
    elements = [recording.F_N[0], *np.asarray(model.theta(values)).ravel()]
    return {"pretwist.psi_0": -float(deflection(recording.M_z[0], elements))}


def lacks(folder: Path, names: Sequence[str], published: str) -> bool:
    """Whether a folder lacks one of these recordings, which is printed with how to get them."""
    absent = [name for name in names if not (folder / f"{name}.npz").is_file()]
    if absent:
        print(f"skipped: no {absent[0]}.npz in {folder}; 'brushgrip fetch {published}' gets it")
    return bool(absent)


def print_progress(message: str, done: int, total: int) -> None:
    """What is being done, on standard error."""
    if done == 0:
        print(f"{message} ({total})", file=sys.stderr)


def print_diagnosis(diagnosis: Diagnosis) -> None:
    """What was found from the harmonic runs alone."""
    print(f"before: {diagnosis.signatures_before.summary_paragraph}\n")
    print("stage      training   held out  [% of range]")
    for name in ("declared", "before", "after"):
        summary = getattr(diagnosis, name).summary()
        print(f"{name:10}{_percent(summary['torque_nrmse'])}{_percent(summary['holdout_torque_nrmse'])}")
    for effect in diagnosis.effects:
        rivals = ", ".join(effect.indistinguishable_from) or "-"
        print(
            f"+ {effect.name}: {_percent(effect.holdout_nrmse_after)}, indistinguishable from {rivals}"
        )
        for name, p in effect.parameters.items():
            if "[" not in name:
                print(f"    {name} = {p.value:.4g} ± {p.std or np.nan:.2g} {p.unit}")
    print(f"unexplained: {diagnosis.unexplained.present}. {diagnosis.unexplained.evidence}")
    print("\n".join(f"note: {note}" for note in diagnosis.notes))


def _percent(share: float | None) -> str:
    return f"{100 * (share or np.nan):8.2f}"


Stages = Mapping[str, Mapping[str, np.ndarray]]
"""Name of a stage -> name of a recording -> its torque [kN m]."""


def unseen_torques(
    diagnosis: Diagnosis, training: Sequence[Recording], unseen: Sequence[Recording], folder: Path
) -> Stages:
    """The torque on unseen recordings as effects are added, printed with its errors."""
    found = [effect.name for effect in diagnosis.effects]
    print(
        "\nearthquakes, path and window at 1024 Hz [% of range]; then the same with nothing refitted,"
        " and with the place in the gap by the first force"
    )
    stages = {}
    for count in range(len(found) + 1):
        fitted = on_unseen(found[:count], training, unseen)
        label = "declared model, refitted" if count == 0 else f"+ {found[count - 1]}"
        stages[label] = {r.name: r.M_z + fitted[0][r.name] for r in unseen}
        figures = [x for off in fitted for r in unseen for x in scored(folder, r, r.M_z + off[r.name])]
        print(f"{label:26}{' '.join(map(_percent, figures))}", flush=True)
    return stages


def draw(diagnosis: Diagnosis, stages: Stages, unseen: Sequence[Recording], out: Path) -> None:
    """Loops of the harmonic runs that judge, and the earthquakes within the makers' windows."""
    series = {each.name: each for each in diagnosis.series}
    with figure_saved_as_png(out / "loops.png", 3.6) as figure:
        for axis, name in zip(figure.subplots(1, len(JUDGES)), JUDGES, strict=True):
            each = series[name]
            lines = _lines(axis, KILO * RADIUS * each.psi, (each.measured, each.before, each.after))
            axis.set(title=f"{name}, held out", xlabel="displacement [mm]", ylabel="force [kN]")
        legend_above(figure, lines)
    first, *_, last = stages.values()
    with figure_saved_as_png(out / "earthquakes.png", 5.0) as figure:
        for axis, recording in zip(figure.subplots(len(unseen), 1), unseen, strict=True):
            name = recording.name
            place = slice(*np.searchsorted(recording.t, np.array(WINDOWS[name]) / RAW_RATE))
            torques = [torque[place] for torque in (recording.M_z, first[name], last[name])]
            lines = _lines(axis, recording.t[place], torques)
            axis.set(title=f"{name}, chose nothing", xlabel="time [s]", ylabel="force [kN]")
        legend_above(figure, lines)


def _lines(axis: Axes, along: np.ndarray, torques: Sequence[np.ndarray]) -> list[Artist]:
    labels = ("measured", "declared model, refitted", "with the effects found")
    colours = (MEASURED, BEFORE, AFTER)
    return [
        axis.plot(along, -torque / RADIUS, color=colour, label=label, linewidth=0.9)[0]
        for torque, colour, label in zip(torques, colours, labels, strict=True)
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Diagnose the damper."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--stops", action="store_true")
    parser.add_argument("--trials", type=Path)
    options = parser.parse_args(arguments)
    folder = options.folder or (BESIDE if BESIDE.is_dir() else damper_folder())
    if lacks(folder, (*HARMONIC, *EARTHQUAKES), "friction-damper"):
        return
    groups = ([name for name in HARMONIC if name not in JUDGES], JUDGES, EARTHQUAKES)
    training, judges, unseen = ([read(folder, name) for name in names] for names in groups)
    candidates = [*CANDIDATES, *(["stops"] if options.stops else [])]
    journal = Journal(folder=options.trials) if options.trials else None
    diagnosis = diagnose(
        training, judges, candidates=candidates, journal=journal, progress=print_progress
    )
    print_diagnosis(diagnosis)
    stages = unseen_torques(diagnosis, training, unseen, folder)
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        draw(diagnosis, stages, unseen, options.pictures)


if __name__ == "__main__":
    main()
