"""Where the published recordings and simulations lie, for the other examples.

    python examples/published.py

prints both: the folder named by BRUSHGRIP_DATA, else ../shared/measured where there is one, else where
`brushgrip fetch` puts them. The simulations stand beside the recordings, or among them.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from brushgrip.inputs.recording_files import LOCAL_COPY, download_folder
from identification import Recording, read_recording

GROUNDS = {"fem": "steel", "piros": "emery"}
"""What the recordings stand on, by the beginning of their names."""
BESIDE = Path("../shared/measured")


def measured_folder() -> Path:
    """Where the recordings are looked for."""
    if named := os.environ.get(LOCAL_COPY):
        return Path(named)
    return BESIDE if BESIDE.is_dir() else download_folder()


def measured_recordings(folder: Path) -> list[Recording]:
    """The recordings of a folder, each on its ground."""
    recordings = [read_recording(path) for path in sorted(folder.glob("*.mat"))]
    return [replace(r, ground=ground_named(r.name)) for r in recordings]


def ground_named(name: str) -> str | None:
    """The ground of a published recording of this name; None for another one."""
    return next((g for beginning, g in GROUNDS.items() if name.startswith(beginning)), None)


def simulation_folder() -> Path:
    """Where the simulations are looked for."""
    beside = measured_folder().parent / "thesis_simulation"
    return beside if beside.is_dir() else measured_folder()


def published_simulation(folder: Path, mu: float) -> dict[str, NDArray[np.float64]] | None:
    """Columns of a published simulation: t [s], psi [rad], F_N [N], the late M_z [N m], the author's mu.

    None where the folder lacks it.
    """
    file = folder / f"sim_mu_{10 * mu:02.0f}.csv"
    if not file.exists():
        return None
    columns = np.genfromtxt(file, delimiter=",", skip_header=1).T
    t, psi, torque, F_N, estimate = columns[[0, 1, 3, 5, 8]]
    return {"t": t, "psi": psi, "M_z": -torque, "F_N": F_N, "mu": estimate}


def main() -> None:
    """Print where they are looked for."""
    print(f"recordings: {measured_folder()}\nsimulations: {simulation_folder()}")


if __name__ == "__main__":
    main()
