"""EKF, MHE and the root solve of [Györök 2022] beside its author's estimate, on his recordings.

    python examples/author_comparison.py [DIR]

DIR holds the recordings (`brushgrip fetch`); default: see published.py. All run
causally with k as published, EKF and MHE from their default prior, mu = 1.0 +- 0.5; the declared mu only
serves to take the error. The root solve is the author's method in our hands, without his filters. His
files begin where the wheel begins to turn, so they are aligned by angle.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from brushgrip.comparison.cases import SETTLED, Case, make_case
from identification import Recording, read_recording
from identification.thesis.author_estimate import author_file
from observers import Ekf, Mhe, Observer, ZoneRootSolver, run
from published import measured_folder
from symbolic import Model

Array = NDArray[np.float64]
METHODS = ("EKF", "MHE", "root.99", "root", "author")
"""root.99 is root through the exponential filter of [Györök 2022], (5.9), with 0.99."""


@dataclass(frozen=True, kw_only=True)
class Scores:
    """One recording, a number a method in the order of `METHODS`.

    Attributes:
        name: the recording.
        declared: friction coefficient from towing a block [1].
        rmse: root mean square of mu less the declared one, from `SETTLED` on [1].
        spread: standard deviation of mu over time after the first slide [1].
        last: mu at the last sample [1].
        last_std: its standard deviation [1], NaN where the method has none.
    """

    name: str
    declared: float
    rmse: tuple[float, ...]
    spread: tuple[float, ...]
    last: tuple[float, ...]
    last_std: tuple[float, ...]


def observers(recording: Recording) -> list[Observer]:
    """Ours, on the declared model and without a label."""
    model, values = Model(), {"k": recording.tyre.k}
    return [
        Ekf(model=model, values=values, rig=recording.rig),
        Mhe(model=model, values=values, rig=recording.rig),
        ZoneRootSolver(k=recording.tyre.k, rig=recording.rig, smoothing=0.99),
        ZoneRootSolver(k=recording.tyre.k, rig=recording.rig),
    ]


def score(case: Case, author: Array) -> Scores:
    """All methods, over the author's samples."""
    recording, last = case.recording, case.span.stop - 1
    channels = (recording.t, recording.psi, recording.F_N, recording.M_z)
    results = [run(observer, *channels) for observer in observers(recording)]
    mu = [*(estimates.mu for estimates in results), author]
    return Scores(
        name=recording.name,
        declared=case.declared,
        rmse=tuple(case.rmse(one) for one in mu),
        spread=tuple(case.spread(one) for one in mu),
        last=tuple(float(one[last]) for one in mu),
        last_std=(*(float(estimates.mu_std[last]) for estimates in results), float("nan")),
    )


def scores(folder: Path) -> Iterator[Scores]:
    """Every recording that has an author's estimate beside it."""
    for path in sorted(folder.glob("*.mat")):
        if author_file(folder, path.stem).exists():
            case = make_case(read_recording(path), folder)
            if (author := case.author_mu) is not None:
                yield score(case, author)


def table(title: str, results: list[Scores], field: str) -> None:
    """Print one number a method for every recording, and the mean on either surface."""
    print(f"\n{title}\n")
    print(f"| {'recording':15} | declared μ |" + "".join(f"{name:>7} |" for name in METHODS))
    print("|---|---|" + "---:|" * len(METHODS))
    for one in results:
        cells = "".join(f"{value:7.3f} |" for value in getattr(one, field))
        print(f"| {one.name:15} | {one.declared:<10} |{cells}")
    for surface, steel in (("steel", True), ("red emery", False)):
        of_surface = [getattr(one, field) for one in results if one.name.startswith("fem") == steel]
        if of_surface:
            cells = "".join(f"{value:7.3f} |" for value in np.mean(of_surface, axis=0))
            print(f"| {f'mean, {surface}':15} | {'':10} |{cells}")


def last_table(results: list[Scores]) -> None:
    """Print mu at the last sample, with its standard deviation where there is one."""
    print("\nμ at the last sample\n")
    print(f"| {'recording':15} | declared μ |" + "".join(f" {name:13} |" for name in METHODS))
    print("|---|---|" + "---|" * len(METHODS))
    for one in results:
        texts = [
            f"{mu:.3f}" if np.isnan(std) else f"{mu:.3f} ± {std:.3f}"
            for mu, std in zip(one.last, one.last_std, strict=True)
        ]
        print(f"| {one.name:15} | {one.declared:<10} |" + "".join(f" {text:13} |" for text in texts))


def main() -> None:
    """Print the error, the spread and the last value of every method."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else measured_folder()
    results = list(scores(folder))
    if not results:
        sys.exit(
            f"no recordings with an author's estimate in {folder}; `brushgrip fetch` downloads them"
        )
    table(f"RMSE of μ against the declared one, from t = {SETTLED} s on", results, "rmse")
    table("Standard deviation of μ over time, after the first slide", results, "spread")
    last_table(results)


if __name__ == "__main__":
    main()
