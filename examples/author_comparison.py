"""The EKF and the MHE beside the author's published estimate, per sample, on the published recordings.

    python examples/author_comparison.py [DIR]

DIR holds the recordings (`brushgrip fetch`); default: BRUSHGRIP_DATA, else ../shared/measured. Both
observers run causally from their default prior, mu = 1.0 +- 0.5, with k as published; the declared mu
only serves to take the error. The author's files begin where the wheel begins to turn, so both are
aligned by angle.
"""

import os
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification import Recording, read_recording
from observers import Ekf, Estimates, Mhe, run
from symbolic import Model

SETTLED = 1.89
"""From here on the source's Table 6.1 counts, in the author's time [s]."""
TIME, PSI, MU, DECLARED = 0, 1, 10, 11
"""Columns of the author's files."""


def estimate(kind: type[Ekf] | type[Mhe], recording: Recording) -> Estimates:
    """An observer over a recording, declared model, no label."""
    observer = kind(model=Model(), values={"k": recording.tyre.k}, rig=recording.rig)
    return run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)


def aligned(psi: NDArray[np.float64], part: NDArray[np.float64]) -> int:
    """Where the author's samples begin in the recording."""
    starts = range(psi.size - part.size + 1)
    return min(starts, key=lambda at: float(np.abs(psi[at : at + part.size] - part).max()))


def main() -> None:
    """Print one row a recording."""
    default = os.environ.get("BRUSHGRIP_DATA", "../shared/measured")
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else default)
    print("| recording | declared μ | EKF RMSE | MHE RMSE | author RMSE | EKF, end | spread, informed |")
    print("|---|---|---|---|---|---|---|")
    errors: dict[str, list[list[float]]] = {}
    for path in sorted(folder.glob("*.mat")):
        published = folder / f"author_estimate_{path.stem.removesuffix('_ident')}.csv"
        if not published.exists():
            continue
        recording = read_recording(path)
        author = np.genfromtxt(published, delimiter=",", skip_header=1)
        found, windowed = estimate(Ekf, recording), estimate(Mhe, recording)
        first = aligned(recording.psi, author[:, PSI])
        same = slice(first, first + len(author))
        settled = author[:, TIME] >= SETTLED
        declared = author[0, DECLARED]
        ekf, mhe, theirs = (
            float(np.sqrt(np.mean((mu[settled] - declared) ** 2)))
            for mu in (found.mu[same], windowed.mu[same], author[:, MU])
        )
        spread = float(found.mu[found.informed].std())
        print(
            f"| {path.stem} | {declared} | {ekf:.3f} | {mhe:.3f} | {theirs:.3f}"
            f" | {found.mu[-1]:.3f} ± {found.mu_std[-1]:.3f} | {spread:.3f} |"
        )
        errors.setdefault("steel" if path.stem.startswith("fem") else "red emery", []).append([ekf, mhe])
    if not errors:
        sys.exit(
            f"no recordings with an author's estimate in {folder}; `brushgrip fetch` downloads them"
        )
    for surface, values in errors.items():
        ekf, mhe = np.mean(values, axis=0)
        print(f"\nmean RMSE on {surface}: EKF {ekf:.3f}, MHE {mhe:.3f}")


if __name__ == "__main__":
    main()
