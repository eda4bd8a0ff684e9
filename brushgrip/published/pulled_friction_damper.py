"""Recordings of a friction damper whose band is pulled while it moves; every value is checked.

Daniel Coble, ARTS-Laboratory, CC BY-SA 4.0. Each run is a matrix of text; its first four columns are
taken, in SI units and single precision. Of the constant tensions three are fetched, of the runs with
actuators six.
"""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brushgrip.inputs.recordings import download_folder
from brushgrip.published.friction_damper import Say, digests, fetch_runs, fetched_array

ATTRIBUTION = (
    "Friction damper, band pulled: Daniel Coble, ARTS-Laboratory, CC BY-SA 4.0"
    " (https://creativecommons.org/licenses/by-sa/4.0/), https://github.com/ARTS-Laboratory/"
    "Dataset-Friction-Damper-with-Backlash; converted to SI units"
)
CONSTANT = tuple(f"tension_{force}lb_{rate}Hz" for force in (20, 25, 70) for rate in ("0.5", "1"))
CHANGED = (
    *("harmonic0.015forward", "harmonic0.03ea1backward", "harmonic0.03ea2forward"),
    *("step0.015backward", "step0.03ea1forward", "step0.03ea2backward"),
)
REGISTRY = files("brushgrip.published").joinpath("changed_friction.txt")
INCH, KIP = 0.0254, 4448.2216152605
"""[m], [N]."""


def changed_friction_folder() -> Path:
    """Where `fetch_changed_friction` puts the runs unless told otherwise."""
    return download_folder() / "changed_friction"


def fetch_changed_friction(destination: str | Path, *, say: Say = lambda _: None) -> list[Path]:
    """As `fetch_friction_damper`, with `third_check` beside a local copy."""
    say(ATTRIBUTION)
    return fetch_runs(destination, digests(REGISTRY), _downloaded, "third_check", say)


def _downloaded(address: str, name: str) -> dict[str, NDArray[np.float64]]:
    place, columns = f"dataset-4/{name}", 8
    if name in CONSTANT:
        _, tension, rate = name.split("_")
        place, columns = f"dataset-1/characterization datasets/{rate}{tension}tension", 6
    table = fetched_array(f"{address}/data/{place}.json", columns, _matrix)[:, :4]
    values = (table * (1, INCH, KIP, INCH)).astype(np.float32).astype(float)
    return dict(zip(("t", "x", "F", "v"), values.T, strict=True))


def _matrix(path: str) -> Any:
    return json.loads(Path(path).read_text(encoding="utf-8"))["data"]
