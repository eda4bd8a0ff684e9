"""Every example runs as a script, and prints the number that it claims."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from identification import read_recording, read_signals, read_vehicle
from observers.embedded.fmu import is_supported_host
from symbolic import compiler
from tests.examples.running import EXAMPLES, NUMBER, execute, numbers, printed_by


def truth_of(recording: str) -> float:
    """Friction that was planted, from the table beside the recordings."""
    text = (EXAMPLES / "recordings" / "TRUTH.md").read_text(encoding="utf-8")
    (mu,) = numbers(text, rf"^\| {recording} \| {NUMBER} \|")
    return mu


SCRIPT = """
import runpy, sys
from pathlib import Path
sys.path[0] = sys.argv[1]
for script in sorted(Path(sys.argv[1]).glob("*.py")):
    module = runpy.run_path(str(script), run_name="imported")
    assert callable(module["main"]), script
    assert script.read_text("utf-8").rstrip().splitlines()[-2].startswith("if __name__ =="), script
"""


def python(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """An interpreter started in a folder, which has only this checkout to import from."""
    own = {"PYTHONPATH": str(EXAMPLES.parent), "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-W", "error", *map(str, arguments)]
    return subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **own},
        capture_output=True,
        encoding="utf-8",
        check=False,
        timeout=300,
    )


@pytest.mark.long
def test_every_example_loads_as_a_script(tmp_path: Path) -> None:
    result = python(tmp_path, "-c", SCRIPT, EXAMPLES)

    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


@pytest.mark.long
def test_a_script_prints_what_its_main_function_prints(tmp_path: Path) -> None:
    result = python(tmp_path, EXAMPLES / "observability.py")

    assert result.stdout == printed_by("observability.py", tmp_path)
    assert (result.returncode, result.stderr) == (0, "")


def test_no_example_needs_what_the_wheel_lacks() -> None:
    imports = re.compile(r"^(from|import) (tests|benchmarks)\b", re.MULTILINE)
    texts = {path.name: path.read_text("utf-8") for path in EXAMPLES.glob("*.py")}

    assert [name for name, text in texts.items() if imports.search(text)] == []
    # The rig is no package of the wheel: it stands beside the examples.
    rigs = {name: text for name, text in texts.items() if "\nfrom reference_rig" in text}
    assert [name for name, text in rigs.items() if "\nsys.path.insert(" not in text] == []


def test_rig_recordings(tmp_path: Path) -> None:
    text = printed_by("rig_recordings.py", tmp_path)
    low, high = numbers(text, rf"^M_z from {NUMBER} to {NUMBER} N m$")

    assert text.startswith("1401 samples in 14 s\n")
    assert -10 < low < -5 < 5 < high < 10


@pytest.mark.long
def test_own_reader(tmp_path: Path) -> None:
    text = printed_by("own_reader.py", tmp_path)
    found = {name: float(mu) for name, mu in re.findall(rf"^(\w+): mu = {NUMBER}$", text, re.MULTILINE)}

    assert found.keys() == {"holdout_c", "run"}
    assert found["run"] == pytest.approx(found["holdout_c"], abs=1e-6)


@pytest.mark.parametrize("kind", [None, pytest.param("mhe", marks=pytest.mark.long)])
def test_estimate_in_a_loop(kind: str | None, tmp_path: Path) -> None:
    *track, end = printed_by("estimate_in_a_loop.py", tmp_path, *filter(None, [kind])).splitlines()
    mu, band = numbers(end, rf"^friction at the end: mu_eff = {NUMBER} ± {NUMBER}$")

    assert abs(mu - truth_of("holdout_c")) < 1.5 * band
    assert band < 0.32
    assert "not usable" in track[0]
    assert "not usable" not in track[-1]


@pytest.mark.long
def test_steering_controller(tmp_path: Path) -> None:
    text = printed_by("steering_controller.py", tmp_path)
    without, guessed, observed, known = numbers(text, rf"rms, {NUMBER} after the first second$")
    (mu,) = numbers(text, rf"^the observer's mu_eff at the end: {NUMBER}$")

    assert observed < 0.2 * min(without, guessed)
    assert observed < 6 * known
    assert abs(mu - 0.6) < 0.01


@pytest.mark.long
@pytest.mark.skipif(
    compiler() is None or not is_supported_host(), reason="no C compiler for Linux x86_64 at hand"
)
def test_fmu_in_a_steering_loop(tmp_path: Path) -> None:
    if find_spec("fmpy") is None:
        pytest.skip("FMPy is not installed: pip install 'brushgrip[dev]'")
    text = printed_by("fmu_in_a_steering_loop.py", tmp_path)
    mu, spread = numbers(text, rf"by the FMU: {NUMBER} ± {NUMBER} \(")
    by_fmu, in_python = numbers(text, rf": {NUMBER} mrad rms$")

    assert abs(mu - 0.6) < 0.01
    assert spread < 0.05
    assert by_fmu == in_python < 25


def round_trips(text: str) -> list[tuple[float, ...]]:
    """Difference at most, the same after 1 s, and how many times as fast as Python, of every line."""
    pattern = rf"off by {NUMBER} at most, after 1 s by {NUMBER};.*, {NUMBER} times as fast$"
    return [tuple(map(float, found)) for found in re.findall(pattern, text, flags=re.MULTILINE)]


@pytest.mark.long
@pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")
def test_embedded_round_trip(tmp_path: Path) -> None:
    trips = round_trips(printed_by("embedded_round_trip.py", tmp_path))

    assert len(trips) == 6
    for double, single in zip(trips[::2], trips[1::2], strict=True):
        assert max(double[:2]) <= 1e-12
        assert single[0] < 1e-4
        assert single[1] < 5e-5
    assert min(times for *_, times in trips[:2]) > 20


@pytest.mark.long
@pytest.mark.measured
@pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")
def test_embedded_round_trip_measured(tmp_path: Path, measured_dir: Path) -> None:
    text = printed_by("embedded_round_trip.py", tmp_path, str(measured_dir / "fem4_ident.mat"))
    trips = round_trips(text)

    assert "fem4_ident, 2201 samples, MHE" in text
    assert len(trips) == 4
    assert all(double <= 1e-12 for double, *_ in trips[::2])
    # The largest of them is that of samples while friction is acquired.
    assert all(single < 1e-4 for _, single, _ in trips[1::2])


@pytest.mark.long
def test_find_the_missing_effect(tmp_path: Path) -> None:
    text = printed_by("find_the_missing_effect.py", tmp_path)
    values = dict(re.findall(rf"^(\w+: \w+) = {NUMBER}", text, flags=re.MULTILINE))
    before, after = numbers(text, rf"torque error \w+: {NUMBER}% of range$")

    assert set(values) == {"rate_friction: c", "carcass_torsion: k_t"}
    assert abs(float(values["rate_friction: c"]) - 0.04) < 0.002
    assert abs(float(values["carcass_torsion: k_t"]) - 400) < 30
    assert before > 1.5
    assert after < 0.45


def test_left_out_search_says_what_it_needs_before_it_searches(tmp_path: Path) -> None:
    lost = tmp_path / "nowhere" / "page.md"
    printed = [
        execute("left_out_search.py", tmp_path, tmp_path, *more) for more in ((), ("--out", lost))
    ]

    assert [each.status for each in printed] == [2, 2]
    assert f"{tmp_path} holds 0 recordings; three are needed" in printed[0].err
    assert f"there is no folder {lost.parent}; make it first" in printed[1].err


@pytest.mark.long
def test_free_decay(tmp_path: Path) -> None:
    text = printed_by("free_decay.py", tmp_path, "decay.png", leaves="decay.png")
    off = map(abs, numbers(text, rf": off by {NUMBER} % and {NUMBER} %$"))
    (mu,) = numbers(text, rf"^friction from 7 contacts: mu = {NUMBER}, each")

    k, b_t, k_sticking, b_t_sticking, _, b_t_source = off
    assert k < 0.1
    assert b_t < 0.5
    assert k_sticking > 1
    assert min(b_t_sticking, b_t_source) > 4
    assert mu == pytest.approx(1.674, rel=0.03)


@pytest.mark.long
def test_change_of_surface(tmp_path: Path) -> None:
    text = printed_by("change_of_surface.py", tmp_path, "change.png", leaves="change.png")
    turn = r"[.\d]+|inf"
    turns: dict[str, dict[float, tuple[float, float]]] = {}
    for patch, table in re.findall(
        r"^ *([^,\n]*(?:, [a-z ]+)?), [\d.]+ -> .*\n((?:.* rad, .*\n)+)", text, re.MULTILINE
    ):
        rows = re.findall(
            rf"^ *{NUMBER} rad *({turn}) rad, *\d+ *({turn}) rad, *\d+$", table, re.MULTILINE
        )
        turns[patch] = {float(place): (float(ekf), float(mhe)) for place, ekf, mhe in rows}
    (known,) = re.findall(
        rf"known in mid-turn, bristles: EKF after {NUMBER} rad, MHE after {NUMBER} rad", text
    )

    assert tuple(map(float, known)) == turns["bristles"][0.35]
    page = (Path(__file__).parents[2] / "docs" / "start" / "controller.md").read_text(encoding="utf-8")
    assert f"know the fall after {known[0]} rad" in page
    for place, (ekf, mhe) in turns["bristles"].items():
        # Close to the reversal the torque does not tell.
        assert max(ekf, mhe) <= 0.2 or place <= 0.15
    for place in (0.35, 0.45):
        assert max(turns["exact patch"][place]) <= 0.1
        assert turns["bristles, friction rises"][place][0] < 0.55
        assert max(turns["bristles, default tuning"][place]) < 0.4


@pytest.mark.long
def test_observability(tmp_path: Path) -> None:
    text = printed_by("observability.py", tmp_path, "information.png", leaves="information.png")
    out, back = (
        {
            float(angle): float(share)
            for angle, share in re.findall(rf"^ *{NUMBER} rad *{NUMBER}", part, re.MULTILINE)
        }
        for part in text.split("back, since the reversal")
    )
    (blind,) = numbers(text, rf"blind again {NUMBER} rad after the reversal")
    reached, limit = numbers(text, rf"one sample: std {NUMBER}, noise / \(.*\) = {NUMBER}$")

    assert "first sample: dM_z/dmu = 0 N m" in text
    assert reached == pytest.approx(limit, rel=0.01)
    assert abs(out[0.002]) < 0.001
    assert list(out.values()) == sorted(out.values(), reverse=True)
    assert back[0.1] < 0 < back[0.2]
    assert 0.1 < blind < 0.2


@pytest.mark.long
def test_trade_offs(tmp_path: Path) -> None:
    text = printed_by("trade_offs.py", tmp_path, "trade.png", leaves="trade.png")
    low_a, high_a, low_k, high_k = numbers(text, rf"95 % interval {NUMBER} to {NUMBER}, best [\d.e+]+$")
    (within,) = numbers(text, rf"mu a keeps within {NUMBER}%$")

    assert "e = 0 mm, a over a as declared: every value from 0.8 to 1.2 fits" in text
    assert within < 0.05
    assert low_a < 1 < high_a
    assert low_k < 2.4e6 < high_k


@pytest.mark.long
def test_measured_evaluation(tmp_path: Path) -> None:
    text = printed_by("measured_evaluation.py", tmp_path, "--pictures", "drawn", leaves="drawn")
    filtered, by_ekf, bare, by_ekf_bare = numbers(
        text, rf"M_z by {NUMBER} N m; mu off by {NUMBER} \(EKF\), \S+ \(root\)$"
    )
    beyond = dict(re.findall(rf"^(\w+): .* more than five {NUMBER}%", text, re.MULTILINE))

    assert filtered < 0.1 * bare
    assert by_ekf < 0.01 < 0.04 < by_ekf_bare
    assert (float(beyond["holdout_c"]) > 10) != (float(beyond["holdout_d"]) > 10)
    assert (tmp_path / "drawn" / "zones.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
@pytest.mark.measured
def test_measured_evaluation_measured(tmp_path: Path, measured_dir: Path) -> None:
    text = printed_by("measured_evaluation.py", tmp_path, data=measured_dir)
    counted = numbers(text, rf"as the author counts: zones {NUMBER}%, direction {NUMBER}%")

    assert [share > 98 for share in counted] == [True] * 8


@pytest.mark.long
def test_thesis_simulation(tmp_path: Path) -> None:
    text = printed_by("thesis_simulation.py", tmp_path, "sim.png", leaves="sim.png")
    turns = numbers(text, rf"^turns back at {NUMBER} s, {NUMBER} s; ")
    zones = re.findall(rf"^t = {NUMBER} s: (\d+) zones, ", text, re.MULTILINE)
    (exact,) = numbers(text, rf"^error of M_z over its range: {NUMBER} in")
    source = numbers(text, rf"^201 bristles, .*: {NUMBER}$")

    assert turns == pytest.approx([1.25, 2.4], abs=0.02)
    assert zones == [("0.5", "3"), ("1.75", "5"), ("3.0", "7"), ("5.1", "3")]
    assert exact < 1e-6 < 100 * exact < min(source)


@pytest.mark.long
@pytest.mark.measured
def test_thesis_simulation_published(tmp_path: Path, measured_dir: Path, simulation_dir: Path) -> None:
    text = printed_by("thesis_simulation.py", tmp_path, data=measured_dir)
    pattern = rf"against (\w+)(?: bristles)?: psi {NUMBER}, M_z {NUMBER} of range$"
    off = {
        scheme: max(float(psi), float(M_z))
        for scheme, psi, M_z in re.findall(pattern, text, re.MULTILINE)
    }

    assert simulation_dir.is_dir()
    assert off["exact"] < 3e-4
    # The files are the 201 bristles of [Györök 2022] to the last digits that matter.
    assert off["201"] < 3e-5


def test_patch_animation(tmp_path: Path) -> None:
    text = printed_by("patch_animation.py", tmp_path, "--out", "film", "--frames", "4", leaves="film")

    gif, page = tmp_path / "film" / "patch.gif", tmp_path / "film" / "patch.html"
    assert "zones on the way: 1, 3, 5, 7" in text
    assert gif.read_bytes().startswith(b"GIF89a")
    assert page.read_text("utf-8").count("data:image/png;base64,") == 4
    assert "http" not in page.read_text("utf-8").split("<script>")[0]
    assert gif.stat().st_size + page.stat().st_size < 1e6


@pytest.mark.long
def test_towing(tmp_path: Path) -> None:
    text = printed_by("towing.py", tmp_path, "tows.png", leaves="tows.png")
    rows = numbers(text, rf"planted {NUMBER}, F = mu N gives {NUMBER} ± {NUMBER},")
    shares = numbers(text, rf"in {NUMBER}% of 400 sets$")

    for planted, found, spread in np.reshape(rows, (3, 3)):
        assert abs(found - planted) < 4 * spread < 0.1 * planted
    assert all(91 < share < 98 for share in shares)


@pytest.mark.long
def test_own_effect(tmp_path: Path) -> None:
    found, errors = printed_by("own_effect.py", tmp_path).splitlines()
    value, spread = numbers(found, rf"^found boot_spring: c = {NUMBER} ± {NUMBER} N m/rad\^3$")
    before, after = numbers(errors, rf"^error {NUMBER}% of range before, {NUMBER}% after$")

    assert abs(value - 80) < 3 * spread
    assert after < 0.4 < 0.5 * before


@pytest.mark.parametrize(
    ("script", "first", "published"),
    [
        ("second_rig.py", "harmonic_00", "friction-damper"),
        ("changing_friction.py", "tension_20lb_0.5Hz", "changed-friction"),
    ],
)
def test_a_damper_says_that_it_has_no_recordings(
    tmp_path: Path, script: str, first: str, published: str
) -> None:
    shown = printed_by(script, tmp_path)

    assert shown.startswith(f"skipped: no {first}.npz")
    assert f"brushgrip fetch {published}" in shown


@pytest.mark.long
def test_least_steering(tmp_path: Path) -> None:
    text = printed_by("least_steering.py", tmp_path, "steering.png", leaves="steering.png")
    cells = {row[0]: row[1:] for row in (re.findall(r"[\w.]+", line) for line in text.splitlines()[1:])}

    assert [*cells] == ["ice", "snow", "wet", "dry"]
    for mu, probe, _, found, sine, _, _ in cells.values():
        assert float(probe) < min(0.2, 1.3 * float(sine))
        assert float(found) == pytest.approx(float(mu), rel=0.08)
    for ground in ("ice", "snow"):
        assert float(cells[ground][1]) < 0.3 * float(cells[ground][4])


def test_live_session(tmp_path: Path) -> None:
    text = printed_by("live_session.py", tmp_path, "live.png", leaves="live.png")
    (usable,) = numbers(text, rf"usable from {NUMBER} s on$")
    mu, band = numbers(text, rf"friction was {NUMBER} ± {NUMBER} at 14 s, last usable$")

    assert text.startswith("1401 samples")
    assert 1 < usable < 7
    assert abs(mu - truth_of("holdout_d")) < band < 0.25


@pytest.mark.long
def test_lower_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    smaller = {"MUS": (0.02, 0.1, 0.9), "SHARES": (0.0005, 0.04), "LOADS": (1.0,)}
    smaller |= {"SEEDS": range(2), "MANY": range(2)}
    for name, values in smaller.items():
        monkeypatch.setattr(f"lower_limit.{name}", values)
    text = printed_by("lower_limit.py", tmp_path, "limit.png", leaves="limit.png")
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines()]
    cells = {name: rest for name, *rest in rows}

    for wheel in ("rig", "car"):
        assert cells[f"{wheel}, noise alone"] == ["0.02", "0.1"]
        assert cells[f"{wheel}, zero alone"] == ["0.02", "0.02"]
        assert cells[f"{wheel}, dry alone"] == ["0.02", "0.9"]
    assert cells["car, torque of the column"] == ["never"] * 5
    assert "never" not in cells["rig"]
    for load in ("400 N", "4000 N"):
        # What is declared is never usable and wrong.
        assert cells[f"{load}, declared"][::2] == ["8", "0"]


@pytest.mark.long
def test_a_drive_off_by_the_estimate_slips_as_one_by_the_truth(tmp_path: Path) -> None:
    text = printed_by("drive_off.py", tmp_path)
    pair = rf" +{NUMBER} s of +{NUMBER} s"
    row = re.compile(rf"^([a-z ]+?) +{NUMBER}{3 * pair} +mu = (nan|{NUMBER})", re.MULTILINE)
    rows = {found[1].strip(): found for found in row.finditer(text)}

    assert set(rows) == {"ice", "snow", "wet cobbles", "dry asphalt"}
    for ground in rows:
        mu, slip, _, true, time, by_estimate, own_time, found = map(float, rows[ground].groups()[1:9])
        assert abs(by_estimate - true) <= 0.1 * max(true, slip), ground
        assert own_time == pytest.approx(time, rel=0.1), ground
        assert found == pytest.approx(mu, rel=0.1), ground
    assert float(rows["snow"][3]) > 5 > 0.1 > float(rows["snow"][7])


@pytest.mark.long
def test_logs_of_a_car_to_try(tmp_path: Path) -> None:
    pytest.importorskip("can", reason="needs brushgrip[can]")
    assert execute("car_log.py", tmp_path, "logs").out.count("on mu = 0.8") == 3
    vehicle = read_vehicle(tmp_path / "logs" / "car.toml")
    signals = read_signals(tmp_path / "logs" / "car.toml")
    log = read_recording(tmp_path / "logs" / "one.blf", vehicle=vehicle, signals=signals)

    assert log.standstills is not None
    assert log.standstills.brakes == (True,)
    assert 350 < np.ptp(log.M_z) < 550
