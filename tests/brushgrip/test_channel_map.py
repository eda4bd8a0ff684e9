"""`--map` and `[signals]` at the commands: friction does not depend on how a recording was kept."""

import json
from pathlib import Path

import numpy as np
import pytest

from brushgrip.inputs.command_inputs import locate_inputs
from identification import read_recording, read_rig
from tests.brushgrip.helpers import Run, table_of
from tests.identification.reading.logs import MAP, as_logged, write_german
from tests.refusal import refused

pytestmark = pytest.mark.usefixtures("interpreted")
FOLDER = Path(__file__).parents[2] / "examples" / "recordings"


@pytest.fixture
def logged(tmp_path: Path) -> Path:
    """holdout_c.csv as another measurement system would have kept it."""
    one = read_recording(FOLDER / "holdout_c.csv", read_rig(FOLDER / "rig.toml"))
    write_german(tmp_path / "run.csv", as_logged(one.t, one.psi, one.M_z, one.F_N))
    return tmp_path / "run.csv"


def test_the_rig_file_may_hold_the_map(run: Run, logged: Path, tmp_path: Path) -> None:
    entries = (one.partition("=") for one in MAP.replace(":ms", "").replace(":deg", "").split(","))
    tables = [
        f"{column} = {{ channel = {json.dumps(name.lstrip('-'))}, factor = {-1 if '-' in name else 1} }}"
        for column, _, name in entries
    ]
    rig = tmp_path / "rig.toml"
    rig.write_text((FOLDER / "rig.toml").read_text() + "\n[signals]\n" + "\n".join(tables))
    run("simulate", "--rig", FOLDER / "rig.toml", FOLDER / "holdout_c.csv", "--out", tmp_path / "a.csv")
    run("simulate", "--rig", rig, logged, "--out", tmp_path / "b.csv")

    first, second = (table_of(tmp_path / name) for name in ("a.csv", "b.csv"))
    np.testing.assert_allclose(second["M_z"], first["M_z"], atol=1e-9)


def test_recordings_of_two_formats_go_into_one_command(run: Run, logged: Path) -> None:
    maps = [one for text in (MAP, "psi=psi") for one in ("--map", text)]

    outcome = run(
        "simulate", "--rig", FOLDER / "rig.toml", FOLDER / "holdout_c.csv", logged, *maps,
        "--out", "mu.csv",
    )  # fmt: skip

    assert outcome.status == 0, outcome.err
    first, second = (table_of(Path(f"mu_{name}.csv")) for name in ("holdout_c", "run"))
    np.testing.assert_allclose(second["M_z"], first["M_z"], atol=1e-9)


def test_the_steering_ratio_of_a_car_stands_in_its_file() -> None:
    message = refused(locate_inputs, [], vehicle=Path("car.toml"), steering_ratio=15.0)
    assert message == "--steering-ratio: that of a car is steering_ratio in its vehicle file"
