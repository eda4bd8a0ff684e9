"""What tests of reading share: files of measurement systems, and a bound of memory."""

import tracemalloc
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Columns = Mapping[str, NDArray[np.float64]]
"""t [ms], Angle [deg], Mz [N m], positive where the ground drives, Load [N]."""
MAP = "t=Time:ms,psi=Angle:deg,M_z=-Mz,F_N=Load"
"""The map of all of these files that keep time in a channel."""
UNITS = {"Time": "ms", "Angle": "deg", "Mz": "Nm", "Load": "N"}


def as_logged(t: Any, psi: Any, M_z: Any, F_N: Any) -> Columns:
    """Columns in SI units as these loggers keep them."""
    return {"Time": 1e3 * t, "Angle": np.degrees(psi), "Mz": -M_z, "Load": F_N}


def write_german(path: Path, columns: Columns) -> None:
    """Semicolons, decimal commas, a row of units, as Excel writes them in Germany."""
    rows = [";".join(columns), ";".join({**UNITS, "Angle": "°"}.values())]
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    rows += [";".join(repr(v).replace(".", ",") for v in row) for row in values]
    path.write_bytes("\r\n".join(rows).encode("cp1252"))


def write_tdms(path: Path, columns: Columns, **more: Mapping[str, Any]) -> Path:
    """One group of channels; `more` are properties of some."""
    nptdms = pytest.importorskip("nptdms", reason="needs brushgrip[tdms]")
    with nptdms.TdmsWriter(path) as writer:
        units = {n: {"unit_string": UNITS.get(n, "")} | more.get(n, {}) for n in columns}
        writer.write_segment([nptdms.ChannelObject("Rig", n, v, units[n]) for n, v in columns.items()])
    return path


def write_mdf_group(
    path: Path, channels: Iterable[tuple[str, Any]], times: Any, version: str = "4.10", *,
    clock: bool = True, **more: Mapping[str, Any],
) -> Path:  # fmt: skip
    """One group of channels; `more` is what asammdf knows besides of some, or of all by `_`."""
    asammdf = pytest.importorskip("asammdf", reason="needs brushgrip[mdf]")
    signals = [
        asammdf.Signal(v, times, name=n, unit=UNITS.get(n, ""), **more.get(n, more.get("_", {})))
        for n, v in channels
    ]
    with asammdf.MDF(version=version) as file:
        file.append(signals)
        if not clock:
            file.groups[0].channels[0].channel_type = 0
        file.save(path, overwrite=True, compression=2 if version > "4" else 0)
    return path


def write_mdf(path: Path, columns: Columns, version: str = "4.10") -> None:
    channels = [(n, v) for n, v in columns.items() if n != "Time"]
    write_mdf_group(path, channels, columns["Time"] / 1e3, version)


def write_fields(path: Path, columns: Iterable[tuple[str, Any]], **metadata: Mapping[str, str]) -> Path:
    """Columns of Parquet, of some with metadata."""
    pyarrow = pytest.importorskip("pyarrow", reason="needs brushgrip[parquet]")
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs brushgrip[parquet]")
    arrays = [(n, v if isinstance(v, pyarrow.Array) else pyarrow.array(v)) for n, v in columns]
    fields = [pyarrow.field(n, v.type, metadata=metadata.get(n)) for n, v in arrays]
    parquet.write_table(pyarrow.table([v for _, v in arrays], schema=pyarrow.schema(fields)), path)
    return path


def write_parquet(path: Path, columns: Columns) -> None:
    write_fields(path, columns.items(), **{n: {"unit": UNITS[n]} for n in columns})


def write_datasets(path: Path, columns: Columns, **attributes: Mapping[str, Any]) -> Path:
    """Datasets of HDF5, of some with attributes."""
    h5py = pytest.importorskip("h5py", reason="needs brushgrip[hdf5]")
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            dataset = file.create_dataset(name, data=values, compression="gzip")
            dataset.attrs.update(attributes.get(name, {}))
    return path


def write_hdf5(path: Path, columns: Columns) -> None:
    of_run = {f"run/{name}": values for name, values in columns.items()}
    write_datasets(path, of_run, **{f"run/{n}": {"unit": UNITS[n]} for n in columns})


def write_matlab_7_3(path: Path, columns: Columns) -> None:
    """As MATLAB lays it out: columns of a matrix, a header of 512 bytes before."""
    h5py = pytest.importorskip("h5py", reason="needs brushgrip[hdf5]")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in columns.items():
            file.create_dataset(name, data=values[np.newaxis])
        file["a"] = np.array([[0.05]])
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + path.read_bytes()[512:])


def write_frames(
    path: Path, t: NDArray[np.float64], units: Mapping[str, str], channels: Columns
) -> None:
    """Three signals of 32-bit float in frames of CAN FD, with their database beside."""
    can = pytest.importorskip("can", reason="needs brushgrip[can]")
    cantools = pytest.importorskip("cantools", reason="needs brushgrip[can]")
    dbc = ['VERSION ""', "NS_ :", "BS_:", "BU_: rig", "BO_ 291 Motion: 12 rig"]
    dbc += [f' SG_ {n} : {32 * i}|32@1- (1,0) [0|0] "{units[n]}" rig' for i, n in enumerate(units)]
    dbc += [f"SIG_VALTYPE_ 291 {name} : 1;" for name in units]
    path.with_name("rig.dbc").write_text("\n".join([*dbc, ""]))
    message = cantools.database.load_file(path.with_name("rig.dbc")).get_message_by_name("Motion")
    with can.Logger(path) as log:
        for i, time in enumerate(t.tolist()):
            data = message.encode({n: float(channels[n][i]) for n in units}, padding=True)
            frame = {"arbitration_id": 291, "is_extended_id": False, "is_fd": True}
            log.on_message_received(can.Message(timestamp=1.6e9 + time, data=data, **frame))


def write_can(path: Path, columns: Columns) -> None:
    write_frames(path, columns["Time"] / 1e3, {n: u for n, u in UNITS.items() if n != "Time"}, columns)


def write_ros(path: Path, columns: Columns) -> None:
    """ROS 1: a bag; ROS 2: a folder with the messages in SQLite or MCAP beside metadata.yaml."""
    pytest.importorskip("rosbags", reason="needs brushgrip[ros]")
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    ros_1 = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros_1 else Stores.ROS2_HUMBLE)
    kinds = store.types
    stamp, header = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    state = kinds["sensor_msgs/msg/JointState"]
    plugin = rosbag2.StoragePlugin.MCAP if path.suffix == ".mcap" else rosbag2.StoragePlugin.SQLITE3
    writer = (
        rosbag1.Writer(path) if ros_1 else rosbag2.Writer(path.parent, version=9, storage_plugin=plugin)
    )
    serialize = store.serialize_ros1 if ros_1 else store.serialize_cdr
    rows = zip(*(columns[n].tolist() for n in ("Time", "Angle", "Mz", "Load")), strict=True)
    with writer as bag:
        connection = bag.add_connection("/rig", state.__msgtype__, typestore=store)
        for time, angle, torque, load in rows:
            nanoseconds = round(time * 1e6) + 1_600_000_000 * 10**9
            number = {"seq": 0} if ros_1 else {}
            head = header(stamp=stamp(*divmod(nanoseconds, 10**9)), frame_id="", **number)
            message = state(
                header=head, name=["wheel"], position=np.array([angle]), velocity=np.array([load]),
                effort=np.array([torque]),
            )  # fmt: skip
            bag.write(connection, nanoseconds, serialize(message, state.__msgtype__))


JOINT_STATE = "psi=/rig.position.0:deg,M_z=-/rig.effort.0,F_N=/rig.velocity.0"
OWN_CLOCK = "psi=Angle:deg,M_z=-Mz,F_N=Load"
WRITERS: dict[str, tuple[str, Callable[[Path, Columns], object], str]] = {
    "german": ("run.csv", write_german, MAP),
    "tdms": ("run.tdms", write_tdms, MAP),
    "mdf": ("run.mf4", write_mdf, OWN_CLOCK),
    "parquet": ("run.parquet", write_parquet, MAP),
    "hdf5": ("run.h5", write_hdf5, MAP),
    "matlab": ("run.mat", write_matlab_7_3, MAP),
    "blf": ("run.blf", write_can, OWN_CLOCK),
    "asc": ("run.asc", write_can, OWN_CLOCK),
    "candump": ("run.log", write_can, OWN_CLOCK),
    "mdf 3": ("run.mdf", partial(write_mdf, version="3.30"), OWN_CLOCK),
    "ros": ("run.bag", write_ros, JOINT_STATE),
    "ros 2": ("bag/bag.db3", write_ros, JOINT_STATE),
    "ros 2 mcap": ("bag/bag.mcap", write_ros, JOINT_STATE),
}
"""File name, writer and map of each format."""


@contextmanager
def require_less_memory(most: int) -> Iterator[None]:
    """What happens inside takes less than this at any time [bytes]."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()
