"""Damaged files of the formats that need libraries of their own, as far as these are installed."""

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from shutil import copy

from identification import read_recording
from symbolic import InvalidInputError, Rig, Tyre
from tests.attack.oracle import check_message, check_recording

RIG = (Rig(a=0.045, e=0.009, J_A=0.15, b_t=0.3), Tyre(k=2.4e6, mu=1.2))
CORPUS = Path(__file__).parent / "corpus"
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
}
"""Library, file under attack and map of signals of each class."""
BESIDE = {
    "can_blf": ("run.dbc",), "can_asc": ("run.dbc",), "can_log": ("run.dbc",), "can_dbc": ("run.log",),
    "ros_mcap": ("mcap/metadata.yaml",), "ros_db3": ("db3/metadata.yaml",),
}  # fmt: skip
"""Whole files, of the folder `beside` of the corpus, that lie with the one under attack."""


def target(name: str, top: Callable[[], Path]) -> Callable[[bytes], None]:
    """What is done with the bytes of a format.

    Args:
        name: of the class.
        top: the folder to work in, asked for when the first file is written.
    """
    _, file, signals = FORMATS[name]

    @cache
    def folder() -> Path:
        made = top() / name
        made.mkdir()
        for other in BESIDE.get(name, ()):
            copy(CORPUS / "beside" / other, made)
        return made

    def attack(content: bytes) -> None:
        (folder() / file).write_bytes(content)
        read = folder() / ("run.log" if name == "can_dbc" else file)
        try:
            check_recording(read_recording(read, RIG, torque_required=False, signals=signals))
        except InvalidInputError as error:
            check_message(error)

    return attack


def installed() -> list[str]:
    """Classes whose library is installed."""
    return [name for name, (library, _, _) in FORMATS.items() if find_spec(library) is not None]
