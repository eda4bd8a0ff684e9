import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from brushgrip.inputs.command_inputs import locate_inputs
from brushgrip.live.adviser import Adviser
from brushgrip.live.last_usable import LastUsable
from brushgrip.live.row_estimation import Point, WheelRowEstimator
from brushgrip.live.session import OLD, Session
from brushgrip.live.session_state import line_of, usability_of
from brushgrip.live.timestamps import TimestampFilter, arrival
from observers import Ekf, Status, SteeringLimits
from observers.protocol import prior_estimate
from symbolic import InvalidInputError, Model, Rig
from tests.brushgrip.helpers import Run
from tests.brushgrip.live.sessions import (
    RECORDINGS,
    RIG,
    ListSource,
    estimated,
    rows_of,
    run_to_end,
    same_to_the_last_digit,
    session_of,
)
from tests.processes import wait_for
from tests.simulated_car import SimulatedCar, steering, vehicle_text

pytest.importorskip("pyarrow", reason="needs brushgrip[live]")
pytestmark = pytest.mark.usefixtures("interpreted")
OBSERVER = Ekf(model=Model(), values={"k": 2.4e6}, rig=Rig(a=0.045, e=0.009))


def session_over(rows: list[dict[str, float]], observer: str, record: Path) -> Session:
    """A session on rows that are all there at once."""
    session = session_of("udp:5005", observer, record=record)
    session._open = lambda: ListSource(rows)
    return session


def spoilt(rows: list[dict[str, float]]) -> list[dict[str, float]]:
    """The rows with gaps, values beyond their range and samples out of order."""
    rows = [dict(row) for row in rows]
    for at, column, value in (
        (160, "psi", math.nan), (170, "F_N", math.nan), (171, "F_N", -5.0), (172, "F_N", 0.0),
        (180, "M_z", math.nan), (190, "M_z", 1e9), (200, "psi", math.inf), (210, "M_z", -math.inf),
        (0, "psi", math.nan), (1, "F_N", math.nan), (220, "t", 1e9), (230, "t", math.nan),
        (240, "t", 0.3),
    ):  # fmt: skip
        rows[at][column] = value
    return [*rows[:250], rows[249], rows[245], *rows[250:]]


@pytest.mark.parametrize(
    ("observer", "spoil"),
    [
        ("ekf", True),
        *(pytest.param(*case, marks=pytest.mark.long) for case in (("ekf", False), ("mhe", False))),
        pytest.param("mhe", True, marks=pytest.mark.long),
    ],
)
def test_says_what_estimate_says_of_the_recording(tmp_path: Path, observer: str, spoil: bool) -> None:
    rows = spoilt(rows_of(320)) if spoil else rows_of(320)
    session = session_over(rows, observer, tmp_path / "live.parquet")
    run_to_end(session)

    assert session.recorded == [tmp_path / "live.parquet"]
    same_to_the_last_digit(session, estimated(tmp_path / "live.parquet", observer))
    counts = session.state().counts
    if spoil:
        assert counts == {
            "samples": 322, "without a torque": 5, "out of range": 5, "late": 2, "wrong time": 3,
        }  # fmt: skip
        assert session.ring.end == 322 - 2 - 3 - 2
    else:
        assert counts == {"samples": 320}


def test_a_measured_rate_and_a_steering_torque(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG.read_text().replace("[rig]", "[rig]\nJ_A = 0.15\nb_t = 1.0"))
    rows = rows_of(300)
    for before, row in zip([rows[0], *rows], rows, strict=False):
        row["psi_dot"] = (row["psi"] - before["psi"]) / 0.01
        row["M"] = -row.pop("M_z")
    rows[200]["psi_dot"] = math.nan
    session = session_of("udp:5005", record=tmp_path / "live.parquet", rig=rig)
    session._open = lambda: ListSource(rows)
    run_to_end(session)

    inputs = locate_inputs([str(tmp_path / "live.parquet")], rig=rig)
    assert session.estimator.columns == ("t", "psi", "F_N", "M", "psi_dot")
    same_to_the_last_digit(session, estimated(tmp_path / "live.parquet", inputs=inputs))


@pytest.mark.long
def test_a_car_that_stands_rolls_and_brakes(tmp_path: Path) -> None:
    vehicle = tmp_path / "car.toml"
    vehicle.write_text(vehicle_text())
    t, rack = steering(seconds=6.0)
    force, speed, brake = SimulatedCar().force(rack), np.zeros(t.size), np.ones(t.size)
    speed[:5], speed[5:15], speed[100:140], speed[145:180] = np.nan, 2.0, 3.0, 3.0
    brake[300:] = 0.0
    rack[150] = rack[200] = force[210] = np.nan
    columns = {"t": t, "rack": rack, "F_rack": force, "speed": speed, "brake": brake}
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    rows = [dict(zip(columns, row, strict=True)) for row in values]
    session = session_of("udp:5005", record=tmp_path / "car.parquet", rig=None, vehicle=vehicle)
    session._open = lambda: ListSource(rows)
    run_to_end(session)

    inputs = locate_inputs([str(tmp_path / "car.parquet")], vehicle=vehicle)
    same_to_the_last_digit(session, estimated(tmp_path / "car.parquet", inputs=inputs))
    held = session.ring.since(0).of("status") == Status.HELD
    assert np.array_equal(np.flatnonzero(held[:300]), [*range(15), *range(100, 180)])


@pytest.mark.long
def test_a_car_whose_force_has_the_other_sign_is_never_usable(tmp_path: Path) -> None:
    vehicle = tmp_path / "car.toml"
    vehicle.write_text(vehicle_text())
    t, rack = steering(seconds=6.0)
    columns = {"t": t, "rack": rack, "F_rack": -SimulatedCar().force(rack)}
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    rows = [dict(zip(columns, row, strict=True)) for row in values]
    session = session_of("udp:5005", rig=None, vehicle=vehicle)
    session._open, session._looked = lambda: ListSource(rows), -math.inf
    run_to_end(session)
    session._looked = -math.inf
    session._look_back()

    assert "rack and F_rack have opposite signs" in session.state().status
    assert not session.state().usable
    session = session_of("udp:5005", rig=None, vehicle=vehicle)
    session._open = lambda: ListSource([{"t": 0.0, "rack": 0.0, "T_bar": 1.0, "T_motor": 1.0}] * 3)
    run_to_end(session)
    assert "T_motor, and motor_ratio of the vehicle go together" in session.state().status
    assert not session.ring.end


def test_a_source_that_dies_comes_back_and_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("brushgrip.live.session.AGAIN", 0.01)
    rows = rows_of(320)
    parts = iter([ListSource(rows[:300], OSError), OSError("not yet"), ListSource(rows[50:])])

    def open_source() -> ListSource:
        if isinstance(part := next(parts), Exception):
            raise part
        return part

    session = session_of("udp:5005", record=tmp_path / "live.parquet")
    session._open = open_source
    run_to_end(session)

    assert [path.name for path in session.recorded] == ["live.parquet", "live_2.parquet"]
    assert session.state().counts == {"samples": 570, "reopened": 1, "begun anew": 1}
    same_to_the_last_digit(session, estimated(tmp_path / "live_2.parquet"))


@pytest.mark.long
@pytest.mark.parametrize("at", range(200, 1300, 100))
def test_what_begins_twisted_is_not_usable_and_wrong(at: int) -> None:
    # The source died while the wheel stood turned: the torque there is not that of an untwisted patch.
    session = session_over(rows_of(2000, at), "ekf", Path("none"))
    session._wanted = False
    run_to_end(session)
    points = session.ring.since(0)
    usable = points.of("usable") == 1
    whole = estimated(RIG.with_name("train_a.csv"))
    reference = whole.mu_eff[whole.usable].mean()
    off = np.abs(points.of("mu_eff") - reference) / np.maximum(points.of("mu_eff_std"), 0.02 * reference)

    assert not (usable & (off > 4)).any(), (reference, points.of("mu_eff")[usable][:5])


def test_says_that_the_first_sample_waits_for_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    session, compiled = session_over(rows_of(20), "ekf", Path("none")), Event()
    session._wanted, estimate = False, WheelRowEstimator.__call__

    def waiting(self: WheelRowEstimator, row: dict[str, float]) -> list[Point]:
        compiled.wait()
        return estimate(self, row)

    monkeypatch.setattr(WheelRowEstimator, "__call__", waiting)
    assert line_of(session.state()) == "no sample has come yet"
    session.start()
    wait_for(lambda: session.state().counts.get("samples"))
    wait_for(lambda: line_of(session.state()) == "compiling the observer")
    compiled.set()
    wait_for(lambda: session.state().ended)
    session.stop()
    assert line_of(session.state()).startswith("0.19 s: ")


def test_a_torque_of_the_other_sign_is_told_with_the_sign_that_is_expected() -> None:
    session = session_over([row | {"M_z": -row["M_z"]} for row in rows_of(600)], "ekf", Path("none"))
    session._wanted = False
    run_to_end(session)

    (cause,) = session.estimator.suspicions
    assert "M_z is the moment of the ground on the wheel, negative for a first turn to posit" in cause


@pytest.mark.long
def test_an_old_estimate_is_not_usable(monkeypatch: pytest.MonkeyPatch) -> None:
    session = session_over(rows_of(1400), "ekf", Path("none"))
    session._wanted = False
    run_to_end(session)
    usable = np.flatnonzero(session.ring.since(0).of("usable") == 1)
    assert usable.size
    # As of a source that falls silent.
    session._ended = False
    session._newest = session._newest and type(session._newest)(
        mu=1.0, mu_std=0.01, M_z_predicted=0.0, informed=True
    )
    done = session._came
    monkeypatch.setattr("brushgrip.live.session.arrival", lambda: done + 0.9 * OLD)
    assert session.state().usable
    monkeypatch.setattr("brushgrip.live.session.arrival", lambda: done + 1.1 * OLD)
    assert not session.state().usable
    assert session.state().status == "no sample for 1 s"


def test_an_observer_behind_its_source_says_nothing_usable(monkeypatch: pytest.MonkeyPatch) -> None:
    session = session_over(rows_of(400), "ekf", Path("none"))
    session._wanted = False
    own = session.estimator
    taken: list[float] = []

    def slow(row: dict[str, float]) -> list[Point]:
        if 20 < len(taken) < 200:
            time.sleep(0.01)
        taken.append(row["t"])
        return own(row)

    monkeypatch.setattr(session, "estimator", slow)
    for name in ("columns", "suspicions", "implausible", "reset", "weaker", "note"):
        monkeypatch.setattr(slow, name, getattr(own, name), raising=False)
    session.start()
    wait_for(lambda: len(taken) > 30)
    session._newest = session._newest and replace(session._newest, status=Status.USED, informed=True)
    wait_for(lambda: len(taken) > 120)
    state = session.state()
    session.stop()

    assert state.age > OLD
    assert not state.usable
    assert "s behind the source" in state.status


def test_a_rate_of_the_other_sign_is_never_usable(tmp_path: Path) -> None:
    rows = rows_of(1400)
    rate = np.gradient([row["psi"] for row in rows], 0.01)
    for row, psi_dot in zip(rows, rate.tolist(), strict=True):
        row["psi_dot"] = -psi_dot
    session = session_over(rows, "ekf", tmp_path / "run.parquet")
    run_to_end(session)
    state = session.state()

    assert "psi_dot is -1 times the derivative of psi" in state.status
    assert "friction was never usable" in state.status
    assert "usable" not in state.counts
    with pytest.raises(InvalidInputError, match="psi_dot is -1 times the derivative of psi"):
        estimated(tmp_path / "run.parquet")


def test_a_source_that_cannot_wait_loses_what_is_too_much_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("brushgrip.live.session.MAX_QUEUED_SAMPLES", 100)

    class Flood(ListSource):
        waits = False

        def read(self) -> list:  # type: ignore[type-arg]
            rows, self._rows = self._rows, []
            if not rows:
                raise EOFError
            return rows

    row = rows_of(1)[0]
    flood = [{**row, "t": 1e-3 * at} for at in range(600)]
    session = session_over([], "ekf", Path("none"))
    session._wanted = False
    session._open = lambda: Flood(flood)
    run_to_end(session)

    counts = session.state().counts
    assert (counts["lost"], counts["samples"]) == (500, 100)


def test_recording_begun_later_holds_the_stretch_from_its_beginning(tmp_path: Path) -> None:
    rows = rows_of(400)
    source = ListSource(rows)
    later = source._rows
    source._rows = later[:300]
    source.read, read = lambda: read() if source._rows else [], source.read  # type: ignore[method-assign]
    session = session_over([], "ekf", tmp_path / "late.parquet")
    session._wanted, session._open = False, lambda: source
    session.start()
    wait_for(lambda: session.ring.end == 300)
    session.record(True)
    wait_for(lambda: session.state().recording)
    source._rows = later[300:]
    wait_for(lambda: session.ring.end == 400)
    session.record(False)
    wait_for(lambda: session.recorded)
    session.stop()

    same_to_the_last_digit(session, estimated(tmp_path / "late.parquet"))


def test_a_recording_that_cannot_go_on_does_not_stop_the_estimate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("brushgrip.live.recorder.Recorder.write", full)
    session = session_over(rows_of(30), "ekf", tmp_path / "live.parquet")
    run_to_end(session)

    assert session.ring.end == 30
    assert "the recording broke off: disk full" in session.state().status
    assert session.recorded == []
    assert list(tmp_path.glob("*.parquet")) == []


def test_an_observer_that_fails_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("oops")

    monkeypatch.setattr(WheelRowEstimator, "__call__", fail)
    monkeypatch.setattr("threading.excepthook", lambda *_: None)
    session = session_over(rows_of(30), "ekf", Path("none"))
    session.start()
    wait_for(lambda: "stopped: oops" in session.state().status)
    session.stop()

    assert not session.state().usable


def test_clock() -> None:
    clock = TimestampFilter()
    times = [
        1.7e9,
        1.7e9 + 0.5,
        1.7e9 + 0.5,
        1.7e9 + 0.4,
        5.0,
        1.7e9 + 1.0,
        7.0,
        7.5,
        7.25,
        100.0,
        math.inf,
    ]
    told = [(timed.row["t"], timed.begins) for t in times for timed in clock({"t": t})]

    assert told == [(0.0, True), (0.5, False), (1.0, False), (7.0, True), (7.5, False)]
    assert (clock.late, clock.wrong) == (3, 2)


@pytest.mark.long
def test_the_command_replays_records_and_ends(run: Run, tmp_path: Path) -> None:
    source, out = RIG.with_name("train_a.csv"), tmp_path / "live.parquet"
    outcome = run("live", source, "--rig", RIG, "--speed", 200, "--no-page", "--record", out)

    assert (outcome.status, outcome.err) == (0, "")
    assert f"wrote {out}" in outcome.out
    assert ": μ " in outcome.out
    assert estimated(out).t.size == estimated(source).t.size


def test_a_model_of_another_scale_is_refused(run: Run, tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    model.write_text('{"version": 1, "effects": [], "tyre": {"k": 2.8e7}}')
    run("live", RECORDINGS / "train_a.csv", "--rig", RIG, "--no-page", "--model", model).refused(
        "10 times the declared one"
    )


def test_a_sound_rate_is_sound_after_minutes() -> None:
    t = 0.05 * np.arange(20_000)
    psi, rate = 0.3 * np.sin(np.pi * t), 0.3 * np.pi * np.cos(np.pi * t)
    estimator = WheelRowEstimator(
        lambda _: Ekf(model=Model(), values={"k": 2.4e6}, rig=Rig(a=0.045, e=0.009))
    )
    estimator.columns = ("t", "psi", "F_N", "M_z", "psi_dot")
    still = np.zeros(t.size)

    assert estimator.implausible(np.column_stack([t, psi, still + 400, still, rate])) == ""
    assert "psi_dot" in estimator.implausible(np.column_stack([t, psi, still + 400, still, -rate]))


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("udp:99999", "expected a port from 1 to 65535"),
        ("can:virtual", "expected can:INTERFACE:CHANNEL"),
        ("can:virtual:x", "--dbc names the database"),
        ("replay:nowhere", "no such recording"),
        ("nowhere", "no such recording"),
        ("udp:no.such.host:5005", "the source cannot be opened"),
    ],
)
def test_what_is_no_source_is_refused(run: Run, source: str, words: str) -> None:
    run("live", source, "--rig", RIG, "--no-page").refused(words)


def test_speed_and_rig_are_required(run: Run) -> None:
    recording = RIG.with_name("train_a.csv")
    run("live", recording, "--rig", RIG, "--speed", 0).refused("--speed must be finite")
    run("live", "udp:5005").refused("needs the rig")


def test_nothing_is_read_before_the_page_is_there(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "bokeh", None)
    outcome = run("live", RECORDINGS / "train_a.csv", "--rig", RIG, "--no-browser")

    outcome.refused("the page needs Bokeh; pip install 'brushgrip[live]'")


def test_between_torques_the_last_one_says_what_is_usable() -> None:
    session = session_of("udp:5005")
    known = replace(prior_estimate(OBSERVER), informed=True, status=Status.USED)
    without = replace(known, status=Status.MISSING)
    usable = []
    for step in range(200):
        estimate = known if step % 10 == 0 and step < 100 else without
        session._store([Point((0.01 * step,), 0.0, 1.0, estimate)], arrival())
        usable.append(session.state().usable)

    # Half a second after the last torque nothing is usable any more.
    assert usable == [0.01 * step - 0.9 < OLD for step in range(200)]
    assert session.state().counts == {"without a torque": 190, "usable": 10}


def test_a_flag_between_torques_is_told_at_once() -> None:
    session = session_of("udp:5005")
    known = replace(prior_estimate(OBSERVER), informed=True, status=Status.USED)
    for status in (Status.USED, Status.MISSING | Status.IMPLAUSIBLE):
        session._store([Point((float(status),), 0.0, 1.0, replace(known, status=status))], arrival())

    assert not session.state().usable


def test_advice_is_given_only_where_turning_helps() -> None:
    session = session_of("udp:5005")
    session._adviser = Adviser(0.15, SteeringLimits())
    session._adviser._text = "turn 8° more to the left"
    known = replace(prior_estimate(OBSERVER), informed=True, status=Status.USED)
    for status, is_given in ((Status.USED, True), (Status.INCONSISTENT, False), (Status.USED, True)):
        session._store([Point((0.0,), 0.0, 1.0, replace(known, status=status))], arrival())
        assert ("turn 8°" in line_of(session.state())) == is_given
    session._ended = True
    assert "turn 8°" not in line_of(session.state())


def test_the_weaker_direction_of_a_found_model_is_told_with_every_estimate(tmp_path: Path) -> None:
    (tmp_path / "found.json").write_text(
        '{"version": 1, "effects": ["asymmetric_friction"], "recordings": {},'
        ' "shared": {"k": 2.4e6, "asymmetric_friction.ratio": 0.85}}'
    )
    state = session_of("udp:5005", model=tmp_path / "found.json").state()

    assert state.weaker == pytest.approx(0.15 / 1.85)
    assert line_of(state) == "no sample has come yet"
    told = line_of(replace(state, t=1.0, estimate=prior_estimate(OBSERVER)))
    assert ", not usable; 8 % less turning to positive psi: " in told
    assert session_of("udp:5005").state().note == ""


def test_the_end_of_a_source_is_no_dead_sensor(tmp_path: Path) -> None:
    session = session_over(rows_of(20), "ekf", tmp_path / "live.parquet")
    run_to_end(session)
    state = replace(session.state(), age=60.0)

    assert state.status == "the source has ended: friction was never usable"
    assert usability_of(state) == "ended"
    known = replace(
        prior_estimate(OBSERVER), informed=True, status=Status.USED, mu_eff=0.8, mu_eff_std=0.1
    )
    session._store([Point((1.5,), 0.0, 1.0, known)], arrival())
    assert (
        session.state().status == "the source has ended: friction was 0.80 ± 0.20 at 1.5 s, last usable"
    )


def test_the_end_of_a_source_tells_no_friction_that_what_follows_contradicts() -> None:
    known = replace(prior_estimate(OBSERVER), informed=True, mu_eff=0.8, mu_eff_std=0.1)
    for usable, inconsistent, is_told in ((10, 29, True), (10, 31, False), (0, 5, False)):
        last = LastUsable()
        flags = [Status.USED] * (1 + usable) + [Status.INCONSISTENT] * inconsistent
        for number, status in enumerate(flags):
            seen = replace(known, status=status)
            last.see(number, 0.01 * number, seen, usable=seen.usable)
            # A wheel at rest shows neither.
            last.see(number, 0.01 * number, seen, usable=seen.usable)
        assert last.told.startswith("friction was 0.80 ± 0.20") == is_told
        last.see(99.0, 0.0, replace(known, status=Status.RESET), usable=False)
        assert last.told == "friction is not known since a new ground was noticed at 99 s"
