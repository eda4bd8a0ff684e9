"""One recording as six loggers would keep it, estimated by the installed wheel: the same friction."""

import venv
from pathlib import Path

import numpy as np
import pytest

from identification import read_recording, read_rig
from tests.identification.reading.logs import WRITERS, as_logged
from tests.release.installed import build, run

pytestmark = pytest.mark.long
EXTRAS = "brushgrip[can,mdf,parquet,tdms]"
FORMATS = ("german", "mdf", "tdms", "parquet", "blf")
RECORDINGS = Path(__file__).parents[2] / "examples" / "recordings"


def frictions(brushgrip: Path, folder: Path) -> dict[str, np.ndarray]:
    """Friction over time by format, as `brushgrip estimate` writes it; the recording itself first."""
    original, rig = RECORDINGS / "holdout_c.csv", RECORDINGS / "rig.toml"
    read = read_recording(original, read_rig(rig))
    columns = as_logged(read.t, read.psi, read.M_z, read.F_N)
    found = {}
    for format_ in ("csv", *FORMATS):
        path, options = original, []
        if format_ != "csv":
            name, write, signals = WRITERS[format_]
            path, options = folder / name, ["--map", signals]
            write(path, columns)
        out = folder / f"mu_{format_}.csv"
        run(
            brushgrip, "estimate", path, "--rig", rig, "--observer", "ekf", "--out", out, *options,
            folder=folder,
        )  # fmt: skip
        found[format_] = np.genfromtxt(out, delimiter=",", names=True)["mu"]
    return found


def test_six_files_of_one_recording(tmp_path: Path, repository_root: Path) -> None:
    wheel = next(build(repository_root, tmp_path / "dist").glob("*.whl"))
    venv.create(tmp_path / "environment", with_pip=True)
    programs = tmp_path / "environment" / "bin"
    run(
        programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
        f"{EXTRAS} @ {wheel.as_uri()}", folder=tmp_path,
    )  # fmt: skip
    first, *others = frictions(programs / "brushgrip", tmp_path).values()

    assert len(others) == 5
    for other in others:
        np.testing.assert_allclose(other, first, rtol=0, atol=1e-6)
