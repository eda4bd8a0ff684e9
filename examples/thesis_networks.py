"""The learned methods of [Györök 2022], sections 4.1 and 4.2, beside a guess, root solve and EKF.

    python examples/thesis_networks.py [--data DIR] [--full] [--epochs N] [--seeds N] [PICTURE.png]

Same inputs and split as the thesis: trained on mu = 0.5 and 1.8, tested on mu = 1, on the profile of the
training and on one with more than five zones; and on recordings, trained on red emery, tested on steel,
where DIR holds them (`brushgrip fetch`; default: see published.py). --full takes
the thesis's layers, which train for minutes. A guess that measures nothing, the mean of the training
labels, is what a method has to beat. Needs scikit-learn: pip install 'brushgrip[networks]'.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from brushgrip.comparison.methods import train_neural_network, train_root_correction_network
from brushgrip.pictures.style import MEASURED, QUIET, TRACKS, figure_saved_as_png, legend_above
from identification import Recording, read_recording
from identification.thesis.friction_neural_network import (
    FrictionNetwork,
    LabelMean,
    NetworkDesign,
    label_mean,
)
from observers import Ekf, RootObserver
from published import measured_folder
from symbolic import Model
from thesis_analytic import late
from thesis_profile import NESTED, SETTLED, rmse, steered
from thesis_table import estimated, ours, root

PLAIN_LAYERS, CORRECTING_LAYERS = (1024, 512), (2048, 1024)
"""Neurons of the thesis's networks, alone and on top of the analytic estimate."""
SETTLED_MEASURED = 4.0
"""From here on errors count on measured recordings [s]."""
LINES = {
    "neural network": (TRACKS[3], "-"),
    "root": (TRACKS[0], "-"),
    "root and network": (TRACKS[1], "--"),
    "EKF": (TRACKS[2], "--"),
}
"""Methods of the picture, with colour and style."""
DECLARED = {"piros": 1.9003, "fem": 1.674}
"""Friction of red emery and steel by the thesis's table 5.1, by the beginning of a recording's name."""
Learner = FrictionNetwork | LabelMean
Others = Callable[[Recording], dict[str, np.ndarray]]


def learners(training: Sequence[Recording], design: NetworkDesign, full: bool) -> list[Learner]:
    """The guess and the two networks, trained; `full` takes the thesis's layers."""
    plain = replace(design, hidden=PLAIN_LAYERS) if full else design
    correcting = replace(design, hidden=CORRECTING_LAYERS) if full else design
    return [
        label_mean(training),
        train_neural_network(training, plain),
        train_root_correction_network(training, correcting),
    ]


def simulation_methods(recording: Recording, *, delayed: bool) -> dict[str, np.ndarray]:
    """The methods that learn nothing, on a simulation; the EKF has a late torque declared."""
    methods = {"root": root(), "EKF": ours(Ekf, delayed=delayed)}
    return {name: estimated(observer, recording) for name, observer in methods.items()}


def measured_methods(recording: Recording) -> dict[str, np.ndarray]:
    """The methods that learn nothing, on a recording: declared model, default tuning."""
    k, rig = recording.tyre.k, recording.rig
    methods = {"root": RootObserver(rig=rig, k=k), "EKF": Ekf(model=Model(), values={"k": k}, rig=rig)}
    return {name: estimated(observer, recording) for name, observer in methods.items()}


def labelled(path: Path, mu: float) -> Recording:
    """A recording with the mu that the thesis declares for its plate."""
    recording = read_recording(path)
    return replace(recording, tyre=replace(recording.tyre, mu=mu))


def table(
    title: str, tests: Sequence[Recording], taught: list[list[Learner]], others: Others, settled: float
) -> list[dict[str, np.ndarray]]:
    """Print the RMSE of every method on every test, over seeds; returns the tracks of the first seed."""
    print(f"\n{title}: RMSE from {settled} s on, {len(taught)} seeds\n")
    print("| method | " + " | ".join(one.name for one in tests) + " |\n|---|" + "---|" * len(tests))
    tracks = []
    for test in tests:
        learnt = [{method.name: method.estimate_mu_eff(test) for method in seed} for seed in taught]
        tracks.append([one | others(test) for one in learnt])
    for name in tracks[0][0]:
        cells = []
        for test, seeds in zip(tests, tracks, strict=True):
            errors = sorted({f"{rmse(test, seed[name], settled):.4f}" for seed in seeds})
            cells.append(errors[0] if len(errors) == 1 else f"{errors[0]} to {errors[-1]}")
        print(f"| {name} | " + " | ".join(cells) + " |")
    return [seeds[0] for seeds in tracks]


def simulated(designs: Sequence[NetworkDesign], full: bool, path: Path | None) -> None:
    """Figures 4.8 to 4.10, with the torque in time and, as the thesis has it, one sample late."""
    doubled = np.abs(steered(1.0).psi - 2 * steered(0.5).psi).max()
    print(f"mu = 1 is mu = 0.5 doubled: angles within {doubled:.0e} rad")
    for channel, delayed in ((lambda recording: recording, False), (late, True)):
        training = [channel(steered(mu)) for mu in (0.5, 1.8)]
        tests = [channel(steered(1.0)), channel(steered(1.0, NESTED))]
        taught = [learners(training, design, full) for design in designs]
        title = f"simulated, torque {'late' if delayed else 'in time'}, trained on mu = 0.5 and 1.8"
        others = partial(simulation_methods, delayed=delayed)
        tracks = table(title, tests, taught, others, SETTLED)
        if path is not None and not delayed:
            draw(path, tests, tracks)


def measured(folder: Path, designs: Sequence[NetworkDesign], full: bool) -> None:
    """The thesis's split of its recordings, without the black emery, which is not published here."""
    emery, steel = (
        [labelled(path, mu) for path in sorted(folder.glob(f"{kind}*.mat"))]
        for kind, mu in DECLARED.items()
    )
    if not (emery and steel):
        print(f"\nno recordings of both surfaces in {folder}; `brushgrip fetch` downloads them")
        return
    for title, training, tests in (
        ("trained on red emery, one label", emery, steel),
        ("trained on half of either surface", [*emery[::2], *steel[::2]], [*emery[1::2], *steel[1::2]]),
    ):
        taught = [learners(training, design, full) for design in designs]
        table(title, tests, taught, measured_methods, SETTLED_MEASURED)


def draw(path: Path, tests: Sequence[Recording], tracks: Sequence[dict[str, np.ndarray]]) -> None:
    """Friction by every method on both profiles."""
    with figure_saved_as_png(path, 3.8) as figure:
        for axes, test, track in zip(figure.subplots(1, 2, sharey=True), tests, tracks, strict=True):
            lines = [axes.axhline(1.0, color=MEASURED, lw=0.8, ls="--", label="true")]
            for name, (colour, style) in LINES.items():
                lines += axes.plot(test.t, track[name], style, color=colour, label=name)
            band = axes.axhspan(0.9, 1.1, color=QUIET, alpha=0.3, lw=0, label="within 10 %")
            axes.set(title=f"tested on {test.name}", xlabel="time [s]", ylim=(0, 2.5))
        figure.axes[0].set_ylabel("friction coefficient μ [1]")
        legend_above(figure, [*lines, band])


def main() -> None:
    """Print the tables, and draw the simulated one if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--data", type=Path, default=measured_folder())
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--epochs", type=int, default=NetworkDesign().epochs)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("picture", type=Path, nargs="?")
    options = parser.parse_args()
    designs = [NetworkDesign(seed=seed, epochs=options.epochs) for seed in range(options.seeds)]
    simulated(designs, options.full, options.picture)
    measured(options.data, designs, options.full)


if __name__ == "__main__":
    main()
