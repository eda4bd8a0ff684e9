"""No command writes over what it reads, however the path is spelt."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from brushgrip.inputs.command_inputs import locate_inputs
from brushgrip.inputs.recordings import keep_inputs
from identification.thesis.published_friction import published_file
from symbolic.errors import InvalidInputError
from tests.brushgrip.helpers import Run, Write, contents


@pytest.fixture
def folder(rig: Path, write_csv: Write, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder with good.csv, rig.toml, model.json, a file of the author, and links."""
    good, tmp_path = write_csv("good.csv"), rig.parent
    (tmp_path / "model.json").write_text("{}")
    (tmp_path / "car.dbc").write_text("")
    (tmp_path / "sub").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "sub")
    (tmp_path / "link.csv").symlink_to(good)
    os.link(good, tmp_path / "hard.csv")
    os.link(good, tmp_path / "hard.png")
    published_file(tmp_path, "good").write_text("")
    monkeypatch.chdir(tmp_path)
    return tmp_path


SPELLINGS = [
    "good.csv",
    "nosub/../good.csv",
    "nosub/deeper/../../good.csv",
    "sub/../good.csv",
    "link/../good.csv",
    "good.csv/../good.csv",
    "link.csv",
    "nosub/../link.csv",
    "hard.csv",
    "nosub/../hard.csv",
]


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_an_output_is_known_as_an_input(folder: Path, spelling: str) -> None:
    assert folder
    with pytest.raises(InvalidInputError, match="would overwrite what is read"):
        keep_inputs([Path(spelling)], [Path("good.csv")])


def test_another_file_of_the_same_name_may_be_written(folder: Path) -> None:
    keep_inputs([Path("sub/good.csv"), Path("nosub/good.csv"), Path("new.csv")], [Path("good.csv")])
    # What a link leads to counts, not how it reads.
    (folder / "sub" / "deep").mkdir()
    (folder / "far").symlink_to(folder / "sub" / "deep")
    keep_inputs([Path("far/../good.csv")], [Path("good.csv")])


@pytest.mark.parametrize(
    ("recording", "beside"),
    [("run.blf", "car.dbc"), ("run.log", "car.dbc"), ("run.mcap", "metadata.yaml"),
     ("run.tdms", "run.tdms_index")],
)  # fmt: skip
def test_what_lies_beside_a_recording_is_read_too(folder: Path, recording: str, beside: str) -> None:
    for name in (recording, beside):
        (folder / "sub" / name).write_text("")
    read = locate_inputs([f"sub/{recording}"]).files
    with pytest.raises(InvalidInputError, match="would overwrite what is read"):
        keep_inputs([Path("nosub/../sub") / beside], read)
    keep_inputs([Path("sub/other.csv"), Path(beside)], read)


ESTIMATE = ("estimate", "good.csv", "--rig", "rig.toml", "--observer", "ekf")
COMPARE = ("compare", "good.csv", "--rig", "rig.toml", "--declared", "1.2")
SIMULATE = ("simulate", "good.csv", "--rig", "rig.toml")


@pytest.fixture
def own_effects(folder: Path) -> Iterator[None]:
    """The package `ownkit`, whose module `effects` takes its only effect from `boot`."""
    package, path, before = folder / "ownkit", list(sys.path), set(sys.modules)
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "boot.py").write_text(
        "from dataclasses import dataclass\nfrom symbolic import Effect\n"
        "@dataclass(frozen=True, kw_only=True)\nclass Boot(Effect):\n"
        "    def torque(self, signals, values):\n        return 0\n"
    )
    (package / "effects.py").write_text(
        "from ownkit.boot import Boot\nEFFECTS = [Boot(name='boot', summary='', parameters=())]\n"
    )
    yield
    sys.path[:] = path
    for name in set(sys.modules) - before:
        if name.startswith("ownkit"):
            del sys.modules[name]


@pytest.mark.usefixtures("own_effects")
@pytest.mark.parametrize("source", ["effects", "boot", "__init__"])
@pytest.mark.parametrize("command", ["estimate", "compare", "simulate", "diagnose", "codegen"])
def test_the_sources_of_own_effects_are_read_too(
    run: Run, folder: Path, command: str, source: str
) -> None:
    path = Path(f"ownkit/{source}.py")
    arguments: tuple[object, ...] = {
        "estimate": (*ESTIMATE, "--out", path),
        "compare": (*COMPARE, "--out", path),
        "simulate": (*SIMULATE, "--out", path),
        "diagnose": ("diagnose", "good.csv", "--rig", "rig.toml", "--out", "sub"),
        "codegen": ("codegen", "--rig", "rig.toml", "--observer", "ekf", "--out", "sub"),
    }[command]
    if command in ("diagnose", "codegen"):
        name = {"diagnose": "report.html", "codegen": "brushgrip.c"}[command]
        (folder / "sub" / name).symlink_to(folder / path)
    before = contents(folder / "ownkit")
    outcome = run(*arguments, "--effects", "ownkit.effects")

    outcome.refused("would overwrite what is read")
    assert {n: c for n, c in contents(folder / "ownkit").items() if n in before} == before


@pytest.mark.parametrize("author", [(), ("--author", "nosub/..")])
def test_the_authors_estimates_are_read_too(run: Run, folder: Path, author: tuple[str, ...]) -> None:
    (folder / "nosub").mkdir()
    before = contents(folder)
    outcome = run(*COMPARE, *author, "--out", published_file(Path(), "good"))

    assert outcome.status == 2
    assert "would overwrite what is read" in outcome.err
    assert contents(folder) == before


@pytest.mark.usefixtures("no_work")
@pytest.mark.parametrize("name", ["diagnosis.json", "model.json", "report.html", "loops.png"])
def test_diagnose_looks_before_it_searches(run: Run, folder: Path, name: str) -> None:
    (folder / "rig.toml").rename(folder / "sub" / name)
    before = contents(folder)

    outcome = run("diagnose", "good.csv", "--rig", f"sub/{name}", "--out", "nosub/../link")
    outcome.refused("would overwrite what is read")
    assert contents(folder) == before
