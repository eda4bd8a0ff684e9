from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference_rig import make_ground_recording, make_steering_recording

pytestmark = pytest.mark.usefixtures("interpreted")
Run = Callable[..., Any]
Write = Callable[..., Path]
HEADER = "t,mu,mu_std,M_z_predicted,informed,usable,mu_eff,mu_eff_std,M_slide,nis,status"
each_observer = pytest.mark.parametrize("observer", ["ekf", "mhe"])
every_observer = pytest.mark.parametrize("observer", ["ekf", "mhe", "root"])


def estimate(run: Run, rig: Path, path: Path, out: Path, observer: str = "ekf", *options: object) -> Any:
    return run("estimate", "--rig", rig, "--observer", observer, path, "--out", out, *options)


def columns_of(path: Path) -> dict[str, np.ndarray]:
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: table[name] for name in HEADER.split(",")}


def assert_one_line(outcome: Any, *words: str) -> None:
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1
    for word in words:
        assert word in outcome.err


@pytest.fixture
def simulated(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> Path:
    """A recording whose torque is the declared model's, with mu = 1.2 as in the rig."""
    run("simulate", "--rig", rig, write_csv("bare.csv"), "--out", tmp_path / "torque.csv")
    torque = np.loadtxt(tmp_path / "torque.csv", delimiter=",", skiprows=1)[:, 1]
    return write_csv("run.csv", {"M_z": torque})


@each_observer
def test_one_row_a_sample(run: Run, simulated: Path, rig: Path, tmp_path: Path, observer: str) -> None:
    out = tmp_path / "new" / "mu.csv"
    outcome = estimate(run, rig, simulated, out, observer)
    header, *rows = out.read_text().splitlines()
    numbers = np.array([[cell or "nan" for cell in r.split(",")] for r in rows], dtype=float).T
    t, mu, mu_std, predicted, informed, usable, mu_eff, mu_eff_std, M_slide, nis, _ = numbers

    assert outcome.status == 0
    assert header == HEADER
    assert np.array_equal(t, np.loadtxt(simulated, delimiter=",", skiprows=1)[:, 0])
    assert {row.split(",")[4] for row in rows} <= {"0", "1"}
    assert {row.split(",")[-1] for row in rows} <= {str(flags) for flags in range(4096)}
    np.testing.assert_allclose(mu_eff, mu, rtol=1e-12)
    np.testing.assert_allclose(mu_eff_std, mu_std, rtol=1e-12)
    assert (M_slide > 0).all()
    assert (nis[np.isfinite(nis)] >= 0).all()
    assert np.isfinite(nis).any()
    assert (mu > 0).all()
    assert mu_std[-1] < mu_std[0]
    assert informed[0] == 0
    assert (usable <= informed).all()
    assert np.isfinite(predicted).all()
    assert (tmp_path / "new" / "mu.png").read_bytes().startswith(b"\x89PNG")


@every_observer
def test_a_later_sample_changes_nothing_before(
    run: Run, simulated: Path, rig: Path, tmp_path: Path, observer: str
) -> None:
    lines = simulated.read_text().splitlines()
    for row in range(36, 46):
        t, _, M_z, _ = lines[row].split(",")
        lines[row] = f"{t},,{M_z},"
    simulated.write_text("\n".join(lines) + "\n")
    cut = tmp_path / "cut.csv"
    cut.write_text("\n".join(lines[:41]) + "\n")
    whole_out, cut_out = tmp_path / "whole_mu.csv", tmp_path / "cut_mu.csv"
    estimate(run, rig, simulated, whole_out, observer)
    estimate(run, rig, cut, cut_out, observer)

    assert whole_out.read_text().startswith(cut_out.read_text())


def test_does_not_write_over_what_it_reads(run: Run, simulated: Path, rig: Path) -> None:
    before = simulated.read_text()
    outcome = estimate(run, rig, simulated, simulated)

    assert outcome.status == 2
    assert "overwrite" in outcome.err
    assert simulated.read_text() == before


def test_picture_does_not_replace_the_table(
    run: Run, simulated: Path, rig: Path, tmp_path: Path
) -> None:
    outcome = estimate(run, rig, simulated, tmp_path / "mu.png")

    assert outcome.status == 2
    assert ".csv" in outcome.err
    assert not (tmp_path / "mu.png").exists()


def test_unknown_observer(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    out = tmp_path / "mu.csv"
    outcome = run("estimate", "--rig", rig, "--observer", "crystal", simulated, "--out", out)

    assert outcome.status == 2
    assert "ekf" in outcome.err
    assert not out.exists()


@pytest.fixture
def steered(write_csv: Write) -> Path:
    """A recording of the steering torque alone, mu = 1.3."""
    recorded = make_steering_recording(3, duration=4.0)
    columns = {"t": recorded.t, "psi": recorded.psi, "M_z": None, "F_N": recorded.F_N, "M": recorded.M}
    return write_csv("steered.csv", columns)


@pytest.fixture
def steering_rig(rig: Path) -> Path:
    rig.write_text(rig.read_text().replace("e = 0.009\n", "e = 0.009\nJ_A = 0.15\nb_t = 1.0\n"))
    return rig


@pytest.mark.parametrize("observer", ["ekf", pytest.param("mhe", marks=pytest.mark.long)])
def test_from_the_steering_torque(
    run: Run, steered: Path, steering_rig: Path, tmp_path: Path, observer: str
) -> None:
    outcome = estimate(run, steering_rig, steered, tmp_path / "mu.csv", observer)
    estimated = columns_of(tmp_path / "mu.csv")

    assert outcome.status == 0
    assert estimated["informed"][-1] == 1
    assert abs(estimated["mu"][-1] - 1.3) < 3 * estimated["mu_std"][-1]
    assert estimated["mu_std"][-1] < 0.1


def test_steering_torque_needs_the_wheel(run: Run, steered: Path, rig: Path, tmp_path: Path) -> None:
    outcome = estimate(run, rig, steered, tmp_path / "mu.csv")

    assert_one_line(outcome, "steered: ", "lacks J_A and b_t", "kg m^2")
    assert not (tmp_path / "mu.csv").exists()


def test_aligning_torque_goes_first(
    run: Run, simulated: Path, write_csv: Write, rig: Path, tmp_path: Path
) -> None:
    M_z = np.genfromtxt(simulated, delimiter=",", names=True)["M_z"]
    both = write_csv("both.csv", {"M_z": M_z, "M": np.full(M_z.size, 5.0)})
    estimate(run, rig, simulated, tmp_path / "one.csv")
    estimate(run, rig, both, tmp_path / "two.csv")

    assert (tmp_path / "one.csv").read_text() == (tmp_path / "two.csv").read_text()


def test_root_has_no_standard_deviation(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "root")
    header, *rows = (tmp_path / "mu.csv").read_text().splitlines()
    estimated = columns_of(tmp_path / "mu.csv")

    assert outcome.status == 0
    assert header == HEADER
    assert {row.split(",")[2] for row in rows} == {""}
    assert np.median(estimated["mu"][estimated["informed"] == 1]) == pytest.approx(1.2, abs=1e-3)
    assert "±" not in outcome.out
    assert (tmp_path / "mu.png").read_bytes().startswith(b"\x89PNG")


def test_root_knows_no_effects(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    model.write_text('{"version": 1, "effects": [], "shared": {"k": 2.4e6}, "recordings": {}}')
    outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "root", "--model", model)

    assert_one_line(outcome, "root", "--model", "ekf")
    assert not (tmp_path / "mu.csv").exists()


def test_root_needs_the_aligning_torque(
    run: Run, steered: Path, steering_rig: Path, tmp_path: Path
) -> None:
    assert_one_line(
        estimate(run, steering_rig, steered, tmp_path / "mu.csv", "root"), "root", "M_z", "mhe"
    )


@each_observer
def test_says_that_the_ground_has_changed(
    run: Run, write_csv: Write, rig: Path, tmp_path: Path, observer: str
) -> None:
    recorded = make_ground_recording(31, lambda t: np.where(t < 7, 1.5, 0.4))
    names = ("t", "psi", "M_z", "F_N")
    path = write_csv("ground.csv", {name: getattr(recorded, name) for name in names})
    outcome = estimate(run, rig, path, tmp_path / "mu.csv", observer)
    summary, _ = outcome.out.splitlines()

    assert summary.startswith("ground: mu = 0.4")
    assert "1 change of the ground" in summary
    assert columns_of(tmp_path / "mu.csv")["mu"][-1] == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize(
    ("column", "factor", "cause"),
    [
        ("psi", 180 / np.pi, "degrees"),
        ("t", 1e3, "milliseconds"),
        ("F_N", 1e-3, "kN"),
        ("M_z", -1.0, "other sign"),
    ],
)
def test_other_units_and_signs_are_refused_by_name(
    run: Run,
    write_csv: Write,
    simulated: Path,
    rig: Path,
    tmp_path: Path,
    column: str,
    factor: float,
    cause: str,
) -> None:
    names = simulated.read_text().splitlines()[0].split(",")
    columns = dict(zip(names, np.loadtxt(simulated, delimiter=",", skiprows=1).T, strict=True))
    wrong = write_csv("wrong.csv", columns | {column: factor * columns[column]})

    assert_one_line(estimate(run, rig, wrong, tmp_path / "mu.csv"), "wrong", cause)
    assert not (tmp_path / "mu.csv").exists()


def test_tuning_by_name(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    ends = {}
    for name in ("real_tyre", "clean"):
        outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "ekf", "--tuning", name)
        assert outcome.status == 0
        ends[name] = columns_of(tmp_path / "mu.csv")["mu_std"][-1]
    assert ends["clean"] < 0.7 * ends["real_tyre"]
    outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "root", "--tuning", "clean")
    assert_one_line(outcome, "root has no tuning")


def test_picture_goes_where_it_is_wanted(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    wanted = tmp_path / "pictures" / "friction.PNG"
    outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "ekf", "--picture", wanted)

    assert outcome.status == 0
    assert wanted.read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / "mu.png").exists()


def test_picture_is_a_png(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    wanted = tmp_path / "mu.pdf"
    outcome = estimate(run, rig, simulated, tmp_path / "mu.csv", "ekf", "--picture", wanted)

    assert_one_line(outcome, str(wanted), ".png")
    assert not (tmp_path / "mu.csv").exists()


def test_smoothed_friction_is_known_from_the_start(
    run: Run, simulated: Path, rig: Path, tmp_path: Path
) -> None:
    outcome = run(
        "estimate",
        "--rig",
        rig,
        "--observer",
        "ekf",
        "--smooth",
        simulated,
        "--out",
        tmp_path / "mu.csv",
    )
    causal = tmp_path / "causal.csv"
    estimate(run, rig, simulated, causal)
    smoothed, filtered = columns_of(tmp_path / "mu.csv"), columns_of(causal)

    assert outcome.status == 0
    assert smoothed["mu_std"][0] < 0.5 * filtered["mu_std"][0]
    # The smoother begins about what the filter ends with, and linearises there.
    assert abs(smoothed["mu"][-1] - filtered["mu"][-1]) < 0.1 * filtered["mu_std"][-1]


def test_only_the_filter_smooths(run: Run, simulated: Path, rig: Path, tmp_path: Path) -> None:
    out = tmp_path / "mu.csv"
    outcome = run("estimate", "--rig", rig, "--observer", "mhe", "--smooth", simulated, "--out", out)

    assert_one_line(outcome, "--smooth", "--observer ekf")
    assert not out.exists()
