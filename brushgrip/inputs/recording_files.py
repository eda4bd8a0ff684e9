"""Recordings as a user names them: their files, a label for each, and which are one and the same."""

import math
import os
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from brushgrip.outputs.atomic import file_identity_keys
from identification import READERS, Recording
from identification.fits.autocorrelation import autoregression
from identification.reading.checked_file_reading import convert_read_errors
from identification.reading.checked_sample_table import MIN_SAMPLES
from symbolic import InvalidInputError
from symbolic.errors import printable

LOCAL_COPY = "BRUSHGRIP_DATA"
"""Environment variable that names a folder with the published files."""
ADDED_SUFFIXES = (".mat", ".csv", ".txt")
"""Suffixes that the name of a recording may lack."""
CAR_LOGS = (".blf", ".asc", ".mf4")
"""Suffixes of logs of a car."""
OF_CAR = "; 'python examples/car_log.py logs' writes logs of a car to try"
PUBLISHED = "; 'brushgrip fetch' downloads the published ones"
"""Where recordings come from that are not there."""
_COPIED_NOISE = 0.8
"""Difference of two torques over the noise of the noisier one, below which one is a copy [1]: that of
two runs is at least 1, mostly 1.4, and 0.6 where one was resampled in between the samples."""
_MIN_SAMPLES_OF_NOISE, _MAX_SAMPLES_OF_NOISE = 100, 100_000
"""Fewest samples in common that tell so, and most of which the noise is taken."""
_LONGEST_PAUSE = 10
"""Duration over that of the samples beyond which a recording is mostly pause [1]."""
_SAME_PATH = 0.02
"""Difference of two angles over their deviation, below which the path is the same [1]."""
_ORDER = 6
"""Order of the differences from which the noise is taken."""
_SHARED = 0.5
"""Recordings that share more of their samples are one, cut, thinned or shifted in time."""


def download_folder() -> Path:
    """Where `fetch` puts the published files unless told otherwise: the user's data folder."""
    base = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(base) / "brushgrip"


def locate_recording(name: str, *, of_car: bool = False) -> Path:
    """The file of a recording: as given, with .mat or .csv, and for a bare name where data is kept."""
    try:
        given = Path(name).expanduser()
    except RuntimeError as error:
        raise InvalidInputError(f"{name}: {error}") from None
    folders = [Path()]
    if given.name == name:
        local = os.environ.get(LOCAL_COPY)
        folders += [Path(local)] if local else []
        folders += [] if of_car else [download_folder()]  # Of a car nothing is published.
    for folder in folders:
        for path in (folder / given, *(folder / f"{given}{suffix}" for suffix in ADDED_SUFFIXES)):
            with convert_read_errors(path):
                if path.exists() and not path.is_dir():
                    return path
    if given.is_dir():
        raise InvalidInputError(f"{name}: is a folder, expected a recording ({', '.join(READERS)})")
    places = ", ".join(str(folder) if folder != Path() else "here" for folder in folders)
    *others, last = (f"{given.name}{suffix}" for suffix in ("", *ADDED_SUFFIXES))
    raise InvalidInputError(
        f"{name}: no such recording; looked for {', '.join(others)} and {last}"
        f" in {places if given.name == name else given.parent}"
        + (OF_CAR if of_car or given.suffix.lower() in CAR_LOGS else PUBLISHED * (len(folders) > 1))
    )


def refuse_overwriting(outputs: Sequence[Path], inputs: Sequence[Path]) -> None:
    """Refuses to write over what was read, whatever way its path is spelt."""
    read = {key for path in inputs for key in file_identity_keys(path)}
    for output in outputs:
        if not read.isdisjoint(file_identity_keys(output)):
            raise InvalidInputError(f"{output}: would overwrite what is read; name another --out")


def shares_samples(one: Recording, other: Recording) -> bool:
    """Whether they are alike, or most of the shorter occurs in the longer, rounded or resampled too."""
    if np.array_equal(one.psi, other.psi) and np.array_equal(one.M_z, other.M_z, equal_nan=True):
        return True
    first, second = (np.unique((r.psi + 1j * r.M_z)[np.isfinite(r.M_z)]) for r in (one, other))
    common = int(np.intersect1d(first, second, assume_unique=True).size)
    if common >= MIN_SAMPLES and common > _SHARED * min(first.size, second.size):
        return True
    return _has_same_torque_noise(one, other)


def _has_same_torque_noise(one: Recording, other: Recording) -> bool:
    """Whether their torques agree better than those of two runs, each with its own noise, can."""
    period = max(float(np.median(np.diff(r.t))) for r in (one, other))
    for r in (one, other):  # Few samples tell nothing; across a long pause there is no common grid.
        if not _MIN_SAMPLES_OF_NOISE <= float(np.ptp(r.t)) / period < _LONGEST_PAUSE * r.t.size:
            return False
    # On the samples of the noisier one: what is interpolated loses noise.
    pairs = ((one, _torque_noise_std(one)), (other, _torque_noise_std(other)))
    (quiet, _), (noisy, noise) = sorted(pairs, key=lambda pair: pair[1])
    shift = _time_shift_by_noise(noisy, quiet, period)
    for step in (period / 8, period / 64):
        shifts = shift + step * np.arange(-8, 9)
        errors = [_torque_rms_difference(noisy, quiet, by) for by in shifts]
        shift = float(shifts[np.argmin(errors)])
    return min(errors) < _COPIED_NOISE * noise


def _torque_known_mask(recording: Recording) -> NDArray[np.bool_]:
    return np.isfinite(recording.M_z)


@lru_cache(maxsize=16)  # Each recording stands beside each other one.
def _torque_noise_std(recording: Recording) -> float:
    """White noise of the torque [N m]: what neither its course nor a hum explains."""
    torque = recording.M_z[_torque_known_mask(recording)][:_MAX_SAMPLES_OF_NOISE]
    centred = torque - torque.mean()
    weights = autoregression(centred)
    rough = np.diff(torque, _ORDER) / math.sqrt(math.comb(2 * _ORDER, _ORDER))
    innovations = np.convolve(centred, weights, "valid")
    return min(float(np.median(np.abs(values))) / 0.6745 for values in (rough, innovations))


def _time_shift_by_noise(one: Recording, other: Recording, period: float) -> float:
    """Time of `other` less that of `one` at which the noise of their torques agrees [s]."""
    rough = []
    for r in (one, other):
        known, grid = _torque_known_mask(r), np.arange(r.t[0], r.t[-1], period)
        rough.append(np.diff(np.interp(grid, r.t[known], r.M_z[known]), 2))
    # By NumPy: what it takes to load `scipy.signal` every command would wait for.
    size = 1 << sum(values.size for values in rough).bit_length()
    first, second = (np.fft.rfft(values, size) for values in rough)
    lag = int(np.argmax(np.fft.irfft(first.conj() * second, size)))
    lag -= size * (lag >= rough[1].size)
    return float(other.t[0] - one.t[0] + lag * period)


def _torque_rms_difference(one: Recording, other: Recording, shift: float) -> float:
    """Root mean square difference of their torques [N m]; infinite where angles or spans differ."""
    known, t = _torque_known_mask(other), one.t + shift
    both = _torque_known_mask(one) & (t >= other.t[known][0]) & (t <= other.t[known][-1])
    spans = (float(np.ptp(r.t)) for r in (one, other))
    if both.sum() < _MIN_SAMPLES_OF_NOISE or float(np.ptp(t[both])) < _SHARED * min(spans):
        return math.inf
    angle = one.psi[both] - np.interp(t[both], other.t, other.psi)
    if not np.std(angle) < _SAME_PATH * np.std(one.psi[both]):
        return math.inf
    torque = one.M_z[both] - np.interp(t[both], other.t[known], other.M_z[known])
    return float(np.sqrt(np.mean(torque**2)))


def unique_labels(paths: Sequence[Path]) -> list[str]:
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


def parse_ground_by_recording(names: Sequence[str], given: Sequence[str] | None) -> dict[str, str]:
    """The grounds of texts such as "steel=fem1,fem3", by recording; "steel" alone is that of all."""
    grounds, known = dict[str, str](), set(names)
    for text in given or ():
        ground, equals, listed = (printable(part.strip()) for part in text.partition("="))
        if not ground:
            raise InvalidInputError(
                f"--ground {text}: expected NAME, or NAME=REC,REC such as steel=fem1,fem3"
            )
        for name in [one.strip() for one in listed.split(",")] if equals else names:
            if name not in known:
                raise InvalidInputError(
                    f"--ground {text}: no recording {name!r}; given are {', '.join(names)}"
                )
            if grounds.setdefault(name, ground) != ground:
                raise InvalidInputError(
                    f"--ground {text}: {name} stands on {grounds[name]} already; one ground each"
                )
    return grounds
