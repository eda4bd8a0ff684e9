"""What files say beside their numbers counts: clocks, buses, ranges, scales, units, missing ends."""

import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identification import Recording, read_recording
from identification.reading.signal_map import as_map_option
from symbolic import Rig, Tyre
from tests import refusal
from tests.columns import write_columns
from tests.identification.reading.logs import (
    Columns,
    write_datasets,
    write_fields,
    write_mdf_group,
    write_tdms,
)

RIG = (Rig(a=0.045, e=0.009), Tyre(k=2.4e6))
N = 60
T = 0.01 * np.arange(N)
COLUMNS = {"psi": 0.2 * np.sin(5 * T), "M_z": -3 * np.cos(4 * T), "F_N": 400 + T}


def read(path: Path, signals: str = "", *, causal: bool = False) -> Recording:
    return read_recording(path, RIG, signals=signals, causal=causal)


refused = partial(refusal.refused, read)


def warnings_in(caplog: pytest.LogCaptureFixture) -> str:
    return "\n".join(record.getMessage() for record in caplog.records)


def write_waveforms(folder: Path, columns: Columns = COLUMNS, **starts: Mapping[str, Any]) -> Path:
    waves = {name: {"wf_increment": 0.01, **starts.get(name, {})} for name in columns}
    return write_tdms(folder / "run.tdms", columns, **waves)


@pytest.mark.parametrize("key", ["wf_start_time", "wf_start_offset"])
def test_channels_of_tdms_that_start_apart_are_not_simultaneous(key: str, tmp_path: Path) -> None:
    zero = np.datetime64("2026-01-01T00:00:00", "us") if key == "wf_start_time" else 0.0
    late = zero + np.timedelta64(500, "ms") if key == "wf_start_time" else 0.5
    starts = {name: {key: late if name == "psi" else zero} for name in COLUMNS}
    t = 0.01 * np.arange(2 * N)
    columns = {name: np.interp(t, t, np.sin(t) + 2) for name in COLUMNS}
    columns["psi"] = np.sin(t + 0.5)

    recording = read(write_waveforms(tmp_path, columns, **starts))

    shared = recording.t >= 0.5
    assert shared.any()
    np.testing.assert_allclose(recording.psi[shared], np.sin(recording.t[shared]), atol=1e-9)


def test_tdms_with_one_dated_clock_is_refused(tmp_path: Path) -> None:
    start = {"wf_start_time": np.datetime64("2026-01-01T00:00:00", "us")}

    assert "only one has a wf_start_time" in refused(write_waveforms(tmp_path, M_z=start))


@pytest.mark.parametrize("cut", [1, 3, 200])
@pytest.mark.parametrize("segments", [1, 2])
def test_a_tdms_file_cut_short_is_refused_and_its_library_is_silent(
    cut: int, segments: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write_waveforms(tmp_path)
    content = path.read_bytes() * segments
    path.write_bytes(content)
    assert read(path).t.size == segments * N
    path.write_bytes(content[:-cut])

    assert refused(path).endswith("run.tdms: is cut short; copy it again, or save what is in it")
    assert warnings_in(caplog) == ""


def test_libraries_of_can_are_silent(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = write_can(tmp_path / "run.asc", [*motion(), *load()])
    text = path.read_text()
    assert text.count(" d 8 ") == 2 * N
    path.write_text(text.replace(" d 8 ", " d 7 ", 1))
    text = DBC.format(id=291)
    (tmp_path / "rig.dbc").write_text(text + text[text.index("BO_ 291") :].replace("F_N", "Z"))

    assert "two columns are named" in refused(path)
    assert warnings_in(caplog) == ""


def test_a_tdms_file_that_labview_left_open_is_read_with_a_remark(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write_waveforms(tmp_path)
    content = bytearray(path.read_bytes())
    content[12:20] = b"\xff" * 8
    path.write_bytes(content)

    assert read(path).t.size == N
    assert warnings_in(caplog).count("LabVIEW did not close the file") == 1


def test_two_channels_of_a_name_in_one_group_are_told_apart(tmp_path: Path) -> None:
    channels = [*COLUMNS.items(), ("psi", 2 * COLUMNS["psi"])]
    path = write_mdf_group(tmp_path / "run.mf4", channels, T)

    for signals in ("", "psi=psi"):
        assert "'psi' may be 0.1/psi, 0.4/psi; give the full name in --map" in refused(path, signals)
    for signals, factor in (("psi=0.1/psi", 1), ("psi=0.4/psi", 2)):
        np.testing.assert_allclose(read(path, signals).psi, factor * COLUMNS["psi"])


def test_values_marked_invalid_are_missing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    invalid = (T > 0.1) & (T < 0.3)
    marked = {"invalidation_bits": invalid}
    recording = read(write_mdf_group(tmp_path / "run.mf4", COLUMNS.items(), T, M_z=marked))

    np.testing.assert_allclose(recording.psi, COLUMNS["psi"])
    np.testing.assert_array_equal(np.isnan(recording.M_z), invalid)
    assert f"M_z: {invalid.sum()} of 60 values are marked invalid" in warnings_in(caplog)


DBC = """VERSION ""
BU_: rig
BO_ {id} Motion: 8 rig
 SG_ psi : 0|16@1+ (0.0001,-3) [-3|3.5533] "rad" rig
 SG_ M_z : 16|16@1+ (0.01,-300) [-300|355.33] "Nm" rig
BO_ 292 Load: 8 rig
 SG_ F_N : 0|16@1+ (0.1,0) [0|6553.3] "N" rig
"""
EXTENDED = 1 << 31


def motion(factor: float = 1.0, **changes: Any) -> list[tuple[float, dict[str, Any], bytes]]:
    """Frames of angle and torque: time, what distinguishes them, and data."""
    raw = np.round((factor * COLUMNS["psi"] + 3) / 0.0001), np.round((COLUMNS["M_z"] + 300) / 0.01)
    head = {"arbitration_id": 291, "is_extended_id": False, "channel": 0, **changes}
    rows = zip(T.tolist(), *(r.astype("<u2") for r in raw), strict=True)
    return [(t, head, p.tobytes() + m.tobytes() + bytes(4)) for t, p, m in rows]


def load(late: float = 0.0, raw: int = 4000) -> list[tuple[float, dict[str, Any], bytes]]:
    head = {"arbitration_id": 292, "is_extended_id": False, "channel": 0}
    return [(t + late, head, raw.to_bytes(2, "little") + bytes(6)) for t in T.tolist()]


def write_can(
    path: Path, frames: list[tuple[float, dict[str, Any], bytes]], identifier: int = 291
) -> Path:
    can = pytest.importorskip("can", reason="needs brushgrip[can]")
    pytest.importorskip("cantools", reason="needs brushgrip[can]")
    (path.parent / "rig.dbc").write_text(DBC.format(id=identifier))
    with can.Logger(path) as log:
        for t, head, data in sorted(frames, key=lambda frame: frame[0]):
            named = dict(head)
            if path.suffix == ".log":
                named["channel"] = f"can{named['channel']}"
            log.on_message_received(can.Message(timestamp=1.6e9 + t, data=data, **named))
    return path


@pytest.mark.parametrize(("suffix", "first", "second"), [
    (".blf", "1", "2"), (".asc", "1", "2"), (".log", "can0", "can1"),
])  # fmt: skip
def test_a_frame_on_two_buses_needs_its_bus(
    suffix: str, first: str, second: str, tmp_path: Path
) -> None:
    frames = [*motion(), *motion(2.0, channel=1), *load()]
    path = write_can(tmp_path / f"run{suffix}", frames)

    message = refused(path, "psi=-psi,M_z=Motion.M_z")
    assert f"holds the frame Motion (0x123) from several buses, {first}, {second}; say which" in message
    remedy = message.partition("--map ")[2]
    assert remedy == f"psi=-{first}/psi,M_z={first}/Motion.M_z"
    np.testing.assert_allclose(read(path, remedy).psi, -COLUMNS["psi"], atol=1e-4)
    other = remedy.replace(f"{first}/", f"{second}/")
    np.testing.assert_allclose(read(path, other).psi, -2 * COLUMNS["psi"], atol=1e-4)
    assert f"--map psi={first}/Motion.psi" in refused(path)
    absent = remedy.replace(f"{first}/", "9/")
    assert f"holds no frame Motion (0x123) on bus 9; it is on {first}, {second}" in refused(path, absent)
    assert refused(write_can(path, load())).endswith("holds no frame Motion (0x123)")


@pytest.mark.parametrize("suffix", [".blf", ".asc", ".log"])
@pytest.mark.parametrize("extended", [False, True])
def test_extended_identifiers_are_others(suffix: str, extended: bool, tmp_path: Path) -> None:
    frames = [*motion(), *motion(2.0, is_extended_id=True), *load()]
    identifier = 291 | (EXTENDED if extended else 0)
    path = write_can(tmp_path / f"run{suffix}", frames, identifier)

    recording = read(path)
    if extended:
        write_can(path, [*motion(), *load()], identifier)
        other = "holds no extended frame Motion (0x123), but a standard one of that identifier"
        assert other in refused(path)

    assert recording.t.size == N
    np.testing.assert_allclose(recording.psi, (1 + extended) * COLUMNS["psi"], atol=1e-4)


def test_values_beyond_their_range_are_missing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    frames = [*motion(), *load()]
    frames[7] = (*frames[7][:2], b"\xff\xff" * 2 + bytes(4))
    path = write_can(tmp_path / "run.blf", frames)

    recording = read(path)

    assert recording.psi[7] == pytest.approx((recording.psi[6] + recording.psi[8]) / 2)
    assert np.isnan(recording.M_z[7])
    told = "Motion.psi: 1 of 60 values lie outside the range of the database, -3 to 3.5533 rad"
    assert told in warnings_in(caplog)
    path = write_can(tmp_path / "run.blf", [*motion(), *load(raw=65535)])
    outside = "every value of Load.F_N lies outside the range of the database, 0 to 6553.3 N"
    assert outside in refused(path)


@pytest.mark.parametrize("line", [
    "BO_ 291 Steer: 99999999 A", "BO_ 291 Steer: 65 A", "BO_ 2147484000 Steer: 1786 A",
    "BO_ 291 Steer: // long\n 99999999 A",
    "BO_ 291 Steer: 8 A\n SG_ X : 0|99999999@1- (1,0) [0|0] \"\" A",
    "BO_ 291 Steer: 8 A\n SG_ X m0 : 99999999|8@1- (1,0) [0|0] \"\" A",
])  # fmt: skip
def test_a_database_of_absurd_lengths_is_refused_at_once(line: str, tmp_path: Path) -> None:
    path = write_can(tmp_path / "run.blf", [*motion(), *load()])
    (tmp_path / "rig.dbc").write_text(line)
    start = time.monotonic()

    message = refused(path)

    assert "allowed: up to" in message or "beyond the 1785 bytes" in message
    assert time.monotonic() - start < 2


@pytest.mark.parametrize("causal", [False, True])
def test_a_load_that_begins_late_is_waited_for(
    causal: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write_can(tmp_path / "run.blf", [*motion(), *load(late=0.001)])

    assert read(path, causal=causal).t.size == N - causal
    assert ("begins at sample 2, 0.01 s after the first" in warnings_in(caplog)) == causal


def test_too_little_behind_the_first_load_is_refused(tmp_path: Path) -> None:
    path = write_can(tmp_path / "run.blf", [*motion(), *load(late=0.55)])

    assert "at least 10 samples are needed from there on" in refused(path, causal=True)


def write_hdf5(folder: Path, columns: Columns, **attributes: Mapping[str, Any]) -> Path:
    return write_datasets(folder / "run.h5", {"t": T, **COLUMNS, **columns}, **attributes)


@pytest.mark.parametrize("attributes", [
    {"scale_factor": 0.001, "add_offset": -1.0, "_FillValue": np.int16(-32768)},
    {"scale_factor": [0.001], "add_offset": [-1.0], "missing_value": np.array([-32768, -1], np.int16)},
])  # fmt: skip
def test_hdf5_is_unpacked_by_the_cf_conventions(attributes: dict[str, Any], tmp_path: Path) -> None:
    packed = np.round((COLUMNS["M_z"] + 1) / 0.001).astype(np.int16)
    packed[5] = -32768
    torque = read(write_hdf5(tmp_path, {"M_z": packed}, M_z=attributes)).M_z

    assert np.flatnonzero(np.isnan(torque)).tolist() == [5]
    np.testing.assert_allclose(np.delete(torque, 5), np.delete(COLUMNS["M_z"], 5), atol=6e-4)
    wrong = write_hdf5(tmp_path, {}, M_z=attributes | {"scale_factor": "milli"})
    assert "scale_factor of M_z must be a number" in refused(wrong)


def test_two_columns_of_a_name_in_parquet_are_refused(tmp_path: Path) -> None:
    path = write_fields(tmp_path / "run.parquet", [("t", T), *COLUMNS.items(), ("psi", T)])

    assert refused(path).endswith("two columns are named psi; one allowed")


@pytest.mark.parametrize("kind", [
    "duration[ms]", "duration[ns]", "time32[ms]", "time64[us]", "timestamp[ms]", "decimal",
])  # fmt: skip
def test_times_of_every_kind_in_parquet(kind: str, tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow", reason="needs brushgrip[parquet]")
    ticks = {"s": 1, "ms": 1e3, "us": 1e6, "ns": 1e9}.get(kind[-3:-1].strip("["), 100)
    values = np.round(T * ticks).astype(np.int32 if "32" in kind else np.int64)
    if kind == "decimal":
        t = pyarrow.array(T).cast(pyarrow.decimal128(9, 2))
    else:
        t = pyarrow.array(values).cast(kind)
    path = write_fields(tmp_path / "run.parquet", [("t", t), *COLUMNS.items()])

    np.testing.assert_allclose(read(path).t, T, atol=1e-9)
    if kind != "decimal":
        assert "t: has a unit of its own; write --map t=t" in refused(path, "t=t:ms")


@pytest.mark.parametrize(("columns", "signals", "remedy"), [
    ({"Load [t]": COLUMNS["F_N"]}, "F_N=Load", "F_N=Load:N"),
    ({"load_kN": COLUMNS["F_N"]}, "F_N=load_kN:MN", "F_N=load_kN:kN"),
    ({"F_N": -COLUMNS["F_N"]}, "", "F_N=-F_N"),
    ({"Last": -COLUMNS["F_N"] / 1e3}, "F_N=Last:kN", "F_N=-Last:kN"),
    ({"F_N": COLUMNS["F_N"], "Winkel": 900 * T}, "psi=Winkel", "psi=1/15*Winkel:deg"),
])  # fmt: skip
def test_every_error_of_a_unit_or_a_sign_prints_a_map_that_mends_it(
    columns: dict[str, Any], signals: str, remedy: str, tmp_path: Path
) -> None:
    rest = {n: v for n, v in COLUMNS.items() if f"{n}=" not in signals and n not in columns}
    path = write_columns(tmp_path / "run.csv", {"t": T} | rest | columns)

    assert as_map_option([remedy]) in refused(path, signals)
    read(path, remedy)


@pytest.mark.parametrize("kind", [2, 3, 4, None])
def test_a_master_of_mdf_that_is_no_time_is_none(kind: int | None, tmp_path: Path) -> None:
    given = {} if kind is None else {"master_metadata": ("angle", kind)}
    channels, path = {**COLUMNS, "clock": T}.items(), tmp_path / "run.mf4"
    write_mdf_group(path, channels, 2 * T, clock=kind is not None, _=given)

    assert "channel t missing" in refused(path)
    np.testing.assert_allclose(read(path, "t=clock").t, T, atol=1e-12)


@pytest.mark.parametrize("key", ["unit", "Units", "UNIT"])
def test_a_unit_is_a_unit_however_its_key_is_spelt(key: str, tmp_path: Path) -> None:
    columns = {"t": T, **COLUMNS, "psi": np.degrees(COLUMNS["psi"])}
    write_hdf5(tmp_path, columns, psi={key: ["deg"]})
    write_fields(tmp_path / "run.parquet", columns.items(), psi={key: "deg"})

    for name in ("run.h5", "run.parquet"):
        np.testing.assert_allclose(read(tmp_path / name).psi, COLUMNS["psi"], rtol=1e-12)


def test_a_time_of_hdf5_may_be_counted_from_an_instant(tmp_path: Path) -> None:
    units = {"units": "milliseconds since 2026-01-01 00:00:00"}
    path = write_hdf5(tmp_path, {"t": 1e3 * T}, t=units)

    np.testing.assert_allclose(read(path).t, T, rtol=1e-12)


@pytest.mark.parametrize(
    ("ranges", "scale"),
    [
        ({"valid_min": -50.0}, 1.0),
        ({"valid_max": np.int16(500), "valid_min": np.int16(-500)}, 0.01),
        ({"valid_range": [-5.0, 5.0]}, 0.01),
        ({"valid_range": "-5 5", "valid_min": -50.0}, 1.0),
    ],
)
def test_values_of_hdf5_beyond_their_valid_range_are_missing(
    ranges: dict[str, Any], scale: float, tmp_path: Path
) -> None:
    torque = np.round(COLUMNS["M_z"] / scale).astype("i2" if scale < 1 else "f8")
    torque[20:25] = -9999
    scaled = ranges | ({"scale_factor": scale} if scale < 1 else {})
    missing = np.isnan(read(write_hdf5(tmp_path, {"M_z": torque}, M_z=scaled)).M_z)

    assert np.flatnonzero(missing).tolist() == [20, 21, 22, 23, 24]
