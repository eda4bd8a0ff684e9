"""What a recording takes of a map: one of several maps, units that names end in, the steering ratio."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, SignalSource, read_recording, read_signals
from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.map_for_recording import (
    add_unit_by_name,
    choose_map_for_channels,
    with_steering_ratio,
)
from identification.reading.rigfile import signals_section
from identification.reading.signal_map import SignalMap, parse_maps, parse_signals
from identification.reading.units import unit_at_end
from symbolic import Rig, Tyre
from tests.columns import write_columns
from tests.refusal import refused

RIG = (Rig(a=0.045, e=0.009), Tyre(k=2.4e6))
T = 0.01 * np.arange(40)
PSI, TORQUE, LOAD = 0.3 * np.sin(9 * T), -3 * np.cos(9 * T), 500 + T
CSV = "t=Zeit_ms:ms,psi=Winkel:deg,M_z=Moment,F_N=Last"
LOG = "t=Time,psi=Angle,M_z=-Moment,F_N=Load"


def write(path: Path, **columns: np.ndarray) -> Path:
    return write_columns(path, columns)


def require_expected(read: Recording) -> None:
    for values, expected in ((read.t, T), (read.psi, PSI), (read.M_z, TORQUE), (read.F_N, LOAD)):
        np.testing.assert_allclose(values, expected, atol=1e-9)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    return (
        write(tmp_path / "a.csv", Zeit_ms=1e3 * T, Winkel=np.degrees(PSI), Moment=TORQUE, Last=LOAD),
        write(tmp_path / "b.csv", Time=T, Angle=PSI, Moment=-TORQUE, Load=LOAD),
    )


@pytest.mark.parametrize("order", [1, -1])
def test_a_recording_takes_the_map_whose_channels_it_has(order: int, files: tuple[Path, Path]) -> None:
    signals = parse_maps([CSV, LOG][::order])
    for path in files:
        require_expected(read_recording(path, RIG, signals=signals))


def test_sections_of_a_rig_file_are_maps_of_recordings(files: tuple[Path, Path], tmp_path: Path) -> None:
    signals = parse_maps([CSV, f"{LOG},dbc={tmp_path / 'car.dbc'}"])
    rig = tmp_path / "rig.toml"
    rig.write_text(f"[rig]\na = 0.045\ne = 0.009\n[tyre]\nk = 2.4e6\n{signals_section(signals)}")
    assert read_signals(rig) == signals
    assert {one.dbc for one in signals.alternatives} == {tmp_path / "car.dbc"}
    for path in files:
        require_expected(read_recording(path, rig))
    below = read_signals(rig).updated(parse_signals("F_N=Load:kN"))
    assert [one.of("F_N").unit for one in below.alternatives] == ["kN", "kN"]
    assert [one.of("psi").channel for one in below.alternatives] == ["Winkel", "Angle"]


def test_a_whole_map_stands_alone_beside_the_sections_of_a_rig_file() -> None:
    of_file = parse_maps([CSV, LOG, "t=Time_us,psi=Steer,psi_dot=Rate,F_N=Fz"])
    whole = parse_signals(LOG)

    assert of_file.updated(whole) == whole
    # Below a single section, and where it is not whole, it stands beside what it leaves open.
    assert parse_signals("psi_dot=Rate").updated(whole).of("psi_dot").channel == "Rate"
    assert len(of_file.updated(parse_signals("M_z=Moment")).alternatives) == 3
    alike = parse_maps([LOG, LOG.replace("Load", "Last")])
    assert len(alike.updated(parse_signals("F_N=Load")).alternatives) == 1


def test_options_with_other_columns_are_one_map() -> None:
    assert parse_maps(["psi=A", "F_N=B:kN"]) == parse_signals("psi=A,F_N=B:kN")
    loads = [one.of("F_N").channel for one in parse_maps(["psi=A", "F_N=B", "psi=C"]).alternatives]
    assert loads == ["B", "F_N"]
    assert "dbc is given twice" in refused(parse_maps, ["dbc=a", "dbc=b"])
    assert parse_maps(["psi=A", "psi=B"]).to_dict()["others"] == [parse_signals("psi=B").to_dict()]


def test_a_recording_with_names_of_its_own_needs_no_map() -> None:
    names, own = ("t", "psi", "M_z", "F_N"), parse_signals("psi=psi")
    signals = parse_maps(["psi=1/15*Lenkrad:deg,M_z=Moment", "psi=Angle"])

    assert choose_map_for_channels("a", signals, names) == parse_signals("psi=psi,F_N=F_N")
    assert choose_map_for_channels("a", signals, (*names, "Angle")).of("psi").channel == "Angle"
    # What the map says of a column under its own name holds, so that this file is none of its own.
    in_kN = parse_signals("psi=Winkel,F_N=F_N:kN")
    assert choose_map_for_channels("a", in_kN, names) == in_kN
    assert choose_map_for_channels("a", signals, names[1:]).of("psi").channel in {"Lenkrad", "Angle"}
    assert choose_map_for_channels("a", own, names) == own
    with_ratio = replace(parse_signals("psi=Angle"), steering_ratio=15.0)
    assert choose_map_for_channels("a", with_ratio, names) == with_ratio


@pytest.mark.parametrize("given", [[], ["M_z=Moment"]])
def test_a_proposal_keeps_own_names_before_the_rig_files_maps(given: list[str], tmp_path: Path) -> None:
    of_rig, path = parse_maps([CSV, "psi=1/15*Lenkrad:deg,M_z=kNm:kNm,F_N=Fz"]), tmp_path / "run.csv"
    write(path, t=T, psi=PSI, Moment=TORQUE, F_N=LOAD)
    message = refused(read_recording, path, RIG, signals=of_rig.updated(parse_maps(given)))
    pasted = of_rig.updated(parse_maps([message.partition("--map ")[2]]))

    require_expected(read_recording(path, RIG, signals=pasted))


def test_a_recording_that_fits_several_maps_or_none_is_refused(
    files: tuple[Path, Path], tmp_path: Path
) -> None:
    message = refused(read_recording, files[1], RIG, signals=parse_maps([LOG, "t=Time,psi=Angle:deg"]))
    both = "several maps fit, t=Time,psi=Angle,M_z=-Moment,F_N=Load and t=Time,psi=Angle:deg; join"
    assert both in message
    path = write(tmp_path / "c.csv", Time=T, Winkel=PSI, Moment=TORQUE, Load=LOAD)
    message = refused(read_recording, path, RIG, signals=parse_maps([CSV, LOG]))
    assert "channel psi (as 'Angle') missing" in message
    assert message.endswith("--map t=Time,psi=Winkel,M_z=-Moment,F_N=Load")


@pytest.mark.parametrize(
    ("column", "name", "unit"),
    [
        ("t", "Zeit_ms", "ms"), ("t", "t_us", "us"), ("t", "t_m_s", "s"), ("t", "tms", ""),
        ("psi", "delta_deg", "deg"), ("psi", "Rig.Angle deg", "deg"), ("psi", "psi_dot", ""),
        ("psi", "Angle_ms", ""), ("psi", "steer_N", ""), ("psi", "_deg", ""),
        ("F_N", "Radlast_kN", "kN"), ("F_N", "F_N_kN", "kN"), ("F_N", "F_N", "N"), ("F_N", "F_N_m", ""),
        ("F_N", "Load_g", ""), ("F_N", "Load_MN", ""),
        ("M_z", "torque_Nm", "Nm"), ("M_z", "torque_kN_m", "kNm"), ("M_z", "M_z", ""),
        ("t", "t", ""), ("M_z", "T_N", ""), ("M_z", "F_N_m", "Nm"),
        ("M_z", "kN_m", ""), ("M_z", "T_MNm", ""), ("M_z", "T_mNm", "mNm"),
        ("psi_dot", "yaw_deg_s", "deg/s"), ("psi_dot", "yaw_s", ""), ("speed", "v_km_h", "km/h"),
        ("rack", "s_m", "m"), ("F_rack", "F_rack_kN", "kN"), ("brake", "brake_1", ""),
    ],
)  # fmt: skip
def test_the_unit_that_a_name_ends_in(column: str, name: str, unit: str) -> None:
    assert unit_at_end(column, name) == unit


def test_units_of_names_are_read_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    names = {"Zeit_ms": 1e3 * T, "delta_deg": np.degrees(PSI), "torque_Nm": TORQUE, "F_N_kN": LOAD / 1e3}
    path = write(tmp_path / "run.csv", **names)
    signals = "t=Zeit_ms,psi=delta_deg,M_z=torque_Nm,F_N=F_N_kN"
    require_expected(read_recording(path, RIG, signals=signals))
    assert "Zeit_ms in ms, delta_deg in deg, F_N_kN in kN: units by the names" in caplog.text
    assert "torque_Nm" not in caplog.text

    caplog.clear()
    mapped = signals.replace("_kN", "_kN:N").replace("delta_deg", "delta_deg:deg")
    assert read_recording(path, RIG, signals=mapped).F_N[0] == pytest.approx(0.5)
    assert "Zeit_ms in ms: units" in caplog.text


def test_units_that_the_file_gives_are_said_where_they_are_not_si(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    names = {
        "Zeit [s]": T,
        "Winkel [deg]": np.degrees(PSI),
        "Moment [Nm]": TORQUE,
        "Last [kN]": LOAD / 1e3,
    }
    path = write(tmp_path / "run.csv", **names)
    require_expected(read_recording(path, RIG, signals="t=Zeit,psi=Winkel,M_z=Moment,F_N=Last"))

    assert "Winkel in deg, Last in kN: units as the file gives them" in caplog.text


def test_units_in_brackets_go_before_those_of_names_and_count_in_every_format(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path / "run.csv", **{"t": T, "steer_deg [rad]": PSI, "M_z": TORQUE, "F_N": LOAD})
    np.testing.assert_allclose(read_recording(path, RIG, signals="psi=steer_deg").psi, PSI)
    assert "steer_deg in rad as the file says, not in deg" in caplog.text
    columns = {"t (ms)": 1e3 * T, "psi [deg]": np.degrees(PSI), "M_z [raw]": TORQUE, "F_N": LOAD}
    file = ChannelFile(names=[*columns], read=lambda name: ChannelSamples(values=columns[name]))
    table = table_from_channels(Path("run.parquet"), file, ("t", "psi", "M_z", "F_N"), SignalMap())
    np.testing.assert_allclose(table.columns["psi"], PSI, atol=1e-12)
    np.testing.assert_allclose(table.columns["t"], T, atol=1e-12)


@pytest.mark.parametrize("name", ["t_min", "t_h", "psi_rev", "psi_grad", "F_lb"])
def test_an_end_that_may_be_a_word_is_no_unit_and_that_is_said(name: str) -> None:
    column = {"t": "t", "psi": "psi", "F": "F_N"}[name.split("_")[0]]
    taken = {"t": "s", "psi": "rad", "F_N": "N"}[column]
    source, said = add_unit_by_name(column, SignalSource(channel=name), "")
    assert source.unit is None
    assert said == f"{name} in {taken}, not in {name.split('_')[1]}"


def test_a_factor_that_may_hold_the_unit_is_asked_about(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", t=T, steer_deg=15 * np.degrees(PSI), M_z=TORQUE, F_N=LOAD)
    message = refused(read_recording, path, RIG, signals="psi=1/15*steer_deg")
    asked = (
        "is deg the unit of steer_deg, or in the factor already? Write --map 'psi=1/15*steer_deg:deg'"
    )
    assert asked in message
    assert message.endswith("--map 'psi=1/15*steer_deg:rad'")
    for mapped in ("psi=1/15*steer_deg:deg", f"psi={math.pi / 180 / 15:.17f}*steer_deg:rad"):
        require_expected(read_recording(path, RIG, signals=mapped))


def test_a_proposed_map_is_whole_and_without_the_ratio_that_was_given(tmp_path: Path) -> None:
    columns = {"Zeit": 1e3 * T, "Lenkrad": 600 * np.sin(9 * T), "Moment": TORQUE, "Last": LOAD / 1e3}
    path, mapped = write(tmp_path / "run.csv", **columns), "t=Zeit,psi=Lenkrad,M_z=Moment,F_N=Last"
    message = refused(read_recording, path, RIG, signals=mapped)
    assert "--map 't=Zeit:ms,psi=1/15*Lenkrad:deg,M_z=Moment,F_N=Last:kN', with your steering" in message

    for names in ("", mapped):
        signals = with_steering_ratio(parse_signals(names), 1.25)
        message = refused(read_recording, path, RIG, signals=signals)
        assert "--map t=Zeit:ms,psi=Lenkrad:deg,M_z=" in message
        assert "with your steering ratio" not in message
    signals = parse_signals("t=Zeit:ms,psi=Lenkrad:deg,M_z=Moment,F_N=Last:kN")
    read = read_recording(path, RIG, signals=with_steering_ratio(signals, 20))
    np.testing.assert_allclose(read.psi, np.radians(30 * np.sin(9 * T)), atol=1e-9)


def test_a_torque_of_the_shaft_is_proposed_with_the_ratio_that_was_given(tmp_path: Path) -> None:
    path = write(tmp_path / "run.csv", time_ms=1e3 * T, Lenkrad=PSI, LenkradMoment=TORQUE, F_N=LOAD)
    signals = with_steering_ratio(SignalMap(), 15.2)
    assert "psi=Lenkrad,M_z=15.2*LenkradMoment" in refused(read_recording, path, RIG, signals=signals)


@pytest.mark.parametrize("ratio", [0.0, -15.0, math.inf, math.nan])
def test_a_steering_ratio_is_finite_and_positive(ratio: float) -> None:
    message = refused(with_steering_ratio, SignalMap(), ratio)
    assert message.startswith("--steering-ratio must be finite and greater than 0")


def test_a_steering_ratio_of_which_of_several_maps_is_asked(tmp_path: Path) -> None:
    hand, wheel = "psi=-Lenkrad_deg,psi_dot=Rate_deg/s", "psi=Rad,M_z=Moment"
    texts = [f"{hand},M_z=M_z", wheel]
    message = refused(with_steering_ratio, parse_maps(texts), 15.0)
    entries = "psi=-1/15*Lenkrad_deg:deg,psi_dot=1/15*Rate_deg/s:deg/s"
    assert "which of them is the steering wheel's is not known" in message
    assert message.endswith(f"into the map of that channel alone: {entries} or psi=1/15*Rad")

    path = write(tmp_path / "run.csv", t=T, Lenkrad_deg=-15 * np.degrees(PSI), M_z=TORQUE, F_N=LOAD)
    given = entries.partition(",")[0]
    require_expected(read_recording(path, RIG, signals=parse_maps([f"{given},M_z=M_z", wheel])))

    message = refused(with_steering_ratio, parse_maps(["psi=1/14*Lenkrad", "psi=Rad"]), 15.0)
    assert re.search(r"; Lenkrad has a factor already; .*: psi=1/15\*Rad$", message)
    message = refused(with_steering_ratio, parse_signals("psi_dot=1/15*Rate"), 15.0)
    assert "has a factor for psi_dot already, psi_dot=1/15" in message
    signals = with_steering_ratio(parse_maps(["psi=Lenkrad,M_z=A", "psi=Lenkrad,M_z=B"]), 15.0)
    assert [one.of("psi").ratio for one in signals.alternatives] == [15.0, 15.0]
