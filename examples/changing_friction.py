"""Friction that somebody changes while it is measured: a damper whose band is pulled [Coble 2024].

    python examples/changing_friction.py [DIR] [--model MODEL.json] [--rate HZ] [--walk W]
                                         [--pictures FOLDER]

reads the recordings from DIR (`brushgrip fetch changed-friction --out DIR`; default:
../shared/third_check where there is one, else where `fetch` puts them). A diagnosis of the six runs of
constant band tension makes the model, which is written to MODEL.json, or read from it where it exists.
Then observers run along the twelve runs. Friction without a model is the median of |F| over the last
quarter of each stroke; the estimate is the median of mu_eff there. Prints, for each observer: scatter
of estimate over force on the constant runs; how often it is within 10 % (of the mean ratio there) while
actuators pull; alarms within a stroke whose force differs from that of the last one the same way by more
than 25 %; alarms on the constant runs; the share of strokes whose band holds; and the share of samples
that is usable. Other runs of the data set that lie in DIR, named as these are (tension_*, harmonic*,
step*) with the same arrays, are judged after them, by the model and the scale of these. Units are
those of `second_rig.py`.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from brushgrip.published.friction_damper import CHANGED, CONSTANT, changed_friction_folder
from identification import FoundModel, Recording, diagnose, model_text, read_model
from observers import AligningTorque, DirectionalFriction, Ekf, Estimates, Mhe, Status, run, tuning_for
from second_rig import CYCLES_RATE, LOAD, RIG, at_rate, lacks, print_diagnosis, print_progress, raw

BESIDE = Path("../shared/third_check")
RATE, STROKE, PULLED = 100.0, 0.2, 3.0
"""Samples a second for the observers; least stroke [rad]; when actuators begin to pull [s]."""
SHOWN = ("harmonic0.03ea1backward", "step0.03ea1forward")
OBSERVERS = {
    "ekf": (Ekf, AligningTorque(stiffness=True)),
    "ekf --by-direction": (Ekf, DirectionalFriction()),
    "mhe --by-direction": (Mhe, DirectionalFriction()),
}


class Stroke(NamedTuple):
    """One way of the damper: when it begins [s], friction of force and estimate, what is usable [1]."""

    begin: float
    force: float
    mu: float
    std: float
    alarm: bool
    usable: float


def model_of(folder: Path, path: Path) -> FoundModel:
    """The model of the constant runs, diagnosed where it is not in the file yet."""
    if not path.is_file():
        runs = {name: raw(folder, name) for name in CONSTANT}
        training = [at_rate(name, run, CYCLES_RATE / run["t"][-1]) for name, run in runs.items()]
        diagnosis = diagnose(training, [], progress=print_progress)
        print_diagnosis(diagnosis)
        path.write_text(model_text(diagnosis), encoding="utf-8")
    return read_model(path)


def observed(found: FoundModel, name: str, recording: Recording) -> Estimates:
    """Friction along a recording by one of `OBSERVERS`, as the command line sets it up."""
    kind, measurement_model = OBSERVERS[name]
    observer = kind(
        model=found.model, values=found.values_for_estimation(), rig=RIG,
        measurement_model=measurement_model,
        tuning=tuning_for(found, by_direction=isinstance(measurement_model, DirectionalFriction)),
    )  # fmt: skip
    return run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)


def strokes(recording: Recording, found: Estimates) -> list[Stroke]:
    """The strokes of a run, less what comes before the first turn and after the last."""
    psi, rows = recording.psi, []
    smooth = np.convolve(psi, np.ones(5) / 5, "same")
    for a, b in pairwise(np.flatnonzero(np.diff(np.sign(np.diff(smooth)))) + 1):
        if abs(psi[b] - psi[a]) < STROKE:
            continue
        late = np.arange(a, b)[np.abs(psi[a:b] - psi[b]) < abs(psi[b] - psi[a]) / 4]
        force = np.median(np.abs(recording.M_z[late])) / (0.375 * LOAD * RIG.a)
        mu, std = np.median(found.mu_eff[late]), np.median(found.mu_eff_std[late])
        alarm = bool((found.status[a:b] & Status.RESET).any())
        usable = float(found.usable[a:b].mean())
        rows.append(Stroke(recording.t[a], float(force), float(mu), float(std), alarm, usable))
    return rows


def runs_beside(folder: Path) -> tuple[list[str], list[str]]:
    """Names of further runs in a folder: of constant tension, and with actuators."""
    patterns = ("tension_*.npz",), ("harmonic[0-9]*.npz", "step[0-9]*.npz")
    constant, changed = (
        sorted({path.stem for each in those for path in folder.glob(each)} - {*CONSTANT, *CHANGED})
        for those in patterns
    )
    return constant, changed


def figures(
    runs: Mapping[str, Sequence[Stroke]],
    constant: Sequence[str] = CONSTANT,
    changed: Sequence[str] = CHANGED,
) -> list[str]:
    """Scatter, share within 10 %, alarms, false alarms, shares of strokes in the band, and usable.

    Scatter is about the mean ratio on the runs in `CONSTANT`, which scales all of them.
    """
    ratio = float(np.mean([s.mu / s.force for name in CONSTANT for s in runs[name]]))
    still = [stroke for name in constant for stroke in runs[name]]
    scatter = _root_mean_square([s.mu / s.force / ratio - 1 for s in still])
    followed, alarms = [], []
    for name in changed:
        for before, now in zip(runs[name], runs[name][2:], strict=False):
            if now.begin > PULLED:
                followed.append(abs(now.mu / (ratio * now.force) - 1) < 0.1)
                if abs(np.log(now.force / before.force)) > np.log(1.25):
                    alarms.append(now.alarm)
    bands = [
        [abs(s.mu - ratio * s.force) < 1.96 * s.std for name in names for s in runs[name]]
        for names in (constant, changed)
    ]
    usable = [[s.usable for name in names for s in runs[name]] for names in (constant, changed)]
    return [
        scatter, f"{_share(followed)} of {len(followed)}",
        f"{sum(alarms)} of {len(alarms)}", f"{sum(s.alarm for s in still)} of {len(still)}",
        *map(_share, (*bands, *usable)),
    ]  # fmt: skip


def _root_mean_square(deviations: Sequence[float]) -> str:
    return f"{100 * np.sqrt(np.mean(np.square(deviations))):.1f} %" if deviations else "–"


def _share(cases: Sequence[float]) -> str:
    return f"{100 * np.mean(cases):.0f} %" if cases else "–"


def draw(along: Mapping[str, tuple[Recording, Mapping[str, Estimates]]], out: Path) -> None:
    """Friction of force and estimates along the runs in `SHOWN`."""
    with figure_saved_as_png(out / "friction.png", 5.0) as figure:
        for axis, name in zip(figure.subplots(len(SHOWN), 1), SHOWN, strict=True):
            recording, found = along[name]
            force, label = np.abs(recording.M_z) / (0.375 * LOAD * RIG.a), "|force|, no model"
            lines = axis.plot(recording.t, force, color=MEASURED, linewidth=0.8, label=label)
            for label, colour in (("ekf", BEFORE), ("ekf --by-direction", AFTER)):
                lines += axis.plot(recording.t, found[label].mu_eff, color=colour, label=label)
            axis.set(title=name, xlabel="time [s]", ylabel="friction [1]", xlim=(1, 13), ylim=(0, 1.8))
        legend_above(figure, lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Follow friction that is changed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--model", type=Path, default=Path("changing_friction_model.json"))
    parser.add_argument("--rate", type=float, default=RATE)
    parser.add_argument("--walk", type=float, help="of friction by direction, in place of the model's")
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args(arguments)
    folder = options.folder or (BESIDE if BESIDE.is_dir() else changed_friction_folder())
    if lacks(folder, (*CONSTANT, *CHANGED), "changed-friction"):
        return
    found = model_of(folder, options.model)
    if options.walk is not None and found.error:
        found = replace(found, error=replace(found.error, friction_walk=options.walk))
    print(f"friction walk {(found.error and found.error.friction_walk) or np.nan:.3f}/sqrt(s)")
    beside = runs_beside(folder)
    names = (*CONSTANT, *CHANGED, *beside[0], *beside[1])
    runs = {name: at_rate(name, raw(folder, name), options.rate) for name in names}
    print("observer             scatter  within 10 %  alarms  false  band, constant, changed  usable")
    along = {name: (runs[name], {o: observed(found, o, runs[name]) for o in OBSERVERS}) for name in runs}
    told = {o: {n: strokes(recording, by[o]) for n, (recording, by) in along.items()} for o in OBSERVERS}
    for observer, rows in told.items():
        print(f"{observer:20} {'  '.join(figures(rows))}", flush=True)
    if any(beside):
        print(
            f"runs beside these: {len(beside[0])} of constant tension, {len(beside[1])} with actuators"
        )
        for observer, rows in told.items():
            print(f"{observer:20} {'  '.join(figures(rows, *beside))}")
    changes = [
        np.log(now.force / before.force) / np.sqrt(now.begin - before.begin)
        for name in CONSTANT
        for before, now in zip(rows[name], rows[name][2:], strict=False)
    ]
    print(f"force from stroke to stroke the same way, constant: {np.std(changes):.3f}/sqrt(s)")
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        draw(along, options.pictures)


if __name__ == "__main__":
    main()
