"""Many recordings estimated at once, and tunings value by value."""

import csv
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip.inputs.option_values import chosen_tuning
from brushgrip.wording.recording_remarks import friction_lines_by_ground, friction_range, printed_rows
from observers import PROFILES, Tuning
from tests.brushgrip.helpers import Run, Write, table_of

pytestmark = pytest.mark.usefixtures("interpreted", "blank_pictures")


@pytest.fixture
def estimate(run: Run, rig: Path) -> Run:
    usual = ("estimate", "--rig", rig, "--observer", "root")
    return lambda *arguments: run(*usual, *arguments, "--jobs", 1)


Columns = dict[str, np.ndarray]


def rows_of(path: Path) -> dict[str, dict[str, str]]:
    with path.open(newline="") as content:
        return {row["recording"]: row for row in csv.DictReader(content)}


def test_each_is_estimated_as_if_alone(
    estimate: Run, write_csv: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = [write_csv("a.csv"), write_csv("b.csv", {"F_N": np.full(60, 500.0)}, "# ground = ice\n")]
    paths.append(write_csv("c.csv", {"F_N": np.full(60, 300.0)}, "# ground = ice\n"))
    table, out, alone = (tmp_path / name for name in ("table.csv", "mu.csv", "alone.csv"))
    outcome = estimate(*paths, "--out", out, "--summary", table, "--ground", "steel=a,c")
    rows = rows_of(table)
    estimate(paths[1], "--out", alone)
    columns = np.genfromtxt(alone, delimiter=",", names=True)

    assert outcome.status == 0
    assert "\nestimated 3 of 3 recordings; friction is known of 0\n3 of 3: not known" in outcome.out
    assert outcome.out.endswith(f"\nwrote {table}\n")
    assert all(f"│ {name} " in outcome.out for name in "abc")
    monkeypatch.setattr("brushgrip.commands.estimate.MAX_PRINTED", 2)
    assert "│" not in estimate(*paths, "--summary", table).out
    assert "│ a " in estimate(*paths).out
    assert (tmp_path / "mu_b.csv").read_text() == alone.read_text()
    assert [row["ground"] for row in rows.values()] == ["steel", "ice", "steel"]
    # The root solve states no deviation.
    assert not columns["usable"].any()
    assert (rows["b"]["mu"], rows["b"]["last_usable"]) == ("", "")
    assert float(rows["b"]["informed"]) == pytest.approx(columns["informed"].mean(), rel=1e-4)
    assert (rows["b"]["samples"], rows["b"]["mu_std"], rows["b"]["fault"]) == ("60", "", "")
    assert float(rows["b"]["duration"]) == pytest.approx(0.59)


def test_of_how_many_friction_is_known() -> None:
    rows: list[dict[str, object]] = [{"mu_eff": 0.319}, {"mu_eff": None}, {"mu_eff": 0.5}]

    assert friction_range(rows) == "friction is known of 2, mu_eff 0.32 to 0.50"
    # What is not of the end, and another direction, are not hidden.
    rows[0] |= {"since_usable": 4.5, "mu_eff_negative": 0.2}
    told = "friction is known of 2, 1 of them not at the end, mu_eff 0.20 to 0.50"
    assert friction_range(rows) == told


@pytest.mark.parametrize(
    ("more", "cell"),
    [
        ({"since_usable": 0.0}, "0.55 ± 0.08"),
        ({"since_usable": 4.49, "last_usable": 9.51}, "0.55 ± 0.08 at 9.51 s"),
        ({"direction": "negative"}, "– (+psi), 0.55 ± 0.08 (−psi)"),
        (
            {"direction": "negative", "mu_eff_negative": 0.56, "mu_eff_std_negative": 0.04}
            | {"mu_eff_positive": 0.47, "mu_eff_std_positive": 0.04},
            "0.47 ± 0.08 (+psi), 0.56 ± 0.08 (−psi)",
        ),
    ],
)
def test_a_cell_says_when_friction_was_and_of_which_direction(more: dict[str, Any], cell: str) -> None:
    row = {"recording": "a", "ground": "", "mu_eff": 0.55, "mu_eff_std": 0.04}
    row |= {"usable": 0.5, "last_usable": 14.0, "fault": "", "remark": ""}

    assert printed_rows([row | more])[1][0][2] == cell


def test_a_bad_recording_does_not_keep_the_others(estimate: Run, write_csv: Write) -> None:
    good, bad, table = write_csv("good.csv"), Path("bad.csv"), Path("table.csv")
    bad.write_text("t,psi\n")
    outcome = estimate(bad, good, "--summary", table)
    rows = rows_of(table)

    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert "1 of 2 recordings could not be estimated; the first is bad: " in outcome.err
    assert "bad.csv" in rows["bad"]["fault"]
    assert rows["bad"]["mu"] == ""
    assert (rows["good"]["fault"], float(rows["good"]["informed"]) > 0) == ("", True)


def test_each_recording_without_friction_is_named_with_its_cause_and_its_own_map(
    run: Run,
    on_ice: Callable[..., Columns],
    write_csv: Write,
    rig: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    t = np.arange(600) * 0.01
    ice = on_ice(t, 0.3 * np.sin(t))
    torques = {"good": 1.0, "flipped": -1.0, "light": 1.0}
    paths = [
        write_csv(f"{name}.csv", ice | {"M_z": sign * ice["M_z"]}) for name, sign in torques.items()
    ]
    write_csv("light.csv", ice | {"F_N": ice["F_N"] / 40})
    write_csv("clipped.csv", ice | {"M_z": np.clip(ice["M_z"], -0.25, 0.25)})
    monkeypatch.setattr("brushgrip.commands.estimate.MAX_PRINTED", 2)
    command = ("estimate", "--rig", rig, "--jobs", 1, "--summary", "table.csv")
    outcome = run(*command, *paths, "clipped.csv")
    told = dict(line.split(": ", 1) for line in outcome.out.splitlines() if ": " in line)

    assert told["flipped"].endswith("is positive to the right; for this recording alone: --map M_z=-M_z")
    maps = "for this recording alone: --map F_N=F_N:kgf or --map F_N=F_N:lbf"
    assert told["light"].startswith("not known: F_N looks like lbf or kgf: ")
    assert f"convert it to N; {maps} | load the same" in told["light"]
    assert told["clipped"].startswith("friction is above 0.03: the torque is clipped at 0.25 N m, where")
    assert "good" not in told
    names = "flipped, clipped; the causes are above"
    assert f"2 of 4 recordings could not be estimated: {names}" in outcome.err
    # Where none is right, nothing says that the map is of one alone.
    assert "alone" not in run(*command, paths[1]).err
    monkeypatch.setattr("brushgrip.wording.recording_remarks.MAX_NAMED", 1)
    many = run(*command, *paths, "clipped.csv")
    assert "; the first is flipped: psi or the torque" in many.err
    assert "\nflipped: " not in many.out


def test_a_remark_on_files_is_made_of_the_first(
    estimate: Run, write_csv: Write, caplog: pytest.LogCaptureFixture
) -> None:
    loads = {"a.csv": 0.4, "b.csv": 0.5}
    paths = [write_csv(name, {"F_N_kN": np.full(60, load)}) for name, load in loads.items()]
    for _ in range(2):
        caplog.clear()
        estimate(*paths, "--map", "F_N=F_N_kN")
        (message,) = caplog.messages
        assert "a.csv: F_N_kN in kN: units by the names" in message


def test_a_name_is_no_formula_to_a_spreadsheet(estimate: Run, write_csv: Write) -> None:
    estimate(write_csv("=cmd|calc!A1.csv"), "--summary", "table.csv", "--ground", "@ice")
    (row,) = rows_of(Path("table.csv")).values()

    assert (row["recording"], row["ground"]) == ("'=cmd|calc!A1", "'@ice")


def test_the_table_says_what_a_single_recording_says(
    run: Run, on_ice: Callable[..., Columns], write_csv: Write, rig: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    t = np.arange(300) * 0.02
    ice = on_ice(t, 0.3 * np.sin(t))
    monkeypatch.setenv("COLUMNS", "400")
    doubted = ice | {"M_z": 0.3 * ice["M_z"]}
    paths = [write_csv("ice.csv", ice), write_csv("doubted.csv", doubted)]
    table = Path("table.csv")
    printed = run("estimate", "--rig", rig, *paths, "--jobs", 1, "--summary", table).out
    for path in paths:
        texts = rows_of(table)[path.stem]["remark"].removeprefix("not known: ").split(" | ")
        single = run("estimate", "--rig", rig, path).out
        assert all(text and text in single for text in texts)
    alone = run("estimate", "--rig", rig, paths[1]).out
    assert [rows_of(table)[path.stem]["upper_limit"] for path in paths] == ["1", ""]

    (row,) = (line for line in printed.splitlines() if line.startswith("│ doubted "))
    remark = row.split("│")[-2].strip()
    assert remark.startswith("not known: the torque grows with the angle 0.31 times as k, a and F_N say")
    why, constant = remark.removeprefix("not known: ").split("; load the same")
    assert f"samples not usable: {why}; " in alone
    assert f"doubted: load the same{constant}: " in alone
    note = "below 0.15, dry friction and noise of the sensor not declared"
    assert f" {note}" in next(line for line in printed.splitlines() if line.startswith("│ ice "))
    assert f"1 of 2: {note}" in printed
    # The torque has the right sign.
    assert "sign" not in alone


@pytest.fixture
def on_ice(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> Callable[..., Columns]:
    """Columns of a wheel turned on ice, whose torque has noise."""

    def columns(t: np.ndarray, psi: np.ndarray) -> Columns:
        turned = {"t": t, "psi": psi, "F_N": np.full(t.size, 400.0)}
        path, out = write_csv("turned.csv", turned | {"M_z": None}), tmp_path / "torque.csv"
        run("simulate", "--rig", rig, path, "--mu", 0.1, "--out", out)
        noise = np.random.default_rng(1).normal(0, 0.02, t.size)
        return turned | {"M_z": table_of(out)["M_z"] + noise}

    return columns


def test_small_angles_in_degrees_on_ice_ask_for_the_unit_and_not_for_the_sign(
    run: Run, on_ice: Callable[..., Columns], write_csv: Write, rig: Path
) -> None:
    t = np.arange(600) * 0.01
    ice = write_csv("ice.csv", on_ice(t, np.radians(np.sin(t))) | {"psi": np.sin(t)})
    told = run("estimate", "--rig", rig, ice).out

    assert "; if psi is in degrees: --map psi=psi:deg" in told
    assert "sign" not in told
    assert "mu_eff = 0.1" in run("estimate", "--rig", rig, ice, "--map", "psi=psi:deg").out


def test_a_wheel_that_hardly_turned_is_told_so_and_no_unit_of_the_torque(
    run: Run, write_csv: Write, rig: Path
) -> None:
    t = np.arange(60) * 0.01
    noise = np.random.default_rng(1).normal(0, 0.05, t.size)
    columns = {"t": t, "psi": 0.001 * np.sin(3 * t), "F_N": np.full(t.size, 600.0), "M_z": noise}
    still = write_csv("still.csv", columns)
    told = run("estimate", "--rig", rig, still).out
    run("estimate", "--rig", rig, still, "--summary", "table.csv")

    assert "not usable: the wheel hardly turned: by 0.001 rad in 0.59 s; on" in told
    assert "gear" not in told
    remark = rows_of(Path("table.csv"))["still"]["remark"]
    assert remark.startswith("not known: the wheel hardly turned: by 0.001 rad in 0.59 s")


def test_a_wheel_that_turned_too_little_is_told_from_a_stiffness_that_does_not_fit(
    run: Run, on_ice: Callable[..., Columns], write_csv: Write, rig: Path
) -> None:
    rig.write_text(rig.read_text().replace("k = 2.4e6", 'k = { value = 2.4e6, tolerance = "8%" }'))
    t = np.arange(600) * 0.01
    ice = on_ice(t, 0.3 * np.sin(t))
    soft = write_csv("soft.csv", ice | {"M_z": 0.8 * ice["M_z"]})
    short = write_csv("short.csv", {name: values[:12] for name, values in ice.items()})
    printed = run("estimate", "--rig", rig, soft, short, "--jobs", 1, "--summary", "table.csv").out
    rows = rows_of(Path("table.csv"))

    assert "1 of 2: not known: k does not fit" in printed
    assert "1 of 2: not known: turned too little" in printed
    told = (
        "not known: k does not fit: the torque rises 0.82 times as steeply as k, a and F_N say; correct"
    )
    assert rows["soft"]["remark"].startswith(told)
    assert rows["short"]["remark"].startswith("not known: turned too little: turn on, or turn back")


def test_a_summary_of_one(estimate: Run, write_csv: Write) -> None:
    (row,) = json.loads(estimate(write_csv("a.csv"), "--summary", "table.csv", "--json").out)

    assert list(rows_of(Path("table.csv"))) == ["a"]
    assert (row["recording"], row["mu_std"]) == ("a", None)
    assert row["inconsistent"] == 0


def test_no_scheduler(run: Run, write_csv: Write, rig: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    command = ["estimate", write_csv(), "--rig", rig, "--summary", "t.csv"]

    run(*command, "--scheduler", "tcp://127.0.0.1:9").refused("pip install 'brushgrip[cluster]'")


def test_tunings_value_by_value() -> None:
    clean, by_hand = (
        chosen_tuning(*given).tuning  # type: ignore[union-attr]
        for given in (("clean", []), (None, ["mu_walk=0.02, reset_after=7", "gate=9"]))
    )

    assert chosen_tuning(None, None) is None
    assert clean == PROFILES["clean"]
    assert by_hand == Tuning(mu_walk=0.02, reset_after=7, gate=9)


def test_a_ground_is_told_after_its_recordings(
    estimate: Run, write_csv: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    grounds = "brushgrip.wording.recording_remarks.friction_lines_by_ground"
    monkeypatch.setattr(grounds, lambda _: ["note on ice"])
    printed = estimate(write_csv("a.csv"), write_csv("b.csv")).out

    counted = "\nnote on ice\nestimated 2 of 2 recordings; friction is known of 0\n2 of 2: not known: "
    assert counted in printed


def test_a_ground_is_told_from_its_usable_recordings_and_for_each_direction_by_itself() -> None:
    known = [{"ground": "ice", "mu_eff": mu, "mu_eff_std": 0.0} for mu in (0.1, 0.2, 0.3)]
    rest = [{"ground": "ice", "mu_eff": np.nan, "mu_eff_std": np.nan}]
    rest += [known[0], {"ground": "", "mu_eff": "", "mu_eff_std": ""}, {**known[0], "ground": "snow"}]

    # 4.3027 * 0.1 * sqrt(4 / 3), by the table of Student's t.
    told = ["ice: mu_eff up to 0.70 for a further recording, from 3 of 5 recordings"]
    assert friction_lines_by_ground([*known, *rest]) == told
    rows = [
        {"ground": "ice", "direction": "positive", "mu_eff": mu, "mu_eff_std": 0.0}
        | {"mu_eff_positive": 0.2, "mu_eff_std_positive": 0.0, "mu_eff_negative": mu}
        | {"mu_eff_std_negative": 0.0}
        for mu in (0.1, 0.2, 0.3)
    ]
    positive, negative = friction_lines_by_ground(rows)
    assert positive.startswith("note on ice, turning to positive psi: no band")
    assert negative.startswith("ice, turning to negative psi: mu_eff up to 0.70 for a further rec")
