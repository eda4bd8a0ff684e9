import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("interpreted")
Run = Callable[..., Any]
Write = Callable[..., Path]


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A model with a torque offset, which belongs to the recording named run."""
    content = {
        "version": 1,
        "effects": ["torque_offset"],
        "shared": {"k": 2.4e6},
        "recordings": {"run": {"mu": 0.9, "torque_offset.M_0": 0.5}},
    }
    path = tmp_path / "model.json"
    path.write_text(json.dumps(content))
    return path


def read(path: Path) -> np.ndarray:
    assert path.read_text().splitlines()[0] == "t,M_z"
    return np.loadtxt(path, delimiter=",", skiprows=1)


def test_one_recording(run: Run, write_csv: Write, rig: Path, tmp_path: Path, table: Any) -> None:
    out = tmp_path / "new" / "out.csv"
    outcome = run("simulate", "--rig", rig, write_csv(), "--out", out)
    rows = read(out)

    assert outcome.status == 0
    assert np.array_equal(rows[:, 0], table["t"])
    # Full slide bounds the torque: 3/8 mu F_N a for e = 0, less than 5 % more for this caster.
    assert 0.5 < np.abs(rows[:, 1]).max() / (0.375 * 1.2 * 400 * 0.045) < 1.05
    first_turn = slice(1, 15)
    assert (rows[first_turn, 1] < 0).all()


def test_no_torque_is_needed(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    with_torque, without = tmp_path / "with.csv", tmp_path / "without.csv"
    run("simulate", "--rig", rig, write_csv("run.csv"), "--out", with_torque)
    run("simulate", "--rig", rig, write_csv("bare.csv", {"M_z": None}), "--out", without)

    assert without.read_text() == with_torque.read_text()


def test_several_recordings(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    paths = [write_csv(f"{name}.csv", {"M_z": None}) for name in "ab"]
    outcome = run("simulate", "--rig", rig, *paths, "--out", tmp_path / "out.csv")

    assert outcome.status == 0
    assert not (tmp_path / "out.csv").exists()
    assert (tmp_path / "out_a.csv").read_text() == (tmp_path / "out_b.csv").read_text()


def test_all_or_nothing(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    good = write_csv("good.csv")
    bad = write_csv("bad.csv", top="# k = 1e12\n")
    outcome = run("simulate", "--rig", rig, good, bad, "--out", tmp_path / "out.csv")

    assert outcome.status == 2
    assert "k must lie between" in outcome.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv", "good.csv", "rig.toml"]


def test_mu_is_needed(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    rig.write_text(rig.read_text().replace("mu = 1.2", ""))
    path, out = write_csv(), tmp_path / "out.csv"
    outcome = run("simulate", "--rig", rig, path, "--out", out)

    assert outcome.status == 2
    assert outcome.err.startswith("brushgrip: run: mu is not known; ")
    assert not out.exists()


def test_a_recording_gives_its_own_mu(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    own, common = tmp_path / "own.csv", tmp_path / "common.csv"
    run("simulate", "--rig", rig, write_csv(top="# mu = 1.2\n"), "--out", own)
    run("simulate", "--rig", rig, write_csv(), "--out", common)

    assert own.read_text() == common.read_text()


def test_found_model_knows_the_recording(
    run: Run, write_csv: Write, rig: Path, model: Path, tmp_path: Path
) -> None:
    found, declared = tmp_path / "found.csv", tmp_path / "declared.csv"
    path = write_csv("run.csv")
    run("simulate", "--rig", rig, "--model", model, path, "--out", found)
    rig.write_text(rig.read_text().replace("mu = 1.2", "mu = 0.9"))
    run("simulate", "--rig", rig, path, "--out", declared)

    assert np.allclose(read(found)[:, 1], read(declared)[:, 1] + 0.5, atol=1e-12)


def test_found_model_on_another_recording(
    run: Run, write_csv: Write, rig: Path, model: Path, tmp_path: Path
) -> None:
    found, declared = tmp_path / "found.csv", tmp_path / "declared.csv"
    path = write_csv("another.csv")
    run("simulate", "--rig", rig, "--model", model, path, "--out", found)
    run("simulate", "--rig", rig, path, "--out", declared)

    assert np.allclose(read(found), read(declared), atol=1e-12)


def test_bad_model_file(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    outcome = run("simulate", "--rig", rig, "--model", rig, write_csv(), "--out", tmp_path / "o.csv")

    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert str(rig) in outcome.err


def test_friction_from_the_command_line(
    run: Run, write_csv: Write, rig: Path, tmp_path: Path, model: Path
) -> None:
    path, files = (
        write_csv("run.csv"),
        [tmp_path / f"{name}.csv" for name in ("given", "declared", "model")],
    )
    bare = tmp_path / "bare.toml"
    bare.write_text(rig.read_text().replace("mu = 1.2", "mu = 0.7"))
    run("simulate", "--rig", bare, path, "--out", files[0], "--mu", 1.2)
    run("simulate", "--rig", rig, path, "--out", files[1])
    run("simulate", "--rig", rig, path, "--out", files[2], "--model", model, "--mu", 1.2)

    assert files[0].read_text() == files[1].read_text()
    # That of the model file differs by its torque offset alone.
    np.testing.assert_allclose(read(files[2])[:, 1] - read(files[1])[:, 1], 0.5, atol=1e-9)
    assert (
        "--mu must be finite and greater than 0, got -1"
        in run("simulate", "--rig", rig, path, "--out", files[0], "--mu", -1).err
    )
