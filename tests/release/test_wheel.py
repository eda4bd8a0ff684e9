"""Wheel and sdist, built and installed as a user does: in an empty environment, in another folder."""

import os
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from tests.release.installed import build, finished, run

pytestmark = pytest.mark.long


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
    home = tmp_path / "environment"
    venv.create(home, with_pip=True)
    programs = home / ("Scripts" if os.name == "nt" else "bin")
    run(
        programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check",
        next(built.glob("*.whl")), folder=tmp_path,
    )  # fmt: skip
    brushgrip = programs / "brushgrip"
    scripts = tmp_path / "scripts"
    recordings = scripts / "recordings"

    assert run(brushgrip, "--version", folder=tmp_path).startswith("brushgrip 0.")
    assert "examples" in run(brushgrip, "demo", "--examples", scripts, folder=tmp_path)
    run(
        brushgrip, "estimate", *sorted(recordings.glob("*.csv")), "--rig", recordings / "rig.toml",
        "--observer", "ekf", "--summary", "table.csv", "--quiet", folder=tmp_path,
    )  # fmt: skip
    assert (tmp_path / "table.csv").read_text().count("\n") == 5
    assert "mu" in run(programs / "python", scripts / "estimate_in_a_loop.py", folder=tmp_path)
    # A stranger in the place of one of our packages is named, and not run.
    package = Path(
        run(
            programs / "python", "-c", "import symbolic; print(symbolic.__file__)", folder=tmp_path
        ).strip()
    )
    package.write_text('"""Another."""\nraise SystemExit("it ran")\n')
    process = finished(brushgrip, "--version", folder=tmp_path)
    assert process.returncode == 1
    assert "is another distribution's" in process.stderr
    assert process.stderr.count("\n") == 1
