"""`brushgrip estimate` on one recording: its table, its picture, and what it refuses."""

import csv
import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brushgrip.estimation.signal_map_remedy import ANGLE, SIGN, TIME, UNITS
from observers.quality.wrong_units_or_signs import EVIDENCE, suspected_by_message
from reference_rig import make_ground_recording, make_recording, make_steering_recording
from tests.brushgrip.helpers import PNG, Run, Write, contents, table_of, write_model

pytestmark = pytest.mark.usefixtures("interpreted", "blank_pictures")
HEADER = "t,mu,mu_std,M_z_predicted,informed,usable,mu_eff,mu_eff_std,M_slide,nis,status"
each_observer = pytest.mark.parametrize("observer", ["ekf", "mhe"])


@pytest.fixture
def simulated(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> Path:
    """A recording whose torque is the declared model's, with mu = 1.2 as in the rig."""
    run("simulate", "--rig", rig, write_csv("bare.csv"), "--out", tmp_path / "torque.csv")
    return write_csv("run.csv", {"M_z": table_of(tmp_path / "torque.csv")["M_z"]})


@pytest.fixture
def steered(write_csv: Write) -> Path:
    """A recording of the steering torque alone, mu = 1.3."""
    recorded = make_steering_recording(3, duration=4.0)
    columns = {"t": recorded.t, "psi": recorded.psi, "M_z": None, "F_N": recorded.F_N, "M": recorded.M}
    return write_csv("steered.csv", columns)


@pytest.fixture
def estimate(run: Run, rig: Path) -> Run:
    usual = ("estimate", "--rig", rig, "--observer")
    return lambda *given, observer="ekf", out="mu.csv": run(*usual, observer, "--out", out, *given)


Table = dict[str, np.ndarray]
Estimated = Callable[..., Table]


@pytest.fixture
def estimated(estimate: Run) -> Estimated:
    """The table that the command writes."""

    def table(*arguments: object, observer: str = "ekf") -> Table:
        assert estimate(*arguments, observer=observer).status == 0
        return table_of(Path("mu.csv"))

    return table


@each_observer
def test_one_row_a_sample(estimate: Run, simulated: Path, observer: str) -> None:
    outcome = estimate(simulated, observer=observer, out="new/mu.csv")
    header, *rows = Path("new/mu.csv").read_text().splitlines()
    of = table_of(Path("new/mu.csv"))

    assert outcome.status == 0
    assert header == HEADER
    assert np.array_equal(of["t"], table_of(simulated)["t"])
    assert {row.split(",")[4] for row in rows} <= {"0", "1"}
    assert {row.split(",")[-1] for row in rows} <= {str(flags) for flags in range(4096)}
    np.testing.assert_allclose(of["mu_eff"], of["mu"], rtol=1e-12)
    np.testing.assert_allclose(of["mu_eff_std"], of["mu_std"], rtol=1e-12)
    assert (of["M_slide"] > 0).all()
    assert (of["nis"][np.isfinite(of["nis"])] >= 0).all()
    assert np.isfinite(of["nis"]).any()
    assert (of["mu"] > 0).all()
    assert of["mu_std"][-1] < of["mu_std"][0]
    assert of["informed"][0] == 0
    assert (of["usable"] <= of["informed"]).all()
    assert np.isfinite(of["M_z_predicted"]).all()
    assert Path("new/mu.png").read_bytes().startswith(b"\x89PNG")


def test_friction_by_direction(estimated: Estimated, simulated: Path) -> None:
    error = {"spread": 0.02, "relative": 0.05, "correlation_time": 2.0, "friction_walk": 0.1}
    write_model(model_error=error)
    directed = estimated(simulated, "--by-direction")["mu"]
    of_model = ("--by-direction", "--model", "model.json")
    walks = ((), ("--tune", "mu_walk=0.1"))
    walking = [estimated(simulated, *of_model, *walk)["mu_std"] for walk in walks]

    assert np.array_equal(*walking)
    # Both directions have a prior of their own: what is found forth says little of the way back.
    assert not np.array_equal(directed, estimated(simulated)["mu"])
    assert directed[-1] == pytest.approx(1.2, rel=0.05)


@pytest.mark.parametrize("found", [False, True])
def test_each_direction_has_its_own_friction(
    run: Run, estimate: Run, write_csv: Write, rig: Path, *, found: bool
) -> None:
    """The wheel slides at 0.8 times mu = 1.2 while the angle rises; the model found knows that."""
    write_model({"asymmetric_friction.ratio": 0.8})
    t = np.arange(0, 12, 0.01)
    turned = {"t": t, "psi": 0.3 * np.sin(1.6 * t), "F_N": np.full(t.size, 400.0)}
    bare = write_csv("bare.csv", {**turned, "M_z": None})
    assert run("simulate", "--rig", rig, bare, "--model", "model.json", "--out", "M.csv").status == 0
    recorded = write_csv("run.csv", {**turned, "M_z": table_of(Path("M.csv"))["M_z"]})
    options = ("--by-direction", *("--model", "model.json") * found)
    said = estimate(recorded, *options).out
    (row,) = json.loads(estimate(recorded, *options, "--json").out)

    assert row["mu_eff_positive"] == pytest.approx(0.96, rel=0.03)
    assert row["mu_eff_negative"] == pytest.approx(1.2, rel=0.03)
    assert row["mu_eff"] == pytest.approx(row[f"mu_eff_{row['direction']}"], rel=0.03)
    assert 1 - row["weaker"] == pytest.approx(row["mu_eff_positive"] / row["mu_eff"], rel=0.01)
    assert f" (95 % band) turning to {row['direction']} psi at " in said
    assert "run: mu_eff by direction, last usable: " in said
    for way in ("positive", "negative"):
        assert f"{row[f'mu_eff_{way}']:.2f} ± " in said
        assert f" turning to {way} psi, at " in said
    assert "mean of both" not in said
    # Not declared, the zero counts as 3 % of full slide at mu = 1, at both ends of two deviations.
    assert "zero of the torque 0.06, " in said


def test_k_may_be_a_state(estimated: Estimated, simulated: Path) -> None:
    fixed, free = (estimated(simulated, *state)["mu"] for state in ((), ("--stiffness-state",)))

    assert not np.array_equal(fixed, free)
    assert free[-1] == pytest.approx(1.2, rel=0.1)


@pytest.mark.parametrize(("factor", "message"), [(0.5, "grows with the angle 0.5"), (0.65, "gear")])
def test_friction_by_direction_waits_for_the_scale_of_the_torque(
    estimate: Run, write_csv: Write, factor: float, message: str
) -> None:
    recorded = make_recording(5, mu=0.15, bristles=400)
    columns = {name: getattr(recorded, name) for name in ("t", "psi", "M_z", "F_N")}
    said = estimate(write_csv("run.csv", {**columns, "M_z": factor * recorded.M_z}), "--by-direction")

    assert "friction is not known" in said.out
    assert message in said.out
    assert not table_of(Path("mu.csv"))["usable"].any()
    estimate(write_csv("run.csv", columns), "--by-direction")
    assert table_of(Path("mu.csv"))["usable"].any()


@pytest.mark.parametrize("observer", ["ekf", "mhe", "root"])
def test_a_later_sample_changes_nothing_before(estimate: Run, simulated: Path, observer: str) -> None:
    lines = simulated.read_text().splitlines()
    for row in range(36, 46):
        t, _, M_z, _ = lines[row].split(",")
        lines[row] = f"{t},,{M_z},"
    simulated.write_text("\n".join(lines) + "\n")
    Path("cut.csv").write_text("\n".join(lines[:41]) + "\n")
    estimate(simulated, observer=observer)
    estimate("cut.csv", observer=observer, out="cut_mu.csv")

    assert Path("mu.csv").read_text().startswith(Path("cut_mu.csv").read_text())


@pytest.mark.usefixtures("steering_rig")
@pytest.mark.parametrize("observer", ["ekf", pytest.param("mhe", marks=pytest.mark.long)])
def test_from_the_steering_torque(estimated: Estimated, steered: Path, observer: str) -> None:
    end = {name: values[-1] for name, values in estimated(steered, observer=observer).items()}

    assert end["informed"] == 1
    assert abs(end["mu"] - 1.3) < 3 * end["mu_std"]
    assert end["mu_std"] < 0.1


def test_aligning_torque_goes_first(estimated: Estimated, simulated: Path, write_csv: Write) -> None:
    M_z = table_of(simulated)["M_z"]
    both = write_csv("both.csv", {"M_z": M_z, "M": np.full(M_z.size, 5.0)})

    np.testing.assert_equal(estimated(both), estimated(simulated))


@pytest.mark.usefixtures("drawn")
def test_root_has_no_standard_deviation(estimate: Run, simulated: Path) -> None:
    outcome = estimate(simulated, observer="root")
    estimated = table_of(Path("mu.csv"))

    assert outcome.status == 0
    assert np.isnan(estimated["mu_std"]).all()
    assert np.median(estimated["mu"][estimated["informed"] == 1]) == pytest.approx(1.2, abs=1e-3)
    assert "±" not in outcome.out
    # Nothing checks it: on ice it is off by a factor of fifty, and says nothing of it.
    assert not estimated["usable"].any()
    assert "friction is for comparison only: use ekf or mhe" in " ".join(outcome.out.split())
    assert Path("mu.png").read_bytes().startswith(b"\x89PNG")


def test_what_the_steering_torque_needs(estimate: Run, steered: Path, rig: Path) -> None:
    estimate(steered).refused("steered: ", "lacks J_A and b_t", "kg m^2", "--map M_z=-M serves")
    renamed = steered.with_name("renamed.csv")
    renamed.write_text(steered.read_text().replace("F_N,M", "F_N,Moment_Nm", 1))
    told = "of a slow wheel, --map M_z=-Moment_Nm serves a torque sensor"
    estimate(renamed, "--map", "M=Moment_Nm").refused(told)
    rig.write_text(rig.read_text().replace("e = 0.009\n", "e = 0.009\nJ_A = 0.15\nb_t = 1.0\n"))
    estimate(steered, observer="root").refused("root", "M_z", "mhe")
    estimate(steered, "--by-direction").refused("--by-direction needs M_z")
    assert not Path("mu.csv").exists()


@each_observer
def test_says_that_the_ground_has_changed(estimate: Run, write_csv: Write, observer: str) -> None:
    recorded = make_ground_recording(31, lambda t: np.where(t < 7, 1.5, 0.4))
    columns = {name: getattr(recorded, name) for name in ("t", "psi", "M_z", "F_N")}
    summary, _ = estimate(write_csv("ground.csv", columns), observer=observer).out.splitlines()

    # What was usable before is the friction of another ground.
    assert summary.startswith("ground: friction is not known since 7.")
    assert "either the ground changed, or the model does not fit" in summary
    assert "1 change of the ground or misfits of the model" in summary
    assert table_of(Path("mu.csv"))["mu"][-1] == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize(
    ("column", "factor", "cause", "remedy"),
    [
        ("psi", 180 / np.pi, "degrees", "psi=psi:deg or psi=1/15*psi"),
        ("psi", 5 * 180 / np.pi, "degrees", "psi=psi:deg"),
        ("psi", 15 * 180 / np.pi, "steering wheel's in degrees", "psi=1/15*psi:deg"),
        ("t", 1e3, "milliseconds", "t=t:ms"),
        ("t", 1e6, "milliseconds or less", "t=t:us"),
        ("t", 1e10, "another unit", "t=t:ns"),
        ("F_N", 1e-3, "kN", "F_N=F_N:kN"),
        ("M_z", 1e3, "N mm", "M_z=M_z:mNm"),
        ("M_z", -1.0, "negative for a first turn to positive psi (left): flip M_z", "M_z=-M_z"),
    ],
)
def test_other_units_and_signs_are_refused_by_name(
    estimate: Run, write_csv: Write, simulated: Path, column: str, factor: float,
    cause: str, remedy: str,
) -> None:  # fmt: skip
    columns = table_of(simulated)
    wrong = write_csv("wrong.csv", columns | {column: factor * columns[column]})
    entry, _, other = remedy.partition(" or ")
    outcome = estimate(wrong)

    outcome.refused("wrong", cause, f"--map {shlex.quote(entry)}", other)
    assert not Path("mu.csv").exists()
    assert ("with your steering ratio for 15" in outcome.err) == ("1/15" in remedy)
    assert estimate(wrong, "--map", entry).status == 0


def test_a_counter_of_samples_may_be_the_time(estimate: Run, write_csv: Write, simulated: Path) -> None:
    columns = table_of(simulated)
    path = write_csv("counted.csv", columns | {"t": np.arange(columns["t"].size)})

    words = "--map t=t:ms; if t counts samples, at 100 Hz: t=0.01*t in its place"
    estimate(path).refused(words)
    assert estimate(path, "--map", "t=0.01*t").status == 0


def test_a_slope_that_contradicts_k_asks_for_its_tolerance(run: Run, simulated: Path, rig: Path) -> None:
    rig.write_text(rig.read_text().replace("2.4e6", "6e6"))
    outcome = run("estimate", "--rig", rig, simulated)

    assert "a k taken from this torque makes mu wrong by the same factor" in outcome.out
    assert "times as k, a and F_N say" in outcome.out
    assert "k = { value = ..., tolerance = ... } in [tyre]" in outcome.out


def test_a_unit_of_the_file_is_not_asked_for(estimate: Run, write_csv: Write, simulated: Path) -> None:
    columns = table_of(simulated)
    geared = write_csv("geared.csv", {"psi": None, "psi [deg]": 15 * np.degrees(columns["psi"])} | {
        name: columns[name] for name in ("t", "M_z", "F_N")
    })  # fmt: skip
    estimate(geared).refused("degrees", "--map 'psi=1/15*psi:deg'", "with your steering ratio for 15")


def test_one_map_mends_all_that_is_wrong(estimate: Run, write_csv: Write, simulated: Path) -> None:
    of = table_of(simulated)
    wrong = {"Zeit": of["t"], "psi": of["psi"], "Moment": -of["M_z"], "F_N": of["F_N"] / 1e3}
    path = write_csv("wrong.csv", dict.fromkeys(("t", "M_z")) | wrong)
    remedy = estimate(path, "--map", "t=Zeit,M_z=Moment").err.strip().partition("--map ")[2]

    assert remedy == "t=Zeit,M_z=-Moment,F_N=F_N:kN"
    assert estimate(path, "--map", remedy).status == 0


@pytest.mark.parametrize("heading", ["time in ms", "t (in ms)", "Zeit, ms", "time:ms", "t [ms]"])
def test_a_time_in_ms_is_read_or_mended_by_the_map_that_is_handed_back(
    estimate: Run, write_csv: Write, simulated: Path, rig: Path, heading: str
) -> None:
    columns = table_of(simulated)
    wrong = {n: columns[n] for n in ("psi", "M_z", "F_N")} | {"t": None}
    wrong = {f'"{heading}"': 1e3 * columns["t"]} | wrong
    path = write_csv("wrong.csv", wrong)
    outcome = estimate(path)
    option, line = (outcome.err.strip().partition(sign)[2] for sign in ("--map ", "in its place: "))
    if line:
        rig.write_text(f"{line}\n{rig.read_text()}")

    assert estimate(path, *(["--map", *shlex.split(option)] if option else [])).status == 0
    assert (outcome.status == 0) == ("[" in heading or "(" in heading)


def test_every_suspected_cause_but_a_broken_sensor_has_a_map() -> None:
    places = EVIDENCE.places
    named = list(suspected_by_message(dict.fromkeys(places, 1.0), "M_z"))
    without = [cause for cause in named if not cause.startswith((*UNITS, ANGLE, SIGN, TIME))]

    assert len(named) == 6
    assert ["flip M_z" in cause for cause in named] == [cause.startswith(SIGN) for cause in named]
    assert [cause.split(":")[0] for cause in without] == ["the torque is clipped or frozen"]


def test_without_a_file_to_write_the_line_suffices(
    estimate: Run, run: Run, simulated: Path, rig: Path, tmp_path: Path
) -> None:
    estimate(simulated)
    told = estimate(simulated).out.splitlines()[0]
    (tmp_path / "mu.csv").unlink()
    before = contents(tmp_path)
    outcome = run("estimate", "--rig", rig, simulated)  # The default observer is the EKF.

    line, budget, *more = outcome.out.splitlines()
    assert (outcome.status, line) == (0, told)
    assert [one.partition(", ")[0] for one in more] == ["run: load the same in every sample"]
    made_of = "run: the band ± 0.16 is made of (the squares add up): noise and the model's error"
    assert budget.startswith(made_of)
    assert contents(tmp_path) == before
    for picture in ("only.png", "pictures/friction.PNG"):
        assert run("estimate", "--rig", rig, simulated, "--picture", picture).status == 0
        assert (tmp_path / picture).read_bytes().startswith(PNG)
    assert run("estimate", "--rig", rig, simulated, "--picture", "only.pdf").status == 2


def test_a_load_that_never_changes_is_no_measured_one(
    run: Run, simulated: Path, write_csv: Write, rig: Path
) -> None:
    columns = table_of(simulated)
    measured = write_csv("weighed.csv", columns | {"F_N": columns["F_N"] + 0.1 * np.sin(columns["t"])})
    told = "load the same in every sample, as if it was not measured: 400 N; "
    (row,) = json.loads(run("estimate", "--rig", rig, simulated, "--json").out)

    assert told in row["remark"]
    assert f"\nrun: {told}" in run("estimate", "--rig", rig, simulated).out
    assert told not in run("estimate", "--rig", rig, measured).out
    rig.write_text(rig.read_text().replace("[rig]", "[rig]\nload = { tolerance = 0.1 }"))
    assert told not in run("estimate", "--rig", rig, simulated).out


def test_says_what_a_model_gives(estimate: Run, simulated: Path) -> None:
    write_model(basis={"training": 1, "holdout": 0, "grades": {}})

    told = estimate(simulated, "--model", "model.json").out
    gives = "From model.json: k = 2.4·10⁶ N/m². It stands on 1 recording, nothing judged it."
    assert told.startswith(gives)
    # Nobody is sent to find a model who has one.
    or_find = "to narrow it, turn to and fro more often, or find what the model lacks"
    assert (or_find in told, or_find in estimate(simulated, out="declared.csv").out) == (False, True)


@pytest.mark.parametrize(
    ("loads", "is_told"),
    [([350.0, 450.0], False), ([350.0, 370.0], False), ([350.0, 360.0], True), ([450.0, 460.0], True)],
)
def test_a_load_outside_those_behind_the_model_is_told(
    estimate: Run, simulated: Path, loads: list[float], is_told: bool
) -> None:
    write_model(basis={"training": 1, "holdout": 0, "grades": {}, "loads": loads})
    told = estimate(simulated, "--model", "model.json", "--summary", "all.csv").out
    low, high = loads
    line = f"load more than a tenth outside the model's: 400 N, found at {low:.0f} to {high:.0f} N"

    assert ("1 of 1: load more than a tenth outside the model's" in told) == is_told
    assert (line in Path("all.csv").read_text()) == is_told
    assert (f"run: {line}" in estimate(simulated, "--model", "model.json").out) == is_told


def test_the_load_that_friction_belongs_to_is_told_where_it_changes_with_it(
    run: Run, simulated: Path, write_csv: Write, rig: Path
) -> None:
    columns = table_of(simulated)
    load = columns["F_N"] * (1 + 0.1 * np.sin(columns["t"]))
    swinging = write_csv("swinging.csv", columns | {"F_N": load})
    for effect, is_told in (("load_dependent_friction.n", True), ("asymmetric_friction.ratio", False)):
        write_model({effect: 0.8})
        outcome = run("estimate", "--rig", rig, swinging, "--model", "model.json", "--json")
        (row,) = json.loads(outcome.out)
        assert row["last_usable"] is not None
        at = load[np.searchsorted(columns["t"], row["last_usable"])]
        told = f"by the model friction changes with the load: mu_eff is that at {at:.0f} N"
        assert (told in row["remark"]) == is_told
        assert "times mu_eff" not in row["remark"]
        # (1 - 0.8) / (1 + 0.8)
        assert row["weaker"] == (0 if is_told else pytest.approx(1 / 9, rel=1e-4))
        low = row["mu_eff"] * (8 / 9) - 2 * row["mu_eff_std"]
        weaker = f"11 % less than mu_eff turning to positive psi, down to {low:.2f}: "
        assert (weaker in row["remark"]) != is_told


def test_a_k_that_is_off_is_told_and_part_of_the_band(simulated: Path, run: Run, rig: Path) -> None:
    write_model()
    declared = rig.read_text(encoding="utf-8")
    assert "k = 2.4e6" in declared
    told = []
    for k in ("2.4e6", "{ value = 3.2e6, tolerance = 6e5 }", "3.2e6"):
        rig.write_text(declared.replace("k = 2.4e6", f"k = {k}"), encoding="utf-8")
        told.append(run("estimate", "--rig", rig, simulated, "--model", "model.json").out)

    assert ["25 % below the declared 3.2·10⁶" in out for out in told] == [False, True, True]
    part = "scale of the torque, by what is declared beside the load or found"
    assert [part in out for out in told] == [False, True, False]


def test_a_part_of_a_recording(estimate: Run, simulated: Path, caplog: pytest.LogCaptureFixture) -> None:
    estimate(simulated, "--from", 0.3, "--to", 0.49)

    np.testing.assert_allclose(table_of(Path("mu.csv"))["t"], table_of(simulated)["t"][30:50])
    assert "begins at 0.3 s with a torque of " in caplog.text
    origin = json.loads(Path("mu.provenance.json").read_text())
    assert origin["settings"]["span"] == [0.3, 0.49]
    short = estimate(simulated, "--from", 0.3, "--to", 0.35)
    short.refused("5 samples from 0.3 to 0.35 s", "0 to 0.59 s")


def test_the_angle_of_the_steering_wheel(
    estimate: Run, estimated: Estimated, simulated: Path, write_csv: Write
) -> None:
    columns, wanted = table_of(simulated), estimated(simulated)
    rate = {"psi_dot": np.gradient(columns["psi"], columns["t"])}
    rated = estimated(write_csv("rated.csv", columns | rate))
    both_geared = columns | {"psi": 15 * columns["psi"], "psi_dot": 15 * rate["psi_dot"]}
    both = estimated(write_csv("both.csv", both_geared), "--steering-ratio", 15)
    geared = write_csv("geared.csv", columns | {"psi": 15 * columns["psi"]})
    of = estimated(geared, "--steering-ratio", 15)

    np.testing.assert_allclose(of["mu"], wanted["mu"], rtol=1e-6)
    np.testing.assert_allclose(both["nis"], rated["nis"], rtol=1e-6)
    assert json.loads(Path("mu.provenance.json").read_text())["settings"]["steering_ratio"] == 15
    again = estimate(geared, "--steering-ratio", 15, "--map", "psi=1/15*psi")
    again.refused("the map of channels has a factor for psi already, psi=1/15*psi")
    estimate(geared, "--steering-ratio", 0).refused("--steering-ratio must be finite and greater than 0")


@pytest.mark.parametrize(
    ("column", "factor", "said"),
    [
        ("psi", 15.0, "; if psi is the steering wheel's, without a ratio yet: --steering-ratio 15; if"),
        ("M_z", 1e-3, "; if the torque is in kN m: --map M_z=M_z:kNm"),
        ("M_z", 0.3, "check the torque's unit and gear"),
    ],
)
def test_a_scale_that_no_sample_alone_betrays_is_named(
    estimate: Run, run: Run, write_csv: Write, rig: Path, column: str, factor: float,
    said: str,
) -> None:  # fmt: skip
    # Small turns, so that an angle of the steering wheel stays below a right angle.
    t = np.arange(500) * 0.01
    columns = {"t": t, "psi": 0.08 * np.sin(2.0 * t), "F_N": np.full(500, 400.0), "M_z": np.zeros(500)}
    run("simulate", "--rig", rig, write_csv("bare.csv", columns), "--out", "torque.csv")
    columns["M_z"] = table_of(Path("torque.csv"))["M_z"]
    columns[column] = factor * columns[column]
    outcome = estimate(write_csv("scaled.csv", columns))

    assert "scaled: friction is not known, usable in 0 % of 500 samples" in outcome.out
    assert said in outcome.out


def test_smoothed_friction_is_known_from_the_start(estimated: Estimated, simulated: Path) -> None:
    smoothed, filtered = estimated(simulated, "--smooth"), estimated(simulated)

    assert smoothed["mu_std"][0] < 0.5 * filtered["mu_std"][0]
    # The smoother begins about what the filter ends with, and linearises there.
    assert abs(smoothed["mu"][-1] - filtered["mu"][-1]) < 0.1 * filtered["mu_std"][-1]


def test_a_torque_at_the_range_of_its_sensor_is_told(estimate: Run, simulated: Path, rig: Path) -> None:
    torque = np.abs(table_of(simulated)["M_z"])
    most = 0.5 * torque.max()
    share = np.mean(torque >= 0.95 * most)
    plain = rig.read_text()
    rig.write_text(f"{plain}[sensor]\nrange = {2 * torque.max()}\n")
    ample = estimate(simulated).out
    rig.write_text(f"{plain}[sensor]\nrange = {most}\n")
    told = estimate(simulated, out="low.csv").out

    assert "sensor's range" not in ample
    assert f"torque at its sensor's range, {most:g} N m, left out: in {100 * share:.0f} %" in told
    assert "friction above 0.5" in told
    assert told.count("sensor's range") == 1


def test_a_torque_that_is_clipped_at_its_declared_range_is_no_faulty_input(
    estimate: Run, simulated: Path, rig: Path, write_csv: Write
) -> None:
    columns = table_of(simulated)
    most = 0.7 * float(np.abs(columns["M_z"]).max())
    clipped = write_csv("clipped.csv", columns | {"M_z": columns["M_z"].clip(-most, most)})
    refused = estimate(clipped)
    rig.write_text(f"{rig.read_text()}[sensor]\nrange = {most}\n")
    told = estimate(clipped)

    assert "the torque is clipped" in refused.err
    assert told.status == 0
    assert "friction above" in told.out


def test_a_sensor_that_may_end_is_told_beside_why_mu_is_unknown_unless_its_range_is_declared(
    estimate: Run, rig: Path, write_csv: Write
) -> None:
    made = make_recording(580_003, mu=0.8)
    most = 0.3 * float(np.abs(made.M_z).max())
    columns = {name: getattr(made, name) for name in ("t", "psi", "F_N")}
    path = write_csv("soft.csv", columns | {"M_z": most * np.tanh(made.M_z / most)})
    out = estimate(path, "--summary", "table.csv").out
    (row,) = csv.DictReader(Path("table.csv").read_text("utf-8").splitlines())
    why, *beside = row["remark"].split(" | ")

    assert row["mu_eff"] == ""
    assert why.startswith("not known: ")
    assert "seems to end" not in why
    assert beside[0].startswith("the torque seems to end at")
    assert "1 of 1: the torque seems to end at" in out
    assert "friction may be higher than told: declare up to where the sensor is straight" in beside[0]
    rig.write_text(f"{rig.read_text()}[sensor]\nrange = {0.8 * most}\n")
    assert "seems to end" not in estimate(path, out="declared.csv").out


def test_a_torque_in_every_tenth_row_is_counted_by_itself(
    estimate: Run, simulated: Path, rig: Path, write_csv: Write
) -> None:
    columns = table_of(simulated)
    torque = columns["M_z"][::10]
    most = float(np.sort(np.abs(torque))[-max(3, torque.size // 20)]) / 0.95
    rig.write_text(f"{rig.read_text()}[sensor]\nrange = {most}\n")
    columns["M_z"] = np.where(np.arange(columns["t"].size) % 10 == 0, columns["M_z"], np.nan)
    share = np.mean(np.abs(torque) >= 0.95 * most)

    assert f"left out: in {100 * share:.0f} % of" in estimate(write_csv("slow.csv", columns)).out
