import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from brushgrip.live.row_estimation import EstimatedSample, WheelRowEstimator
from brushgrip.live.session import Session
from brushgrip.live.session_state_in_words import LastUsableFriction, state_line, usability_of
from brushgrip.live.steering_adviser import SteeringAdviser
from brushgrip.live.timestamp_filter import TimestampFilter, clock_time
from observers import Ekf, Estimate, Status, SteeringLimits
from observers.protocol import prior_estimate
from observers.quality.when_usable import HOLD
from reference_rig import make_recording
from symbolic import InvalidInputError, Model, Rig
from tests.brushgrip.helpers import Run, write_model
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
from tests.simulated_car import SimulatedCar, steering

pytest.importorskip("pyarrow", reason="needs brushgrip[live]")
pytestmark = pytest.mark.usefixtures("interpreted")
OBSERVER = Ekf(model=Model(), values={"k": 2.4e6}, rig=Rig(a=0.045, e=0.009))
KNOWN = replace(prior_estimate(OBSERVER), informed=True, status=Status.USED, mu_eff=0.8, mu_eff_std=0.1)


def session_over(
    rows: list[dict[str, float]], record: Path | None = None, observer: str = "ekf", **options: Any
) -> Session:
    """A session on rows that are all there at once."""
    session = session_of("udp:5005", observer, record=record, **options)
    session._open = lambda: ListSource(rows)
    return session


def store(session: Session, estimate: Estimate, *, t: float = 0.0, age: float = 0.0) -> None:
    """Puts an estimate in as if its sample had come so long ago."""
    session._store([EstimatedSample((t,), 0.0, 1.0, estimate)], clock_time() - age)


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
def test_says_what_estimate_says_of_the_recording(observer: str, spoil: bool) -> None:
    rows = spoilt(rows_of(320)) if spoil else rows_of(320)
    session = run_to_end(session_over(rows, Path("live.parquet"), observer))

    assert session.recorded == [Path("live.parquet")]
    same_to_the_last_digit(session, estimated(Path("live.parquet"), observer))
    counts = session.state().counts
    if spoil:
        assert counts == {
            "samples": 322, "without a torque": 5, "out of range": 5, "late": 2, "wrong time": 3,
        }  # fmt: skip
        assert session.ring.end == 322 - 2 - 3 - 2
    else:
        assert counts == {"samples": 320}


@pytest.mark.parametrize("name", ["live.mf4", "LIVE.MF4"])
def test_a_recording_in_mdf_is_the_same_with_units(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs brushgrip[mdf]")
    monkeypatch.setattr("brushgrip.live.recorder.GROUP", 100)
    # Times of a file count from its first sample unless it says where they begin.
    session = run_to_end(session_over(spoilt(rows_of(320))[7:], Path(name)))

    assert session.recorded == [Path(name)]
    assert [path.name for path in Path().iterdir()] == [name]
    same_to_the_last_digit(session, estimated(Path(name)))
    with asammdf.MDF(name) as file:
        units = {n: file.get(n).unit for n in ("t", "psi", "F_N", "M_z", "M_slide", "mu_eff")}
        np.testing.assert_array_equal(file.get("mu_eff").timestamps, session.ring.since(0).t)
    assert list(units.values()) == ["s", "rad", "N", "N m", "N m", ""]


def test_a_recording_of_another_format_is_refused_before_the_source_is_opened(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = ("live", "udp:5005", "--rig", RIG, "--no-page", "--record")
    formats = "run.csv: a recording is Parquet or MDF4; end its name in .parquet or .mf4"
    run(*named, "run.csv").refused(formats)
    monkeypatch.setitem(sys.modules, "asammdf", None)
    run(*named, "run.mf4").refused("pip install 'brushgrip[mdf]'")


def test_a_measured_rate_and_a_steering_torque() -> None:
    rig = Path("rig.toml")
    rig.write_text(RIG.read_text().replace("[rig]", "[rig]\nJ_A = 0.15\nb_t = 1.0"))
    rows = rows_of(300)
    for before, row in zip([rows[0], *rows], rows, strict=False):
        row["psi_dot"] = (row["psi"] - before["psi"]) / 0.01
        row["M"] = -row.pop("M_z")
    rows[200]["psi_dot"] = math.nan
    session = run_to_end(session_over(rows, Path("live.parquet"), rig=rig))

    assert session.estimator.columns == ("t", "psi", "F_N", "M", "psi_dot")
    same_to_the_last_digit(session, estimated(Path("live.parquet"), rig=rig))


def rows_by_column(**columns: np.ndarray) -> list[dict[str, float]]:
    values = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in values]


@pytest.mark.long
def test_a_car_that_stands_rolls_and_brakes(car: Path) -> None:
    t, rack = steering(seconds=6.0)
    force, speed, brake = SimulatedCar().force(rack), np.zeros(t.size), np.ones(t.size)
    speed[:5], speed[5:15], speed[100:140], speed[145:180] = np.nan, 2.0, 3.0, 3.0
    brake[300:] = 0.0
    rack[150] = rack[200] = force[210] = np.nan
    rows = rows_by_column(t=t, rack=rack, F_rack=force, speed=speed, brake=brake)
    session = run_to_end(session_over(rows, Path("car.parquet"), rig=None, vehicle=car))

    same_to_the_last_digit(session, estimated(Path("car.parquet"), rig=None, vehicle=car))
    held = session.ring.since(0).values_of_field("status") == Status.HELD
    assert np.array_equal(np.flatnonzero(held[:300]), [*range(15), *range(100, 180)])


@pytest.mark.long
def test_a_car_whose_force_has_the_other_sign_is_never_usable(car: Path) -> None:
    t, rack = steering(seconds=6.0)
    rows = rows_by_column(t=t, rack=rack, F_rack=-SimulatedCar().force(rack))
    session = session_over(rows, rig=None, vehicle=car)
    session._looked = -math.inf
    run_to_end(session)
    session._looked = -math.inf
    session._check_plausibility()

    assert "rack and F_rack have opposite signs" in session.state().status
    assert not session.state().usable
    row = {"t": 0.0, "rack": 0.0, "T_bar": 1.0, "T_motor": 1.0}
    session = run_to_end(session_over([row] * 3, rig=None, vehicle=car))
    assert "T_motor, and motor_ratio of the vehicle go together" in session.state().status
    assert not session.ring.end


def test_a_source_that_dies_comes_back_and_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("brushgrip.live.session.AGAIN", 0.01)
    rows = rows_of(320)
    parts = iter([ListSource(rows[:300], OSError), OSError("not yet"), ListSource(rows[50:])])

    def open_source() -> ListSource:
        if isinstance(part := next(parts), Exception):
            raise part
        return part

    session = session_of("udp:5005", record=Path("live.parquet"))
    session._open = open_source
    run_to_end(session)

    assert [path.name for path in session.recorded] == ["live.parquet", "live_2.parquet"]
    assert session.state().counts == {"samples": 570, "reopened": 1, "begun anew": 1}
    unknown = replace(session.state(), usable=False)
    assert "; begun anew once after gaps" in state_line(unknown)
    assert "anew" not in state_line(replace(unknown, usable=True))
    same_to_the_last_digit(session, estimated(Path("live_2.parquet")))


@pytest.mark.long
@pytest.mark.parametrize("at", range(200, 1300, 100))
def test_what_begins_twisted_is_not_usable_and_wrong(at: int) -> None:
    # The source died while the wheel stood turned: the torque there is not that of an untwisted patch.
    session = run_to_end(session_over(rows_of(2000, at)))
    points = session.ring.since(0)
    usable = points.values_of_field("usable") == 1
    whole = estimated(RIG.with_name("train_a.csv"))
    reference = whole.mu_eff[whole.usable].mean()
    off = np.abs(points.values_of_field("mu_eff") - reference) / np.maximum(
        points.values_of_field("mu_eff_std"), 0.02 * reference
    )

    assert not (usable & (off > 4)).any(), (reference, points.values_of_field("mu_eff")[usable][:5])


def test_says_that_the_first_sample_waits_for_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    session, compiled = session_over(rows_of(20)), Event()
    estimate = WheelRowEstimator.__call__

    def waiting(self: WheelRowEstimator, row: dict[str, float]) -> list[EstimatedSample]:
        compiled.wait()
        return estimate(self, row)

    monkeypatch.setattr(WheelRowEstimator, "__call__", waiting)
    assert state_line(session.state()) == "no sample has come yet"
    session.start()
    wait_for(lambda: session.state().counts.get("samples"))
    wait_for(lambda: state_line(session.state()) == "compiling the observer")
    compiled.set()
    wait_for(lambda: session.state().ended)
    session.stop()
    assert state_line(session.state()).startswith("0.19 s: ")


def test_a_torque_of_the_other_sign_is_told_with_the_sign_that_is_expected() -> None:
    session = run_to_end(session_over([row | {"M_z": -row["M_z"]} for row in rows_of(600)]))

    (cause,) = session.estimator.suspicions
    assert "M_z is the moment of the ground on the wheel, negative for a first turn to posit" in cause


def test_an_old_estimate_is_not_usable() -> None:
    for age, usable in ((0.9 * HOLD, True), (1.1 * HOLD, False)):
        session = session_of("udp:5005")
        store(session, KNOWN, age=age)
        assert session.state().usable is usable
    assert session.state().status == "no sample for 1 s"


def test_a_torque_that_seems_to_end_by_its_sensor_is_told_unless_its_range_is_declared() -> None:
    made = make_recording(590_021, mu=0.8, duration=14.0, bristles=500)
    rows = rows_by_column(t=made.t, psi=made.psi, F_N=made.F_N, M_z=2.0 * np.tanh(made.M_z / 2.0))
    declared = Path("rig.toml")
    declared.write_text(f"{RIG.read_text()}[sensor]\nrange = 1.0\n")
    soft, straight = (run_to_end(session_over(rows, rig=rig)).state().note for rig in (RIG, declared))
    assert soft.startswith("the torque seems to end at 2 N m")
    assert not straight


def test_an_observer_behind_its_source_says_nothing_usable(monkeypatch: pytest.MonkeyPatch) -> None:
    session = session_over(rows_of(400))
    own = session.estimator
    taken: list[float] = []

    def slow(row: dict[str, float]) -> list[EstimatedSample]:
        if 20 < len(taken) < 200:
            time.sleep(0.01)
        taken.append(row["t"])
        return own(row)

    monkeypatch.setattr(session, "estimator", slow)
    for name in ("columns", "suspicions", "implausibility_text", "reset", "weaker", "note", "remarks"):
        monkeypatch.setattr(slow, name, getattr(own, name), raising=False)
    session.start()
    wait_for(lambda: len(taken) > 30)
    session._newest = session._newest and replace(session._newest, status=Status.USED, informed=True)
    wait_for(lambda: len(taken) > 120)
    state = session.state()
    session.stop()

    assert not state.usable
    assert "s behind the source" in state.status


def test_a_rate_of_the_other_sign_is_never_usable() -> None:
    rows = rows_of(1400)
    rate = np.gradient([row["psi"] for row in rows], 0.01)
    for row, psi_dot in zip(rows, rate.tolist(), strict=True):
        row["psi_dot"] = -psi_dot
    state = run_to_end(session_over(rows, Path("run.parquet"))).state()

    assert "psi_dot is -1 times the derivative of psi" in state.status
    assert "friction was never usable" in state.status
    assert "usable" not in state.counts
    with pytest.raises(InvalidInputError, match="psi_dot is -1 times the derivative of psi"):
        estimated(Path("run.parquet"))


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
    session = session_over([])
    session._open = lambda: Flood(flood)
    run_to_end(session)

    counts = session.state().counts
    assert (counts["lost"], counts["samples"]) == (500, 100)


def test_recording_begun_later_holds_the_stretch_from_its_beginning() -> None:
    rows = rows_of(400)
    source = ListSource(rows)
    later = source._rows
    source._rows = later[:300]
    source.read, read = lambda: read() if source._rows else [], source.read  # type: ignore[method-assign]
    session = session_over([], Path("late.parquet"))
    session.recording, session._open = False, lambda: source
    session.start()
    wait_for(lambda: session.ring.end == 300)
    session.recording = True
    wait_for(lambda: session.state().recording)
    source._rows = later[300:]
    wait_for(lambda: session.ring.end == 400)
    session.recording = False
    wait_for(lambda: session.recorded)
    session.stop()

    same_to_the_last_digit(session, estimated(Path("late.parquet")))


def test_a_recording_that_cannot_go_on_does_not_stop_the_estimate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("brushgrip.live.recorder.Recorder.write", full)
    session = run_to_end(session_over(rows_of(30), Path("live.parquet")))

    assert session.ring.end == 30
    assert "the recording broke off: disk full" in session.state().status
    assert session.recorded == []
    assert list(Path().glob("*.parquet")) == []


def test_an_observer_that_fails_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("oops")

    monkeypatch.setattr(WheelRowEstimator, "__call__", fail)
    monkeypatch.setattr("threading.excepthook", lambda *_: None)
    session = session_over(rows_of(30))
    session.start()
    wait_for(lambda: "stopped by an error: oops; friction was" in session.state().status)
    session.stop()

    assert not session.state().usable


def test_clock() -> None:
    clock = TimestampFilter()
    times = [1.7e9 + t for t in (0.0, 0.5, 0.5, 0.4, 5.0 - 1.7e9, 1.0)]
    times += [7.0, 7.5, 7.25, 100.0, math.inf]
    told = [(timed.row["t"], timed.begins) for t in times for timed in clock({"t": t})]

    assert told == [(0.0, True), (0.5, False), (1.0, False), (7.0, True), (7.5, False)]
    assert (clock.late, clock.wrong) == (3, 2)


@pytest.mark.long
def test_the_command_replays_records_and_ends(run: Run) -> None:
    source, out = RIG.with_name("train_a.csv"), Path("live.parquet")
    outcome = run("live", source, "--rig", RIG, "--speed", 200, "--no-page", "--record", out)

    assert (outcome.status, outcome.err) == (0, "")
    assert f"wrote {out}" in outcome.out
    assert ": μ " in outcome.out
    assert estimated(out).t.size == estimated(source).t.size


def test_a_sound_rate_is_sound_after_minutes() -> None:
    t = 0.05 * np.arange(20_000)
    psi, rate = 0.3 * np.sin(np.pi * t), 0.3 * np.pi * np.cos(np.pi * t)
    estimator = WheelRowEstimator(lambda _: OBSERVER)
    estimator.columns = ("t", "psi", "F_N", "M_z", "psi_dot")
    still = np.zeros(t.size)

    assert estimator.implausibility_text(np.column_stack([t, psi, still + 400, still, rate])) == ""
    assert "psi_dot" in estimator.implausibility_text(
        np.column_stack([t, psi, still + 400, still, -rate])
    )


class SilentSource(ListSource):
    """Says nothing more after its rows."""

    def read(self) -> list[dict[str, float]]:
        time.sleep(0.01)
        return super().read() if self._rows else []


def test_a_session_that_is_stopped_tells_the_last_friction_as_at_the_end_of_its_source() -> None:
    told: list[str] = []
    session = session_of("udp:5005")
    session._open = lambda: SilentSource(rows_of(300))
    session._listeners = (lambda state: told.append(state.status),)
    session.start()
    wait_for(lambda: session._newest is not None)
    session.stop()

    assert told[-1] == "stopped: friction was never usable"
    assert session.state().ended


def test_nothing_is_read_before_the_page_is_there(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "bokeh", None)
    outcome = run("live", RECORDINGS / "train_a.csv", "--rig", RIG, "--no-browser")

    outcome.refused("the page needs Bokeh; pip install 'brushgrip[live]'")


def test_between_torques_the_last_one_says_what_is_usable() -> None:
    session = session_of("udp:5005")
    without = replace(KNOWN, status=Status.MISSING)
    usable = []
    for step in range(200):
        estimate = KNOWN if step % 10 == 0 and step < 100 else without
        store(session, estimate, t=0.01 * step)
        usable.append(session.state().usable)

    # Half a second after the last torque nothing is usable any more.
    assert usable == [0.01 * step - 0.9 < HOLD for step in range(200)]
    assert session.state().counts == {"without a torque": 190, "usable": 10}


def test_a_flag_between_torques_is_told_at_once() -> None:
    session = session_of("udp:5005")
    for status in (Status.USED, Status.MISSING | Status.IMPLAUSIBLE):
        store(session, replace(KNOWN, status=status), t=float(status))

    assert not session.state().usable


def test_advice_is_given_only_where_turning_helps() -> None:
    session = session_of("udp:5005")
    session._adviser = SteeringAdviser(0.15, SteeringLimits())
    session._adviser._text = "turn 8° more to the left"
    for status, is_given in ((Status.USED, True), (Status.INCONSISTENT, False), (Status.USED, True)):
        store(session, replace(KNOWN, status=status))
        assert ("turn 8°" in state_line(session.state())) == is_given
    session._ended = True
    assert "turn 8°" not in state_line(session.state())


@pytest.mark.parametrize(
    "change", [{"status": Status.ACQUIRING | Status.REJECTED}, {"informed": False}, {"mu_std": math.nan}]
)
def test_nobody_is_told_to_turn_and_to_stop(change: dict[str, Any]) -> None:
    session = session_of("udp:5005")
    session._adviser = SteeringAdviser(0.02, SteeringLimits())
    estimate = replace(KNOWN, **{"informed": False} | change)
    for advice, is_told in (("turn 8° more to the left", True), ("stop turning: 2.0%", False)):
        session._adviser._text = advice
        store(session, estimate)
        status = session.state().status
        assert (": turn " in status) == is_told
        assert status.split("; ")[-1].startswith(estimate.remedy.split("; ")[-1].split(":")[0])
        assert ("raise gate" in status) == (Status.REJECTED in estimate.status)


def test_the_weaker_direction_of_a_found_model_is_told_with_every_estimate() -> None:
    state = session_of("udp:5005", model=write_model({"asymmetric_friction.ratio": 0.85})).state()

    assert state.weaker == pytest.approx(0.15 / 1.85)
    assert state_line(state) == "no sample has come yet"
    told = state_line(replace(state, t=1.0, estimate=prior_estimate(OBSERVER)))
    assert ", not usable; 8 % less than mu_eff turning to positive psi: " in told
    assert session_of("udp:5005").state().note == ""


def test_the_end_of_a_source_is_no_dead_sensor() -> None:
    session = run_to_end(session_over(rows_of(20)))
    state = session.state()

    assert state.status == "the source has ended: friction was never usable"
    assert usability_of(state) == "ended"
    store(session, KNOWN, t=1.5)
    last = "the source has ended: friction was 0.80 ± 0.20 at 1.5 s, last usable"
    assert session.state().status == last


def test_the_end_of_a_source_tells_no_friction_that_what_follows_contradicts() -> None:
    for usable, inconsistent, is_told in ((10, 29, True), (10, 31, False), (0, 5, False)):
        last = LastUsableFriction()
        flags = [Status.USED] * (1 + usable) + [Status.INCONSISTENT] * inconsistent
        for number, status in enumerate(flags):
            seen = replace(KNOWN, status=status)
            last.add_sample(number, 0.01 * number, seen, usable=seen.usable)
            # A wheel at rest shows neither.
            last.add_sample(number, 0.01 * number, seen, usable=seen.usable)
        assert last.told.startswith("friction was 0.80 ± 0.20") == is_told
        last.add_sample(99.0, 0.0, replace(KNOWN, status=Status.RESET), usable=False)
        assert last.told == "friction is not known since a new ground was noticed at 99 s"


def test_a_load_outside_those_behind_the_model_is_told() -> None:
    for loads, is_told in (([350.0, 450.0], False), ([200.0, 300.0], True)):
        model = write_model(basis={"training": 1, "holdout": 0, "grades": {}, "loads": loads})
        note = run_to_end(session_over(rows_of(200), model=model)).state().note
        assert note.startswith("load more than a tenth outside the model's: ") == is_told
