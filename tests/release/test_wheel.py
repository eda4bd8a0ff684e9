"""Wheel and sdist, built and installed as a user does: in an empty environment, in another folder."""

import os
import tarfile
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest

from identification import read_recording, read_rig
from tests.identification.reading.logs import WRITERS, as_logged
from tests.release.installed import build, finished, run

pytestmark = pytest.mark.long
LOGGERS = "[can,mdf,parquet,tdms]"
"""Extras that read what they write, beside the German table."""
FORMATS = ("german", "mdf", "tdms", "parquet", "blf")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory, repository_root: Path) -> Path:
    """A folder with both, the wheel made of the sdist."""
    return build(repository_root, tmp_path_factory.mktemp("dist"))


def test_what_they_hold(built: Path) -> None:
    with zipfile.ZipFile(next(built.glob("*.whl"))) as wheel:
        names = set(wheel.namelist())
    with tarfile.open(next(built.glob("*.tar.gz"))) as sdist:
        sources = {name.partition("/")[2] for name in sdist.getnames()}
    tops = {name.split("/")[0] for name in names if ".dist-info" not in name}

    assert tops == {"symbolic", "observers", "identification", "brushgrip"}
    assert {f"{top}/py.typed" for top in tops} <= names
    assert "brushgrip/embedded/recordings/train_a.csv" in names
    assert not [name for name in names if "__pycache__" in name]
    assert {"CITATION.cff", "LICENSE", "README.md", "tests/release/test_wheel.py"} <= sources


def test_it_runs_where_nothing_else_is(built: Path, tmp_path: Path) -> None:
    wheel = next(built.glob("*.whl"))
    home = tmp_path / "environment"
    venv.create(home, with_pip=True)
    programs = home / ("Scripts" if os.name == "nt" else "bin")
    install = [programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    install.append("--no-compile")
    run(*install, wheel, folder=tmp_path)
    scripts = tmp_path / "scripts"
    run_of_itself(programs, scripts)
    run(*install, f"brushgrip{LOGGERS} @ {wheel.as_uri()}", folder=tmp_path)
    first, *others = frictions(programs / "brushgrip", scripts / "recordings", tmp_path)
    assert len(others) == len(FORMATS)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=0, atol=1e-5)
    refuses_a_stranger(programs, tmp_path)


def run_of_itself(programs: Path, scripts: Path) -> None:
    """Version, scripts, a batch and a loop, with what the plain wheel brings."""
    folder, recordings = scripts.parent, scripts / "recordings"
    brushgrip = programs / "brushgrip"
    assert run(brushgrip, "--version", folder=folder).startswith("brushgrip 0.")
    assert "examples" in run(brushgrip, "demo", "--examples", scripts, folder=folder)
    run(
        brushgrip, "estimate", *sorted(recordings.glob("*.csv")), "--rig", recordings / "rig.toml",
        "--observer", "ekf", "--summary", "table.csv", "--quiet", folder=folder,
    )  # fmt: skip
    assert (folder / "table.csv").read_text().count("\n") == 5
    assert "mu" in run(programs / "python", scripts / "estimate_in_a_loop.py", folder=folder)


def frictions(brushgrip: Path, recordings: Path, folder: Path) -> list[np.ndarray]:
    """Friction over time by `estimate`: of a recording, and of it as each logger would keep it."""
    original, rig = recordings / "holdout_c.csv", recordings / "rig.toml"
    read = read_recording(original, read_rig(rig))
    columns = as_logged(read.t, read.psi, read.M_z, read.F_N)
    files = [(original, [])]
    for name, write, signals in (WRITERS[format_] for format_ in FORMATS):
        write(folder / name, columns)
        files.append((folder / name, ["--map", signals]))
    found = []
    for path, options in files:
        out = folder / f"{path.name}.mu.csv"
        run(
            brushgrip, "estimate", path, "--rig", rig, "--observer", "ekf", "--out", out, *options,
            folder=folder,
        )  # fmt: skip
        found.append(np.genfromtxt(out, delimiter=",", names=True)["mu"])
    return found


def refuses_a_stranger(programs: Path, folder: Path) -> None:
    """In the place of one of our packages another is named, and not run."""
    code = "import symbolic; print(symbolic.__file__)"
    package = Path(run(programs / "python", "-c", code, folder=folder).strip())
    package.write_text('"""Another."""\nraise SystemExit("it ran")\n')
    process = finished(programs / "brushgrip", "--version", folder=folder)
    assert process.returncode == 1
    assert "is another distribution's" in process.stderr
    assert process.stderr.count("\n") == 1
