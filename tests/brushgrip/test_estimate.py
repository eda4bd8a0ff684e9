from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]
Write = Callable[..., Path]
each_observer = pytest.mark.parametrize("observer", ["ekf", "mhe"])


def estimate(run: Run, rig: Path, path: Path, out: Path, observer: str = "ekf") -> Any:
    return run("estimate", "--rig", rig, "--observer", observer, path, "--out", out)


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
    t, mu, mu_std, predicted, informed = np.array([r.split(",") for r in rows], dtype=float).T

    assert outcome.status == 0
    assert header == "t,mu,mu_std,M_z_predicted,informed"
    assert np.array_equal(t, np.loadtxt(simulated, delimiter=",", skiprows=1)[:, 0])
    assert {row.split(",")[-1] for row in rows} <= {"0", "1"}
    assert (mu > 0).all()
    assert mu_std[-1] < mu_std[0]
    assert informed[0] == 0
    assert np.isfinite(predicted).all()
    assert (tmp_path / "new" / "mu.png").read_bytes().startswith(b"\x89PNG")


@each_observer
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
