"""Where the published recordings and simulations lie, for the other examples.

    python examples/published.py

prints both: the folder named by BRUSHGRIP_DATA, else ../shared/measured where there is one, else where
`brushgrip fetch` puts them. The simulations stand beside the recordings, or among them.
"""

import os
from pathlib import Path

from brushgrip.fetch import LOCAL_COPY
from brushgrip.recordings import download_folder

BESIDE = Path("../shared/measured")


def measured_folder() -> Path:
    """Where the recordings are looked for."""
    if named := os.environ.get(LOCAL_COPY):
        return Path(named)
    return BESIDE if BESIDE.is_dir() else download_folder()


def simulation_folder() -> Path:
    """Where the simulations are looked for."""
    beside = measured_folder().parent / "thesis_simulation"
    return beside if beside.is_dir() else measured_folder()


def main() -> None:
    """Print where they are looked for."""
    print(f"recordings: {measured_folder()}\nsimulations: {simulation_folder()}")


if __name__ == "__main__":
    main()
