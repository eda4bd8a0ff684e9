"""`brushgrip simulate`: the torque of the declared model and of one that was found."""

import json
from pathlib import Path

import numpy as np
import pytest

from brushgrip.outputs.provenance import provenance_of
from tests.brushgrip.helpers import Run, Write, table_of, write_model

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.fixture(autouse=True)
def model(write_csv: Write) -> Path:
    """A model with a torque offset, which belongs to the recording run.csv."""
    return write_model(
        effects=["torque_offset"],
        recordings={"run": {"mu": 0.9, "torque_offset.M_0": 0.5}},
        rig={"run": {"a": 0.045, "e": 0.009}},
        provenance=provenance_of([write_csv("run.csv")]),
    )


@pytest.fixture
def simulate(run: Run, rig: Path) -> Run:
    return lambda *arguments, out="out.csv": run("simulate", "--rig", rig, *arguments, "--out", out)


def test_one_recording(simulate: Run, write_csv: Write, table: dict[str, np.ndarray]) -> None:
    assert simulate(write_csv(), out="new/out.csv").status == 0
    simulated = table_of(Path("new/out.csv"))

    assert list(simulated) == ["t", "M_z"]
    assert np.array_equal(simulated["t"], table["t"])
    # Full slide bounds the torque: 3/8 mu F_N a for e = 0, less than 5 % more for this caster.
    assert 0.5 < np.abs(simulated["M_z"]).max() / (0.375 * 1.2 * 400 * 0.045) < 1.05
    assert (simulated["M_z"][1:15] < 0).all()


def test_neither_torque_nor_whose_mu_it_is_matters(simulate: Run, write_csv: Write) -> None:
    for name, columns, top in (
        ("run", {}, ""),
        ("bare", {"M_z": None}, ""),
        ("own", {}, "# mu = 1.2\n"),
    ):
        simulate(write_csv(f"{name}.csv", columns, top), out=f"{name}_out.csv")

    assert len({Path(f"{name}_out.csv").read_text() for name in ("run", "bare", "own")}) == 1


def test_several_recordings(simulate: Run, write_csv: Write) -> None:
    assert simulate(*(write_csv(f"{name}.csv", {"M_z": None}) for name in "ab")).status == 0
    assert not Path("out.csv").exists()
    assert Path("out_a.csv").read_text() == Path("out_b.csv").read_text()


def test_a_found_model_knows_its_recordings(simulate: Run, write_csv: Write, rig: Path) -> None:
    path, other = write_csv("run.csv"), write_csv("another.csv")
    simulate("--model", "model.json", path, out="found.csv")
    simulate("--model", "model.json", other, out="another_found.csv")
    simulate(other, out="another_declared.csv")
    rig.write_text(rig.read_text().replace("mu = 1.2", "mu = 0.9"))
    simulate(path, out="declared.csv")
    torque = {p.stem: table_of(p)["M_z"] for p in Path().glob("*found.csv")}
    torque |= {p.stem: table_of(p)["M_z"] for p in Path().glob("*declared.csv")}

    np.testing.assert_allclose(torque["found"], torque["declared"] + 0.5, atol=1e-12)
    np.testing.assert_allclose(torque["another_found"], torque["another_declared"], atol=1e-12)


@pytest.mark.parametrize("behind", ["the file", "another of its name", "unknown"])
def test_what_was_fitted_is_for_that_very_file(
    simulate: Run, write_csv: Write, model: Path, behind: str
) -> None:
    if behind == "unknown":
        model.write_text(json.dumps(json.loads(model.read_text()) | {"provenance": None}))
    path = write_csv("run.csv", {"M_z": None} if behind == "another of its name" else {})
    said = simulate("--model", model, path, out="run_out.csv").out
    simulate(write_csv("new.csv"), "--model", model, out="new_out.csv")

    alike = Path("run_out.csv").read_text() == Path("new_out.csv").read_text()
    assert alike == (behind != "the file")
    fitted = "run: mu = 0.9 (fitted to this recording), a = 0.045 m and e = 0.009 m (fitted to this rec"
    other = "run: mu = 1.2 (declared), a = 0.045 m and e = 0.009 m (declared); not known as a file"
    assert (other if alike else fitted) in said


def test_friction_from_the_command_line(simulate: Run, write_csv: Write, rig: Path) -> None:
    path = write_csv("run.csv")
    simulate(path, out="declared.csv")
    said = simulate(path, "--model", "model.json", "--mu", 1.2, out="model.csv").out
    assert "mu = 1.2 (--mu)" in said
    assert "; mu_eff, which estimate tells, is 1.20 at 400 N" in said
    rig.write_text(rig.read_text().replace("mu = 1.2", "mu = 0.7"))
    simulate(path, "--mu", 1.2, out="given.csv")
    declared, found = (table_of(Path(f"{name}.csv"))["M_z"] for name in ("declared", "model"))

    assert Path("given.csv").read_text() == Path("declared.csv").read_text()
    # That of the model file differs by its torque offset alone.
    np.testing.assert_allclose(found - declared, 0.5, atol=1e-9)
