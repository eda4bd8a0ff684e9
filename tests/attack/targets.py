"""What is done with the bytes of a damaged file: an error of ours in one line, or something whole."""

import zipfile
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from shutil import copy

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
from identification.free_decay.vibration_detection import find_vibration
from identification.selection.trial import TrialTask, run_trial
from identification.thesis.published_author_estimate import read_author_estimate
from symbolic import InvalidInputError, Rig, Tyre
from tests.attack.oracle import (
    check_decay,
    check_map,
    check_message,
    check_recording,
    check_rig,
    refused_in_a_line,
)
from tests.attack.workplace import CORPUS, workplace

RIG = (Rig(a=0.045, e=0.009, J_A=0.15, b_t=0.3), Tyre(k=2.4e6, mu=1.2))
BROKE = Path(__file__).parent / "broke"
"""Files that broke an older version, a folder for each target."""

Target = Callable[[bytes], None]
OWN_CLOCK = "psi=Angle:deg,M_z=-Mz,F_N=Load"
CLOCK = f"t=Time:ms,{OWN_CLOCK}"
ROS = "psi=/rig.position.0:deg,M_z=-/rig.effort.0,F_N=/rig.velocity.0"
FORMATS: dict[str, tuple[str, str, str]] = {
    "tdms": ("nptdms", "run.tdms", CLOCK),
    "mdf": ("asammdf", "run.mf4", OWN_CLOCK),
    "parquet": ("pyarrow", "run.parquet", CLOCK),
    "hdf5": ("h5py", "run.h5", CLOCK),
    "matlab_7_3": ("h5py", "run.mat", CLOCK),
    "can_blf": ("cantools", "run.blf", OWN_CLOCK),
    "can_asc": ("cantools", "run.asc", OWN_CLOCK),
    "can_log": ("cantools", "run.log", OWN_CLOCK),
    "can_dbc": ("cantools", "run.dbc", OWN_CLOCK),
    "ros_bag": ("rosbags", "run.bag", ROS),
    "ros_mcap": ("rosbags", "run.mcap", ROS),
    "ros_db3": ("rosbags", "run.db3", ROS),
    "ros_yaml": ("rosbags", "metadata.yaml", ROS),
}
"""Library, file under attack and map of signals of each class."""
BESIDE = {
    "can_blf": ("run.dbc",), "can_asc": ("run.dbc",), "can_log": ("run.dbc",), "can_dbc": ("run.log",),
    "ros_mcap": ("mcap/metadata.yaml",), "ros_db3": ("db3/metadata.yaml",), "ros_yaml": ("run.mcap",),
}  # fmt: skip
"""Whole files, of the folder `beside` of the corpus, that lie with the one under attack."""
READ_ALONG = {"can_dbc": "run.log", "ros_yaml": "run.mcap"}
"""The recording, where what is under attack is only read along with it."""


def _written(content: bytes, suffix: str) -> Path:
    path = workplace() / f"attacked{suffix}"
    path.write_bytes(content)
    return path


def _recording(suffix: str) -> Target:
    def target(content: bytes) -> None:
        path = _written(content, suffix)
        for causal in (False, True):
            with refused_in_a_line():
                check_recording(read_recording(path, RIG, torque_required=False, causal=causal))

    return target


def _format(name: str) -> Target:
    """What is done with the bytes of a format that needs a library."""
    _, file, signals = FORMATS[name]

    @cache
    def folder() -> Path:
        place = workplace() / name
        place.mkdir()
        for other in BESIDE.get(name, ()):
            copy(CORPUS / "beside" / other, place)
        return place

    def target(content: bytes) -> None:
        (folder() / file).write_bytes(content)
        path = folder() / READ_ALONG.get(name, file)
        with refused_in_a_line():
            check_recording(read_recording(path, RIG, torque_required=False, signals=signals))

    return target


def _decay(suffix: str) -> Target:
    def target(content: bytes) -> None:
        with refused_in_a_line():
            decay = read_decay(_written(content, suffix), RIG)
            check_decay(decay)
            vibration = find_vibration(decay)
            assert 0 <= vibration.first < vibration.last <= decay.t.size
            assert np.isfinite([vibration.omega, vibration.damping, vibration.step]).all()

    return target


def author_file(content: bytes) -> None:
    """A published estimate of [Györök 2022]."""
    with refused_in_a_line():
        estimate = read_author_estimate(_written(content, ".csv"))
        assert len(estimate.t) == len(estimate.mu) >= 2
        assert np.isfinite([*estimate.t, *estimate.psi, *estimate.mu, estimate.declared]).all()


def rig_file(content: bytes) -> None:
    """A rig file, and its map of signals."""
    path = _written(content, ".toml")
    with refused_in_a_line():
        check_rig(*read_rig(path))
    with refused_in_a_line():
        check_map(read_signals(path))


def map_text(content: bytes) -> None:
    """A map of signals as on the command line."""
    with refused_in_a_line():
        check_map(parse_signals(content.decode("utf-8", "surrogateescape")))


def model_file(content: bytes) -> None:
    """A model file, and what observers and simulations take from it."""
    try:
        found = read_model(_written(content, ".json"))
    except InvalidInputError as error:
        check_message(error)
        return
    for values in (found.values_for_estimation(), found.values_for_recording("unknown", 1.0)):
        assert all(type(value) is float and not np.isnan(value) for value in values.values())
    found.model.theta(found.values_for_recording("unknown", 1.0))


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
    **{name: _format(name) for name, (library, _, _) in FORMATS.items() if find_spec(library)},
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
