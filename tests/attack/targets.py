"""What is done with the bytes of a damaged file: an error of ours in one line, or something whole."""

import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from identification import (
    Journal,
    Recording,
    parse_signals,
    read_decay,
    read_model,
    read_recording,
    read_rig,
    read_signals,
)
from identification.free_decay.onset import find_vibration
from identification.selection.trials import TrialTask, run_trial
from identification.thesis.author_estimate import read_author_estimate
from symbolic import InvalidInputError
from tests.attack import formats
from tests.attack.oracle import check_decay, check_map, check_message, check_recording, check_rig
from tests.attack.workplace import workplace

RIG, CORPUS = formats.RIG, formats.CORPUS
"""The rig that is declared, and whole files, a folder for each target."""
BROKE = Path(__file__).parent / "broke"
"""Files that broke an older version, a folder for each target."""

Target = Callable[[bytes], None]


def _written(content: bytes, suffix: str) -> Path:
    path = workplace() / f"attacked{suffix}"
    path.write_bytes(content)
    return path


def _recording(suffix: str) -> Target:
    def target(content: bytes) -> None:
        path = _written(content, suffix)
        for causal in (False, True):
            try:
                check_recording(read_recording(path, RIG, torque_required=False, causal=causal))
            except InvalidInputError as error:
                check_message(error)

    return target


def _decay(suffix: str) -> Target:
    def target(content: bytes) -> None:
        try:
            decay = read_decay(_written(content, suffix), RIG)
            check_decay(decay)
            vibration = find_vibration(decay)
        except InvalidInputError as error:
            check_message(error)
            return
        assert 0 <= vibration.first < vibration.last <= decay.t.size
        assert np.isfinite([vibration.omega, vibration.damping, vibration.step]).all()

    return target


def author_file(content: bytes) -> None:
    """A published estimate of [Györök 2022]."""
    try:
        estimate = read_author_estimate(_written(content, ".csv"))
    except InvalidInputError as error:
        check_message(error)
        return
    assert len(estimate.t) == len(estimate.mu) >= 2
    assert np.isfinite([*estimate.t, *estimate.psi, *estimate.mu, estimate.declared]).all()


def rig_file(content: bytes) -> None:
    """A rig file, and its map of signals."""
    path = _written(content, ".toml")
    try:
        check_rig(*read_rig(path))
    except InvalidInputError as error:
        check_message(error)
    try:
        check_map(read_signals(path))
    except InvalidInputError as error:
        check_message(error)


def map_text(content: bytes) -> None:
    """A map of signals as on the command line."""
    try:
        check_map(parse_signals(content.decode("utf-8", "surrogateescape")))
    except InvalidInputError as error:
        check_message(error)


def model_file(content: bytes) -> None:
    """A model file, and what observers and simulations take from it."""
    try:
        found = read_model(_written(content, ".json"))
    except InvalidInputError as error:
        check_message(error)
        return
    for values in (found.values_for_estimation(), found.values_for("unknown", 1.0)):
        assert all(type(value) is float and not np.isnan(value) for value in values.values())
    found.model.theta(found.values_for("unknown", 1.0))


@cache
def kept_task() -> TrialTask:
    """The task whose kept trial is damaged."""
    t = np.arange(60) * 0.02
    psi = 0.2 * np.sin(2 * np.pi * t / 1.2)
    recording = Recording(
        name="turn", t=t, psi=psi, psi_dot=np.gradient(psi, t), M_z=-7 * np.tanh(20 * psi),
        F_N=np.full(60, 400.0), rig=RIG[0], tyre=RIG[1],
    )  # fmt: skip
    return TrialTask((), [recording])


@cache
def kept_trial() -> Path:
    """The file that keeps the trial, made anew: its name and format belong to this version."""
    folder = workplace() / "kept"
    Journal(folder=folder).note(kept_task(), run_trial(kept_task()))
    (path,) = folder.iterdir()
    return path


def journal(content: bytes) -> None:
    """A kept trial: what was kept, or nothing. The sums of the archive count as right."""
    path = kept_trial()
    path.write_bytes(content)
    checked = zipfile.ZipExtFile._update_crc
    zipfile.ZipExtFile._update_crc = lambda *_: None
    try:
        trial = Journal(folder=path.parent).recall(kept_task())
    finally:
        zipfile.ZipExtFile._update_crc = checked
    assert trial is None or np.isfinite(trial.fitted.scales).all()


TARGETS: dict[str, Target] = {
    "csv": _recording(".csv"),
    "csv_decay": _decay(".csv"),
    "mat": _recording(".mat"),
    "mat_decay": _decay(".mat"),
    "author_csv": author_file,
    "rig_toml": rig_file,
    "map_text": map_text,
    "model_json": model_file,
    "journal": journal,
    **{name: formats.target(name, workplace) for name in formats.installed()},
}
"""Every format that is read, by the name of its class."""


def seeds(name: str) -> list[bytes]:
    """Whole files of a format, to begin with."""
    paths = [kept_trial()] if name == "journal" else sorted((CORPUS / name).iterdir())
    return [path.read_bytes() for path in paths]


def broken(name: str) -> list[Path]:
    """Files of a format that broke an older version."""
    folder = BROKE / name
    return sorted(folder.iterdir()) if folder.is_dir() else []
