"""Recordings of a friction damper with backlash, downloaded or copied; every value is checked.

Daniel Coble, ARTS-Laboratory, CC BY-SA 4.0. The published folder has one array a channel and run; they
are joined into one file a run, values unchanged. Of the six earthquakes two are fetched. Of the damper
whose band is pulled while it moves each run is a matrix of text, of which the first four columns are
taken, in SI units and single precision: of its constant tensions three, of its runs with actuators six.
"""

import hashlib
import json
import os
from collections.abc import Callable
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

import numpy as np
import pooch

from brushgrip.inputs.recording_files import LOCAL_COPY, download_folder
from brushgrip.outputs.atomic import staged_directory
from brushgrip.published.fetch import RETRIES, FetchError, download_size_limited
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

Say = Callable[[str], None]
Download = Callable[[str, str], dict[str, Array]]
ATTRIBUTION = (
    "Friction damper: Daniel Coble, ARTS-Laboratory, 2024, CC BY-SA 4.0"
    " (https://creativecommons.org/licenses/by-sa/4.0/), https://github.com/ARTS-Laboratory/"
    "Paper-Physics-Informed-Machine-Learning-for-Dry-Friction-and-Backlash; values unchanged,"
    " files joined"
)
HARMONIC = tuple(f"harmonic_{run:02d}" for run in range(13))
EARTHQUAKES = ("earthquake_DuzceMCE", "earthquake_KocaeliDBE")
CHANNELS = ("t", "F", "x", "v")
"""Time [s], damping force [N], displacement [m], velocity [m/s]."""
REGISTRY = files("brushgrip.published").joinpath("friction_damper.txt")
"""Address of the published folder, then name and digest of the values of each run."""

_BESIDE = "second_rig"
_RATE = 1024.0


def damper_folder() -> Path:
    """Where `fetch_friction_damper` puts the runs unless told otherwise."""
    return download_folder() / "friction_damper"


def address_and_digests(registry: Traversable) -> tuple[str, dict[str, str]]:
    """Address of the published folder, and the SHA-256 of each run's values by name."""
    lines = registry.read_text(encoding="utf-8").splitlines()
    address, *rows = (line for line in lines if line and not line.startswith("#"))
    return address, dict(row.split() for row in rows)


def fetch_friction_damper(destination: str | Path, *, say: Say = lambda _: None) -> list[Path]:
    """Puts the runs into a folder, one file each: all of them, or none at all.

    Where ``BRUSHGRIP_DATA`` names a folder, they are copied from there, or from `second_rig` beside it,
    and nothing is downloaded. Runs already in the destination are kept if their values are right; other
    values than the published ones are a fault.
    """
    say(ATTRIBUTION)
    return fetch_runs(destination, address_and_digests(REGISTRY), _download_damper_run, _BESIDE, say)


def fetch_runs(
    destination: str | Path,
    registry: tuple[str, dict[str, str]],
    download: Download,
    local_sibling: str,
    say: Say,
) -> list[Path]:
    """What `fetch_friction_damper` does, with runs of any `registry`; see `address_and_digests`.

    `download` gives the channels of a run by address and name; `local_sibling` is a folder beside that
    of a local copy, where the runs may be.
    """
    destination, local = Path(destination), os.environ.get(LOCAL_COPY)
    address, published = registry
    with staged_directory(destination) as stage:
        for number, (name, digest) in enumerate(published.items(), start=1):
            there = destination / f"{name}.npz"
            if there.is_file() and channels_digest(_load_channels(there)) == digest:
                continue
            say(f"{number}/{len(published)} {name}")
            channels = (
                _load_local_copy(Path(local), name, local_sibling) if local else download(address, name)
            )
            if channels_digest(channels) != digest:
                kind, place = (InvalidInputError, local) if local else (FetchError, address)
                raise kind(f"{name}: the values from {place} are not the published ones; nothing kept")
            arrays: dict[str, Any] = dict(channels)
            np.savez_compressed(stage / f"{name}.npz", **arrays)
    return [destination / f"{name}.npz" for name in published]


def channels_digest(channels: dict[str, Array]) -> str:
    """SHA-256 of the values, little-endian doubles, channel after channel as in `CHANNELS`."""
    content = b"".join(np.asarray(channels[name], dtype="<f8").tobytes() for name in CHANNELS)
    return hashlib.sha256(content).hexdigest()


def _load_channels(path: Path) -> dict[str, Array]:
    try:
        # Opened here: numpy leaves open what it cannot read.
        with path.open("rb") as file, np.load(file) as arrays:
            return {name: np.asarray(arrays[name], dtype=float) for name in CHANNELS}
    except Exception as error:  # a damaged archive may raise anything
        raise InvalidInputError(f"{path}: is no run of the friction damper ({error})") from None


def _load_local_copy(local: Path, name: str, local_sibling: str) -> dict[str, Array]:
    places = [folder / f"{name}.npz" for folder in (local, local.resolve().parent / local_sibling)]
    for path in places:
        if path.is_file():
            return _load_channels(path)
    raise InvalidInputError(
        f"{LOCAL_COPY}={local}: holds no {name}.npz, nor does {places[1].parent}; unset it to download"
    )


def _download_damper_run(address: str, name: str) -> dict[str, Array]:
    """The channels of a run: of an earthquake columns of one array, of a harmonic run one array each."""
    kind, run = name.split("_")
    if kind == "earthquake":
        table = download_array(f"{address}/validation/{run}.npy", len(CHANNELS))
        return dict(zip(CHANNELS, table.T, strict=True))
    channels = {c: download_array(f"{address}/{c}/test{int(run)}.npy", 1).ravel() for c in CHANNELS[1:]}
    return {"t": np.arange(channels["F"].size) / _RATE} | channels


def download_array(url: str, column_count: int, loader: Callable[[str], Any] = np.load) -> Array:
    """A published array with a given number of columns."""
    pooch.get_logger().setLevel("ERROR")
    try:
        with TemporaryDirectory() as folder:
            # No digest of the file: the pin is that of the values, which the caller checks.
            path = pooch.create(
                path=folder,
                base_url="",
                registry={"part.npy": None},
                urls={"part.npy": quote(url, safe=":/")},
                retry_if_failed=RETRIES,
            ).fetch("part.npy", downloader=download_size_limited)
            array = np.asarray(loader(path), dtype=float)
            return array.reshape(-1, column_count)
    except Exception as error:  # neither a host nor a damaged array keeps to some kinds of error
        raise FetchError(
            f"{url}: cannot be downloaded ({type(error).__name__}); try again, or set {LOCAL_COPY} to a"
            " folder that holds the runs"
        ) from None


PULLED_ATTRIBUTION = (
    "Friction damper, band pulled: Daniel Coble, ARTS-Laboratory, CC BY-SA 4.0"
    " (https://creativecommons.org/licenses/by-sa/4.0/), https://github.com/ARTS-Laboratory/"
    "Dataset-Friction-Damper-with-Backlash; converted to SI units"
)
CONSTANT = tuple(f"tension_{force}lb_{rate}Hz" for force in (20, 25, 70) for rate in ("0.5", "1"))
CHANGED = (
    *("harmonic0.015forward", "harmonic0.03ea1backward", "harmonic0.03ea2forward"),
    *("step0.015backward", "step0.03ea1forward", "step0.03ea2backward"),
)
PULLED_REGISTRY = files("brushgrip.published").joinpath("changed_friction.txt")
INCH, KIP = 0.0254, 4448.2216152605
"""[m], [N]."""


def changed_friction_folder() -> Path:
    """Where `fetch_changed_friction` puts the runs unless told otherwise."""
    return download_folder() / "changed_friction"


def fetch_changed_friction(destination: str | Path, *, say: Say = lambda _: None) -> list[Path]:
    """As `fetch_friction_damper`, with `third_check` beside a local copy."""
    say(PULLED_ATTRIBUTION)
    return fetch_runs(
        destination, address_and_digests(PULLED_REGISTRY), _download_changed_run, "third_check", say
    )


def _download_changed_run(address: str, name: str) -> dict[str, Array]:
    place, columns = f"dataset-4/{name}", 8
    if name in CONSTANT:
        _, tension, rate = name.split("_")
        place, columns = f"dataset-1/characterization datasets/{rate}{tension}tension", 6
    table = download_array(f"{address}/data/{place}.json", columns, _load_json_data)[:, :4]
    values = (table * (1, INCH, KIP, INCH)).astype(np.float32).astype(float)
    return dict(zip(("t", "x", "F", "v"), values.T, strict=True))


def _load_json_data(path: str) -> Any:
    return json.loads(Path(path).read_text(encoding="utf-8"))["data"]
