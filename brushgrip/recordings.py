"""Recordings as a user names them: their files, their reading, and a unique name for each."""

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from brushgrip.atomic import file_keys
from brushgrip.fetch import LOCAL_COPY
from identification import (
    READERS,
    Decay,
    Recording,
    SignalMap,
    parse_signals,
    read_decay,
    read_recording,
    read_rig,
    read_signals,
)
from identification.reading.readers import files_beside
from identification.reading.table import MIN_SAMPLES
from symbolic import InvalidInputError
from symbolic.errors import printable

ADDED_SUFFIXES = (".mat", ".csv", ".txt")
"""Suffixes that the name of a recording may lack."""
_SHARED = 0.5
"""Recordings that share more of their samples are one, cut, thinned or shifted in time."""


def download_folder() -> Path:
    """Where `fetch` puts the published files unless told otherwise: the user's data folder."""
    base = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(base) / "brushgrip"


def locate(name: str) -> Path:
    """The file of a recording: as given, with .mat or .csv, and for a bare name where data is kept.

    Raises:
        InvalidInputError: there is none; the message says where it was looked for.
    """
    try:
        given = Path(name).expanduser()
    except RuntimeError as error:
        raise InvalidInputError(f"{name}: {error}") from None
    folders = [Path()]
    if given.name == name:
        local = os.environ.get(LOCAL_COPY)
        folders += [Path(local)] if local else []
        folders.append(download_folder())
    for folder in folders:
        for path in (folder / given, *(folder / f"{given}{suffix}" for suffix in ADDED_SUFFIXES)):
            if _is_there(path) and not path.is_dir():
                return path
    if given.is_dir():
        raise InvalidInputError(f"{name}: is a folder, expected a recording ({', '.join(READERS)})")
    places = ", ".join(str(folder) if folder != Path() else "here" for folder in folders)
    *others, last = (f"{given.name}{suffix}" for suffix in ("", *ADDED_SUFFIXES))
    raise InvalidInputError(
        f"{name}: no such recording; looked for {', '.join(others)} and {last}"
        f" in {places if given.name == name else given.parent}"
        + ("" if len(folders) == 1 else "; 'brushgrip fetch' downloads the published ones")
    )


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror or error}") from None


def read_all(
    names: Sequence[str],
    rig: Path | None,
    *,
    torque_required: bool = True,
    causal: bool = False,
    given_map: str | None = None,
) -> list[Recording]:
    """The recordings of these names, in order, each under a name of its own.

    Args:
        names: as the user gave them.
        rig: a rig file; None where the recordings know their rig.
        torque_required: whether a recording without M_z is a fault.
        causal: fill gaps from the past alone.
        given_map: what `--map` says; goes before the rig file's [signals].

    Raises:
        InvalidInputError: a file is missing or bad, or one recording is given twice.
    """
    nominal = None if rig is None else read_rig(rig)
    signals = signal_map(rig, given_map)
    paths = [locate(name) for name in names]
    recordings = [
        read_recording(path, nominal, torque_required=torque_required, causal=causal, signals=signals)
        for path in paths
    ]
    for (one, first), (other, second) in combinations(zip(paths, recordings, strict=True), 2):
        if one.samefile(other) or (torque_required and _same_samples(first, second)):
            raise _twice(one, other, ", either for training or held out")
    labels = _unique_labels(paths)
    return [replace(r, name=label) for r, label in zip(recordings, labels, strict=True)]


def signal_map(rig: Path | None, given_map: str | None) -> SignalMap:
    """Where columns come from: [signals] of the rig file, and before it what `--map` says."""
    of_rig = SignalMap() if rig is None else read_signals(rig)
    return of_rig if given_map is None else of_rig.updated(parse_signals(given_map))


def files_read(names: Sequence[str], signals: SignalMap, effects: Sequence[Path] = ()) -> list[Path]:
    """Every file that a command reads for its recordings, each once.

    Args:
        names: recordings as the user gave them.
        signals: map of channels; its database counts, or that which is found beside a log.
        effects: sources of a user's effects.
    """
    paths = [locate(name) for name in names]
    return list(dict.fromkeys([*paths, *effects, *files_beside(paths, signals)]))


def labelled(names: Sequence[str]) -> dict[str, Path]:
    """The files of these names, in order, by a label of their own; their content is not read.

    Raises:
        InvalidInputError: there is no such file, or one is given twice.
    """
    paths = [locate(name) for name in names]
    first: dict[Path, Path] = {}
    for path in paths:
        if first.setdefault(path.resolve(), path) is not path:
            raise _twice(path, first[path.resolve()])
    return dict(zip(_unique_labels(paths), paths, strict=True))


def read_decays(names: Sequence[str], rig: Path | None, given_map: str | None = None) -> list[Decay]:
    """The free vibrations of these names, in order, each under a name of its own.

    Args:
        names: as the user gave them.
        rig: a rig file; None where the recordings know their rig.
        given_map: what `--map` says; goes before the rig file's [signals].

    Raises:
        InvalidInputError: a file is missing or bad, or one recording is given twice.
    """
    nominal = None if rig is None else read_rig(rig)
    signals = signal_map(rig, given_map)
    paths = [locate(name) for name in names]
    decays = [read_decay(path, nominal, signals=signals) for path in paths]
    for (one, first), (other, second) in combinations(zip(paths, decays, strict=True), 2):
        if one.samefile(other) or np.array_equal(first.psi, second.psi):
            raise _twice(one, other)
    labels = _unique_labels(paths)
    return [replace(decay, name=label) for decay, label in zip(decays, labels, strict=True)]


def keep_inputs(outputs: Sequence[Path], inputs: Sequence[Path], *others: Path | None) -> None:
    """Refuses to write over what was read.

    Args:
        outputs: the files to write.
        inputs: recordings and what is read along with them, see `files_read`.
        others: rig, model and whatever else is read; None for what was not given.

    Raises:
        InvalidInputError: an output is one of the inputs, whatever way its path is spelt.
    """
    paths = [*inputs, *(path for path in others if path is not None)]
    read = {key for path in paths for key in file_keys(path)}
    for output in outputs:
        if not read.isdisjoint(file_keys(output)):
            raise InvalidInputError(f"{output}: would overwrite what is read; name another --out")


def _twice(one: Path, other: Path, where: str = "") -> InvalidInputError:
    return InvalidInputError(f"{other}: is the same recording as {one}; each is allowed once{where}")


def _same_samples(one: Recording, other: Recording) -> bool:
    """Whether they are alike, or most pairs of angle and torque in the shorter occur in the longer."""
    if np.array_equal(one.psi, other.psi) and np.array_equal(one.M_z, other.M_z, equal_nan=True):
        return True
    first, second = (np.unique((r.psi + 1j * r.M_z)[np.isfinite(r.M_z)]) for r in (one, other))
    common = int(np.intersect1d(first, second, assume_unique=True).size)
    return common >= MIN_SAMPLES and common > _SHARED * min(first.size, second.size)


def _unique_labels(paths: Sequence[Path]) -> list[str]:
    """File names without suffix; folders go before, and the suffix behind, where that is needed.

    What no screen can show stands as its escape sequence: labels go into tables, pictures and files.
    """
    parts = [list(map(printable, (*path.absolute().parent.parts[1:], path.stem))) for path in paths]
    depths = [1] * len(paths)
    while True:
        labels = ["_".join(p[-depth:]) for p, depth in zip(parts, depths, strict=True)]
        twice = {label for label, count in Counter(labels).items() if count > 1}
        deeper = [
            min(depth + (label in twice), len(p))
            for p, depth, label in zip(parts, depths, labels, strict=True)
        ]
        if deeper == depths:
            break
        depths = deeper
    if not twice:
        return labels
    return [
        printable(path.name).replace(".", "_") if label in twice else label
        for path, label in zip(paths, labels, strict=True)
    ]
