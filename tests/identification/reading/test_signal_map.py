"""Maps of channels to columns: their text, their section of a rig file, and what they do to samples."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, parse_signals, read_decay, read_recording, read_rig, read_signals
from identification.reading.channels_by_name import ChannelFile, ChannelSamples, match_channel
from identification.reading.checked_sample_table import REQUIRED_COLUMNS, Table
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.signal_map import NO_MAP
from identification.reading.units import factor_of
from symbolic import Rig, Tyre
from tests.columns import write_columns
from tests.refusal import refused

PATH, RIG = Path("run.mf4"), (Rig(a=0.045, e=0.009), Tyre(k=2.4e6))
TIMES = [0.01 * i for i in range(20)]
ROWS = [(t, 10 * math.sin(9 * t), 3 * math.cos(t), 0.5 + t) for t in TIMES]
"""Seconds, degrees of the steering wheel, N m, kN."""


def write(path: Path, header: str, *more: str, delimiter: str = ",", decimal: str = ".") -> Path:
    rows = [delimiter.join(repr(x).replace(".", decimal) for x in row) for row in ROWS]
    path.write_text("\n".join([header, *more, *rows]) + "\n", encoding="utf-8")
    return path


def require_expected(recording: Recording, factor: float = 1.0, sign: float = 1.0) -> None:
    t, angle, torque, load = np.array(ROWS).T
    np.testing.assert_allclose(recording.t, t, rtol=1e-12)
    np.testing.assert_allclose(recording.psi, factor * angle * math.pi / 180, rtol=1e-12)
    np.testing.assert_allclose(recording.M_z, sign * torque, rtol=1e-12)
    np.testing.assert_allclose(recording.F_N, 1e3 * load, rtol=1e-12)


def test_a_map_gives_unit_sign_and_factor_and_serves_a_free_vibration_too(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", "Time,Steer,Mz,Load")

    read = read_recording(path, RIG, signals="t=Time,psi=0.06*Steer:deg,M_z=-Mz,F_N=Load:kN")

    require_expected(read, 0.06, -1)
    rig = (Rig(a=0.045, e=0.009, J_A=0.15), RIG[1])
    decay = read_decay(path, rig, signals="t=Time,psi=Steer:deg")
    assert decay.psi[3] == pytest.approx(math.radians(ROWS[3][1]))


def test_a_rig_file_holds_a_map(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "[rig]\na = 0.045\ne = 0.009\n[tyre]\nk = 2.4e6\n[signals]\nt = 'Time'\ndbc = 'car.dbc'\n"
        "psi = { channel = 'Steer', unit = 'deg', factor = -0.06 }\n"
        "F_N = { channel = 'Load', unit = 'kN' }\n"
    )
    signals = read_signals(rig)
    path = write(tmp_path / "run.csv", "Time,Steer,M_z,Load")

    require_expected(read_recording(path, read_rig(rig), signals=signals), -0.06)
    require_expected(read_recording(path, rig), -0.06)
    require_expected(read_recording(path, str(rig), signals="psi=0.06*Steer:deg"), 0.06)
    message = refused(read_recording, path, read_rig(rig))
    assert "(in Python by signals=, or with the rig file itself" in message
    assert signals.dbc == tmp_path / "car.dbc"
    assert signals.updated(parse_signals("psi=Other:rad")).of("psi").channel == "Other"
    assert signals.updated(parse_signals("psi=Other:rad")).of("F_N").unit == "kN"


@pytest.mark.parametrize("delimiter", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_csv_files_of_all_countries(delimiter: str, decimal: str, encoding: str, tmp_path: Path) -> None:
    header = delimiter.join(["t [s]", "psi", "M_z", "F_N"])
    units = delimiter.join(["", "[°]", "Nm", "kN"])
    path = write(tmp_path / "run.csv", header, units, delimiter=delimiter, decimal=decimal)
    path.write_bytes(path.read_text(encoding="utf-8").encode(encoding))

    require_expected(read_recording(path, RIG))


def test_units_behind_headings_count_and_the_map_goes_before_them(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", "t (s),Steer [deg],M_z,F_N [kN]")
    require_expected(read_recording(path, RIG, signals="psi=Steer"))
    assert read_recording(path, RIG, signals="psi=Steer:rad").psi[1] == pytest.approx(ROWS[1][1])
    path = write(tmp_path / "run.csv", "t,psi [counts],M_z,F_N")
    message = refused(read_recording, path, RIG)
    assert re.search("'counts' is no unit of psi; .* --map psi=psi:rad", message)


def test_one_file_has_one_decimal_sign_and_a_comma_between_fields_is_none(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", "t;psi;M_z;F_N", delimiter=";", decimal=",")
    path.write_text(path.read_text().replace("0,05;", "0.05;"))
    assert "row 7: t = '0.05' is not a number" in refused(read_recording, path, RIG)
    path = write(tmp_path / "run.csv", "t,psi,M_z,F_N")
    rows = ['"0,01",' + row for row in path.read_text().splitlines()[1:]]
    path.write_text("\n".join(["time,t,psi,M_z,F_N", *rows]))
    assert "row 2: t = '0,01' is not a number" in refused(read_recording, path, RIG, signals="t=time")


def test_columns_named_otherwise_are_listed_and_a_map_is_proposed(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", "Zeit [s];Winkel [°];Moment [Nm];Last [kN]", delimiter=";")
    message = refused(read_recording, path, RIG)
    there = (
        "missing; there are Zeit [s], Winkel [°], Moment [Nm], Last [kN]; Moment is taken for M_z, the"
    )
    assert there in message
    assert "turns the wheel is M (M=Moment, with J_A and b_t in the rig file) or, turned" in message
    assert "slowly, M_z=-Moment; say which is which" in message
    assert message.endswith("such as --map t=Zeit,psi=Winkel,M_z=Moment,F_N=Last")
    require_expected(read_recording(path, RIG, signals="t=Zeit,psi=Winkel,M_z=Moment,F_N=Last"))
    assert "M_z=Moment" in refused(read_recording, path, RIG, torque_required=False)
    message = refused(read_recording, path, RIG, torque_required=False, signals="M=Moment")
    assert message.endswith("--map t=Zeit,psi=Winkel,F_N=Last,M=Moment")


@pytest.mark.parametrize("torque", ["Mz", "AligningTorque", "SteeringWheelTorque", "M_z", "M"])
def test_a_torque_whose_name_tells_which_it_is_is_not_asked_about(torque: str, tmp_path: Path) -> None:
    message = refused(read_recording, write(tmp_path / "run.csv", f"Time,Angle,{torque},Load"), RIG)

    assert "say which is which" in message
    assert "taken for M_z" not in message


def test_a_proposal_has_time_units_and_the_steering_ratio(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", "time_ms,SteeringWheelAngle_deg,SteeringWheelTorque,Load_kN")
    message = refused(read_recording, path, RIG)
    assert message.endswith(
        "--map 't=time_ms:ms,psi=1/15*SteeringWheelAngle_deg:deg,M_z=-15*SteeringWheelTorque,"
        "F_N=Load_kN:kN', with your steering ratio for 15"
    )
    read_recording(path, RIG, signals=message.partition("--map '")[2].partition("'")[0])


@pytest.mark.parametrize("heading", ["Moment", "Moment [Nm]"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_proposal_has_units_and_sign_by_the_numbers(sign: int, heading: str, tmp_path: Path) -> None:
    path, t = tmp_path / "run.csv", np.linspace(0, 4, 200)
    psi = 30 * np.sin(2 * t)
    moment = -sign * 20 * np.sign(np.cos(2 * t))
    write_columns(path, {"Time": 1e3 * t, "Angle": psi, heading: moment, "Load": 0.4})
    message = refused(read_recording, path, RIG)
    option = f"t=Time:ms,psi=Angle:deg,M_z={'-' * (sign < 0)}Moment,F_N=Load:kN"
    assert message.endswith(f"such as --map {option}")
    recording = read_recording(path, RIG, signals=option)
    assert np.sum(recording.M_z[1:] * np.diff(recording.psi)) < 0


@pytest.mark.parametrize("extreme", [math.inf, -math.inf, 1.7e308, -1.7e308])
@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize(
    ("headings", "option"),
    [
        ("Time,Angle,Moment,Load", ""),
        ("Time [ms],Angle [°],Moment [kNm],Load [kN]", ""),
        ("t,psi,M_z,F_N", ""),
        ("t,psi,M_z,F_N", "t=t,psi=psi,M_z=-1e3*M_z,F_N=F_N:kN"),
    ],
)
def test_numbers_beyond_all_range_are_refused(
    headings: str, option: str, column: int, extreme: float, tmp_path: Path
) -> None:
    t = np.linspace(0, 4, 200)
    values = [t.copy(), np.sin(2 * t), -20 * np.cos(2 * t), 400 + t]
    values[column][np.arange(t.size) % 9 // 2 == 1] = -extreme
    values[column][50:53] = extreme
    write_columns(tmp_path / "run.csv", dict(zip(headings.split(","), values, strict=True)))

    refused(read_recording, tmp_path / "run.csv", RIG, signals=option or NO_MAP)


def test_a_proposal_for_channels_without_clocks_has_the_time() -> None:
    names, tenth = ["Zeit", "Winkel", "M_z", "F_N"], ChannelSamples(values=np.full(9, 0.1))
    named = ChannelFile(names=names, read=lambda _: tenth)
    for own_clocks, time in ((False, "t=Zeit,"), (True, "")):
        file = replace(named, own_clocks=own_clocks)
        message = refused(table_from_channels, PATH, file, REQUIRED_COLUMNS, NO_MAP)
        assert message.endswith(f"--map {time}psi=Winkel,F_N=F_N:kN")


def test_a_ratio_is_a_fraction(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    for sign in ("", "-"):
        path.write_text(f'[signals]\npsi = {{ channel = "Wheel", factor = "{sign}1/14.8" }}')
        assert read_signals(path).of("psi").factor == pytest.approx(float(f"{sign}1") / 14.8)
    signals = parse_signals("psi=-1/14.8*Wheel:deg,M_z=2.5e1/2*Torque,F_N=a/b")

    assert signals.of("psi").factor == pytest.approx(-0.0675676, rel=1e-6)
    assert (signals.of("M_z").factor, signals.of("F_N").channel) == (12.5, "a/b")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("psi", "expected COLUMN=FACTOR*CHANNEL:UNIT"),
        ("psi=", "expected COLUMN=FACTOR*CHANNEL:UNIT"),
        ("phi=A", "'phi' is no column of a recording; allowed: t, psi"),
        ("psi=A:parsec", "'parsec' is no unit of psi; allowed: rad, mrad, deg, rev"),
        ("psi=A,psi=B", "psi is given twice"),
        ("psi=0*A", "factor must be finite and not 0"),
        ("psi=1e999*A", "factor must be finite"),
        ("psi=1/0*A", "factor must be finite"),
        ("psi=1e13*A", "factor must be finite and not 0, from 1e-12 to 1e+12"),
        ("psi=A,dbc=car\0.dbc", "dbc must be the name of a file"),
        ("F_N=Load:MN", "'MN' is no unit of F_N"),
    ],
)
def test_faults_of_a_map(text: str, fault: str) -> None:
    assert fault in refused(parse_signals, text)


@pytest.mark.parametrize(
    ("section", "fault"),
    [
        ("signals = 3", "must be a section"),
        ("[signals]\npsi = 3", "psi needs its channel"),
        ("[signals]\npsi = { unit = 'deg' }", "psi needs its channel"),
        ("[signals]\npsi = { channel = 'A', units = 'deg' }", "psi: unknown 'units'"),
        ("[signals]\npsi = { channel = 'A', factor = '1/0' }", "factor"),
        ("[signals]\npsi = { channel = 'A', factor = 'x' }", "factor must be a number, or a fraction"),
        ("[signals]\npsi = { channel = 'A', unit = 1 }", "unit must be a text"),
        ("[signals]\npsi = { channel = 'A', unit = 'Nm' }", "'Nm' is no unit of psi"),
        ("[signals]\ndbc = 1", "dbc must be the name of a file"),
        ('[signals]\ndbc = "a\\u0000"', "dbc must be the name of a file"),
        (f"[signals]\npsi = {{ channel = 'A', factor = 1{'0' * 400} }}", "a number too large"),
    ],
)
def test_faults_of_a_section(section: str, fault: str, tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(section)
    message = refused(read_signals, path)
    assert message.startswith(str(path))
    assert fault in message


@pytest.mark.parametrize(
    ("column", "unit", "factor"),
    [
        ("t", "ms", 1e-3), ("t", "[µs]", 1e-6), ("psi", "°", math.pi / 180),
        ("psi", "Deg", math.pi / 180),
        ("psi_dot", "deg/s", math.pi / 180), ("psi_dot", "1/min", math.pi / 30), ("M_z", "Nm", 1.0),
        ("M", "N·m", 1.0), ("M", "N.m", 1.0), ("M", "kN*m", 1e3), ("M", "mNm", 1e-3), ("M", "MNm", None),
        ("M", "ft lb", 0.3048 * 0.45359237 * 9.80665), ("F_N", "lbf", 0.45359237 * 9.80665),
        ("F_N", "", 1.0), ("psi", "s", None), ("M", "Ncm", 1e-2),
        *(("M_z", unit, 1e-3) for unit in ("Nmm", "N·mm", "[N mm]", "mNm")),
    ],
)  # fmt: skip
def test_units(column: str, unit: str, factor: float | None) -> None:
    found = factor_of(column, unit)
    assert found == (None if factor is None else pytest.approx(factor, rel=1e-12))


def test_a_data_frame_becomes_a_recording() -> None:
    pandas = pytest.importorskip("pandas", reason="needs brushgrip[pandas]")
    frame = pandas.DataFrame(ROWS, columns=["t", "Steer [deg]", "Mz", "F_N [kN]"])

    read = Recording.from_dataframe(frame, RIG, name="run", signals="psi=0.06*Steer,M_z=-Mz")

    require_expected(read, 0.06, -1)
    assert read.name == "run"
    message = refused(Recording.from_dataframe, frame, RIG, name="run", signals="psi=Steer")
    assert message.startswith("run: channel M_z missing; there are t, Steer")


def table_of(**channels: ChannelSamples) -> Table:
    file = ChannelFile(names=list(channels), read=channels.__getitem__)
    return table_from_channels(PATH, file, REQUIRED_COLUMNS, NO_MAP)


def line(start: float, step: float, size: int, slope: float = 1.0) -> ChannelSamples:
    times = start + step * np.arange(size)
    return ChannelSamples(values=slope * times, times=times)


def test_a_slower_angle_is_interpolated_at_the_torque() -> None:
    columns = table_of(psi=line(5, 0.02, 60), M_z=line(5.003, 0.01, 100), F_N=line(5, 0.1, 12)).columns

    np.testing.assert_allclose(columns["t"], 0.01 * np.arange(100), atol=1e-12)
    np.testing.assert_allclose(columns["psi"], columns["M_z"], rtol=1e-12)
    np.testing.assert_allclose(columns["F_N"], columns["M_z"], rtol=1e-12)


def test_no_torque_is_made_up_where_the_angle_is_faster() -> None:
    columns = table_of(psi=line(0, 0.01, 101), M_z=line(0, 0.1, 11), F_N=line(0, 0.1, 11)).columns

    assert columns["t"].size == 101
    assert np.isfinite(columns["M_z"]).sum() == 11
    np.testing.assert_allclose(columns["psi"], columns["t"], atol=1e-12)


def test_a_gap_is_not_bridged() -> None:
    angle = line(0, 0.01, 100)
    keep = np.abs(np.asarray(angle.times) - 0.5) > 0.1
    with_gap = ChannelSamples(values=angle.values[keep], times=np.asarray(angle.times)[keep])
    columns = table_of(psi=with_gap, M_z=line(0, 0.01, 100), F_N=line(0, 0.01, 100)).columns

    inside = np.abs(columns["t"] - 0.5) < 0.09
    assert np.isnan(columns["psi"][inside]).all()
    assert np.isfinite(columns["psi"][np.abs(columns["t"] - 0.5) > 0.12]).all()


def test_times_increase() -> None:
    back = ChannelSamples(values=np.zeros(3), times=np.array([0.0, 2.0, 1.0]))
    whole = line(0, 1, 3)
    assert "the times of M_z must increase" in refused(table_of, psi=whole, M_z=back, F_N=whole)


def test_names_are_resolved_by_their_last_part_or_asked_for() -> None:
    names = ["Rig/Angle [deg]", "Rig/Mz", "Car/Mz"]
    assert match_channel("run.mf4", "Angle", names) == "Rig/Angle [deg]"
    assert match_channel("run.mf4", "Car/Mz", names) == "Car/Mz"
    assert match_channel("run.mf4", "z", names) is None
    assert "'Mz' may be Rig/Mz, Car/Mz" in refused(match_channel, "run.mf4", "Mz", names)
