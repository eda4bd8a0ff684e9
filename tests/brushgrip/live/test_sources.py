import json
import math
import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip.live.can_source import CanSource
from brushgrip.live.mapped_columns import MappedColumns
from brushgrip.live.sources import MAX_LINE_LENGTH, LineParser, LineSource, Source, UdpSource
from brushgrip.live.timestamp_filter import clock_time
from identification import SignalMap, parse_signals
from symbolic import InvalidInputError
from tests.brushgrip.live.bus import DBC, MAP, Bus
from tests.processes import wait_for

JSON_LINE = '{"t": 0.5, "psi": 0.02, "M_z": -0.7, "F_N": 560}'


def read_all(source: Source, count: int) -> list[dict[str, float]]:
    rows: list[Any] = []
    wait_for(lambda: len(rows.extend(source.read()) or rows) >= count)  # type: ignore[func-returns-value]
    assert source.read() == []
    return rows


def columns(text: str = "", *, car: bool = False) -> MappedColumns:
    return MappedColumns("udp:5005", parse_signals(text) if text else SignalMap(), car=car)


@pytest.fixture
def udp() -> Iterator[tuple[UdpSource, socket.socket]]:
    source = UdpSource(("127.0.0.1", 0), columns())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(source._socket.getsockname())
        yield source, sender
    source.close()


def test_units_that_names_end_in_are_taken_and_said_once(caplog: pytest.LogCaptureFixture) -> None:
    values = columns("psi=Angle_deg,M_z=Mz_Nm,F_N=Load_kN")
    for _ in range(2):
        for clock in ("t", "t [ms]"):
            row = values({clock: 500.0, "Angle_deg": 180.0, "Mz_Nm": -0.7, "Load_kN": 0.5})
            assert row["psi"] == pytest.approx(math.pi)
            assert (row["M_z"], row["F_N"]) == (-0.7, 500.0)
    assert [record.getMessage().split(": ")[2] for record in caplog.records] == [
        "Angle_deg in deg", "Load_kN in kN",
    ]  # fmt: skip


@pytest.mark.parametrize("units", ["ms,deg,,kN", "[ms],[°],-,[kN]", "ms;deg;;kN"])
def test_units_below_a_header_are_units(units: str) -> None:
    delimiter = ";" if ";" in units else ","
    parse, of = LineParser(), columns("t=Time,psi=Angle")
    header, row = (line.replace(",", delimiter) for line in ("Time,Angle,M_z,F_N", "500,90,-1,0.56"))
    for _ in range(2):
        assert parse(header) is None
        assert parse(units) is None
        wanted = {"t": 0.5, "psi": math.pi / 2, "M_z": -1.0, "F_N": 560.0}
        assert of(parse(row) or {}) == pytest.approx(wanted)
    # Only there: elsewhere such a row is no number.
    with pytest.raises(ValueError, match="a field is not a number"):
        parse("ms,deg,,kN".replace(",", delimiter))


def test_lines_of_json_and_csv_are_the_same_values() -> None:
    as_json, as_csv, german = LineParser(), LineParser(), LineParser()
    wanted = {"t": 0.5, "psi": 0.02, "M_z": -0.7, "F_N": 560.0}

    assert as_json(JSON_LINE) == wanted
    assert as_csv("t,psi,M_z,F_N") is as_csv("# a comment") is as_csv("") is None
    assert as_csv("0.5,0.02,-0.7,560") == wanted
    assert as_csv("t, M_z") is None
    assert as_csv("1,2") == {"t": 1.0, "M_z": 2.0}
    assert german("t;psi;M_z;F_N") is None
    assert german("0,5;0,02;-0,7;560") == wanted
    assert math.isnan(as_json('{"psi": null, "name": "x", "t": NaN}')["psi"])  # type: ignore[index]


@pytest.mark.parametrize(
    "line",
    ["1,2", "{", "[1]", '{"a": [', "{" * 5000, "t,t", "x" * (MAX_LINE_LENGTH + 1), "1,x",
     '{"t": 1e999999',
     '{"t": ' + "9" * 400 + "}", '{"t": ' + "9" * 6000 + "}", '"', "\0", "[" * 9000, '{"a":' * 1600],
)  # fmt: skip
def test_hostile_lines_are_refused(line: str) -> None:
    values_of = LineParser()
    values_of("t,psi,M_z,F_N")
    with pytest.raises(ValueError, match=r"^.{1,200}"):
        values_of(line)


def test_numbers_without_a_header_are_refused_with_what_is_missing() -> None:
    values_of = LineParser()
    with pytest.raises(ValueError, match="the first line of CSV names the columns"):
        values_of("0.5,0.02,-0.7,560")


def test_datagrams(udp: tuple[UdpSource, socket.socket]) -> None:
    source, sender = udp
    for datagram in (JSON_LINE, "\xff\xfe", "", "t,psi [deg],M_z,F_N\n0.6,90,-1,560\n0.7,x,1,2", "1,2"):
        sender.send(datagram.encode("latin-1"))
    rows = read_all(source, 2)

    assert rows[0] == {"t": 0.5, "psi": 0.02, "M_z": -0.7, "F_N": 560.0}
    assert rows[1] == {"t": 0.6, "psi": pytest.approx(math.pi / 2), "M_z": -1.0, "F_N": 560.0}
    assert source.refused == 3


UNTIMED = '{"psi": 0.03, "M_z": -1, "F_N": 560}'


def test_a_sample_without_a_time_has_that_of_its_arrival_unless_others_have_their_own(
    udp: tuple[UdpSource, socket.socket],
) -> None:
    source, sender = udp
    sender.send(UNTIMED.encode())
    assert read_all(source, 1)[0]["t"] == pytest.approx(clock_time(), abs=5.0)
    sender.send("\n".join([JSON_LINE, UNTIMED, UNTIMED, "psi,M_z,F_N", "0.03,-1,560"]).encode())

    assert [row["t"] for row in read_all(source, 1)] == [0.5]
    assert (source.refused, source.fault) == (3, "no t, which lines before had")


@pytest.mark.parametrize(
    "foreign", ['{"temperature": 20.5}', '{"t": 0.7, "temperature": 20.5}', "{}", "temperature,x\n1,2"]
)
def test_lines_without_a_column_are_no_samples(
    foreign: str, udp: tuple[UdpSource, socket.socket]
) -> None:
    source, sender = udp
    reading, writing = os.pipe()
    lines = f"{JSON_LINE}\n{foreign}\n{foreign}\n{JSON_LINE}\n"
    sender.send(lines.encode())
    os.write(writing, lines.encode())
    for of_lines in (source, LineSource(reading, columns())):
        assert [row["psi"] for row in read_all(of_lines, 2)] == [0.02, 0.02]
        assert of_lines.refused == 2
        assert "no column but a time in" in of_lines.fault
    os.close(reading)
    os.close(writing)


@pytest.mark.skipif(not hasattr(time, "CLOCK_BOOTTIME"), reason="a clock of Linux")
def test_a_sample_without_a_time_has_that_of_a_clock_that_goes_on_in_sleep(
    udp: tuple[UdpSource, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    source, sender = udp
    monkeypatch.setattr("time.clock_gettime", lambda clock: 3600.0 * (clock == time.CLOCK_BOOTTIME))
    sender.send(b'{"psi": 0.02, "M_z": -0.7, "F_N": 560}')

    assert [row["t"] for row in read_all(source, 1)] == [3600.0]


def test_columns_by_a_map_and_what_is_missing() -> None:
    mapped = columns("psi=Steer:deg,t=time:ms,M_z=-Mz,F_N=Load:kN")
    assert mapped({"Steer": 180.0, "time": 20.0, "Mz": 3.0, "Load": 0.5, "x": 1.0}) == {
        "t": 0.02, "psi": math.pi, "M_z": -3.0, "F_N": 500.0,
    }  # fmt: skip
    assert mapped({"time": 30.0, "Load": 0.4}) == {"t": 0.03, "F_N": 400.0}
    missing = r"M_z, F_N missing; .*; say which is which, such as --map M_z=Moment"
    with pytest.raises(InvalidInputError, match=missing):
        columns()({"t": 1.0, "psi": 2.0, "Moment": 3.0})
    car = columns(car=True)({"t": 1.0, "handwheel": 0.5, "T_bar": 2.0, "speed": 0.0, "psi": 9.0})
    assert car == {"t": 1.0, "handwheel": 0.5, "T_bar": 2.0, "speed": 0.0}


def test_lines_of_standard_input_until_its_end() -> None:
    reading, writing = os.pipe()
    source = LineSource(reading, columns())
    os.write(writing, b"t,psi,M_z,F_N\n0.1,0,0,56")
    assert source.read() == []
    os.write(writing, b"0\n0.2,0,0,560")
    assert read_all(source, 1) == [{"t": 0.1, "psi": 0.0, "M_z": 0.0, "F_N": 560.0}]
    os.close(writing)
    assert [row["t"] for row in source.read()] == [0.2]
    with pytest.raises(EOFError):
        source.read()
    os.close(reading)


@pytest.fixture
def can_bus(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[tuple[CanSource, Bus]]:
    """A source on a bus of its own, by the database and the map given, else the usual ones."""
    pytest.importorskip("cantools", reason="needs brushgrip[live]")
    database, signals = getattr(request, "param", (DBC, MAP))
    (tmp_path / "rig.dbc").write_text(database)
    bus = Bus(interface="virtual", channel=request.node.name, preserve_timestamps=True)
    source = CanSource("virtual", request.node.name, tmp_path / "rig.dbc", columns(signals))
    yield source, bus
    source.close()
    bus.bus.shutdown()


def test_a_sample_of_a_bus_has_angle_and_torque_anew(can_bus: tuple[CanSource, Bus]) -> None:
    source, bus = can_bus
    bus.motion(1.0, 500, 100.0)
    bus.torque(-2.5, 100.004)
    bus.torque(-2.6, 100.005)
    bus.motion(2.0, 501, 100.010)
    bus.torque(-2.7, 100.011)
    bus.torque(-2.8, 100.2)
    rows = read_all(source, 3)

    assert [row["M_z"] for row in rows[:2]] == [-2.5, -2.6]
    np.testing.assert_allclose([row["psi"] for row in rows[:2]], np.radians([1.0, 2.0]), rtol=1e-15)
    assert [row["F_N"] for row in rows] == [500.0, 501.0, 501.0]
    assert math.isnan(rows[2]["psi"])
    assert rows[2]["M_z"] == -2.7
    assert len(rows) == 3


def test_hostile_frames_are_not_used(can_bus: tuple[CanSource, Bus]) -> None:
    source, bus = can_bus
    bus.send(291, b"\1", 1.0)
    bus.send(291, b"\1" * 8, 1.0)
    bus.send(291, b"", 1.0, is_remote_frame=True, dlc=4)
    bus.send(291, b"\1\1\1\1", 1.0, is_extended_id=True)
    bus.send(291, b"\1\1\1\1", 1.0, is_error_frame=True)
    bus.send(999, b"\1\1", 1.0)
    bus.motion(-100.0, 500, 1.0)
    bus.torque(31.0, 1.001)
    bus.send(291, b"\1\0\1\0" + bytes(4), 1.01, is_fd=True)
    bus.torque(1.0, 1.011)
    rows = read_all(source, 2)

    assert source.refused == 2
    assert source.fault == "Motion: 8 bytes, the database has 4"
    assert math.isnan(rows[0]["psi"])
    assert math.isnan(rows[0]["M_z"])
    assert rows[1]["psi"] == pytest.approx(math.radians(0.01))
    assert rows[1]["M_z"] == 1.0


MULTIPLEXED = """VERSION ""
NS_ :
BS_:
BU_: rig
BO_ 291 Wheel: 3 rig
 SG_ Which M : 0|8@1+ (1,0) [0|2] "" rig
 SG_ Angle m0 : 8|16@1- (0.0001,0) [-3|3] "rad" rig
 SG_ Mz m1 : 8|16@1- (0.001,0) [-30|30] "Nm" rig
 SG_ Load m2 : 8|16@1+ (1,0) [0|10000] "N" rig
"""


@pytest.mark.parametrize("can_bus", [(MULTIPLEXED, "psi=Angle,M_z=Mz,F_N=Load")], indirect=True)
def test_multiplexed_signals_of_a_message_make_a_sample(can_bus: tuple[CanSource, Bus]) -> None:
    source, bus = can_bus
    for at in range(3):
        for which, value in ((2, 400 + at), (0, 1000 * at), (1, -500 * at)):
            data = bytes([which]) + (value % 65536).to_bytes(2, "little")
            bus.send(291, data, 1 + 0.01 * at + 0.001 * which)
    rows = read_all(source, 3)

    assert [(row["F_N"], row["M_z"]) for row in rows] == [(400.0, 0.0), (401.0, -0.5), (402.0, -1.0)]
    np.testing.assert_allclose([row["psi"] for row in rows], [0.0, 0.1, 0.2], rtol=1e-15)


ANOTHER = 'BO_ 293 Motion2: 2 rig\n SG_ Angle2 : 0|16@1- (0.01,0) [0|0] "deg" rig\n'
APART = DBC.replace("BO_ 292", f"{ANOTHER}BO_ 292")


@pytest.mark.parametrize("can_bus", [(APART, "psi=Angle2,M_z=Torque.Mz,F_N=Load")], indirect=True)
def test_a_load_that_comes_no_more_takes_the_torque_with_it(can_bus: tuple[CanSource, Bus]) -> None:
    source, bus = can_bus

    def sample(t: float) -> None:
        bus.send(293, b"\1\0", t)
        bus.torque(-1.0, t + 0.001)

    for at in range(30):
        if at % 3 == 0:
            bus.motion(0.0, 500, 1 + 0.1 * at)
        sample(1 + 0.1 * at)
    rows = read_all(source, 30)
    assert {(row["M_z"], row["F_N"]) for row in rows} == {(-1.0, 500.0)}
    for t in (5.6, 5.8):
        sample(t)
    kept, silent = read_all(source, 2)
    assert (kept["M_z"], kept["F_N"]) == (-1.0, 500.0)
    assert (source.refused, source.fault) == (1, "F_N came no more")
    assert math.isnan(silent["M_z"])
    assert math.isnan(silent["F_N"])
    bus.motion(0.0, 501, 6.0)
    sample(6.0)
    (again,) = read_all(source, 1)
    assert (again["M_z"], again["F_N"]) == (-1.0, 501.0)


def test_a_bus_that_is_not_there_and_a_database_that_lacks_a_signal() -> None:
    pytest.importorskip("can", reason="needs brushgrip[live]")
    Path("rig.dbc").write_text(DBC)
    with pytest.raises(OSError, match="can:nothing:x"):
        CanSource("nothing", "x", Path("rig.dbc"), columns(MAP))
    with pytest.raises(InvalidInputError, match=r"psi missing; say which is which.*psi=Motion\.Angle"):
        CanSource("virtual", "x", Path("rig.dbc"), columns("F_N=Load,M_z=Mz"))


def test_json_of_every_number_is_read_to_the_last_digit() -> None:
    values = np.random.default_rng(1).normal(size=200).tolist()
    assert [LineParser()(json.dumps({"a": v})) for v in values] == [{"a": v} for v in values]
