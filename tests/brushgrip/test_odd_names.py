"""Names that are none, too long, loops, or no text: one line or the right file, and nothing else."""

from pathlib import Path

import pytest

from tests.brushgrip.helpers import Run, Write

pytestmark = pytest.mark.usefixtures("interpreted", "no_work")
LONG = "n" * 300
NONE = ["", ".", "/", "..", "a/.."]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, rig: Path, write_csv: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    """A working folder with run.csv, rig.toml and a loop of links."""
    assert rig.name == "rig.toml"
    write_csv()
    (tmp_path / "one").symlink_to("other")
    (tmp_path / "other").symlink_to("one")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", [*NONE, LONG, f"one/{LONG}", "~nobody_of_this_name/x", "one", "one/x"])
def test_recordings(run: Run, name: str) -> None:
    run("diagnose", name, "--rig", "rig.toml", "--out", "out").refused()


@pytest.mark.parametrize("name", [*NONE, LONG, "one", "one/x"])
def test_rigs_and_models(run: Run, name: str) -> None:
    run("simulate", "run.csv", "--rig", name, "--out", "out.csv").refused()
    run("simulate", "run.csv", "--rig", "rig.toml", "--model", name, "--out", "out.csv").refused()
    run("codegen", "--observer", "ekf", "--rig", "rig.toml", "--model", name, "--out", "out").refused()


@pytest.mark.parametrize("out", [*NONE, LONG, "one", "one/x", "run.csv/x"])
def test_files_to_write(run: Run, out: str, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    rig = ("--rig", "rig.toml")
    run("simulate", "run.csv", *rig, "--out", out).refused()
    run("estimate", "run.csv", *rig, "--observer", "ekf", "--out", out).refused()
    run("estimate", "run.csv", *rig, "--observer", "ekf", "--out", "x.csv", "--picture", out).refused()
    run("identify", "--free-decay", "run.csv", *rig, "--out", out).refused()
    run("compare", "run.csv", *rig, "--out", "x.json", "--table", out).refused()
    run("compare", "run.csv", *rig, "--out", out).refused()

    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("out", [LONG, "one", "one/x", "run.csv", "run.csv/x"])
def test_folders_to_write_to(run: Run, out: str) -> None:
    run("diagnose", "run.csv", "--rig", "rig.toml", "--out", out).refused()
    run("codegen", "--rig", "rig.toml", "--observer", "ekf", "--out", out).refused()
    run("fetch", "--out", out).refused()


@pytest.mark.parametrize("jobs", ["1e20", "100000000000000000000", "0", "257"])
def test_processes_beyond_any_machine(run: Run, jobs: str) -> None:
    run("diagnose", "run.csv", "--rig", "rig.toml", "--out", "out", "--jobs", jobs).refused()


@pytest.mark.parametrize(
    "name",
    ["a b", 'it\'s "quoted"', "two\nlines", "مسار", "$\\frac$", "<b>", "[red]", "\udcff\udcfe", "-%s"],
)
def test_names_of_all_kinds(run: Run, name: str, tmp_path: Path) -> None:
    folder = tmp_path / name
    folder.mkdir()
    (tmp_path / "run.csv").rename(folder / f"{name}.csv")
    given = ("--rig", "rig.toml", "--observer", "ekf", "--out", folder / "e.csv")
    outcome = run("estimate", *given, "--", folder / f"{name}.csv")

    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.count("\n") == 3
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        ["e.csv", "e.png", "e.provenance.json", f"{name}.csv"]
    )


def test_a_full_disk(run: Run, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    outcome = run("simulate", "run.csv", "--rig", "rig.toml", "--out", "/dev/full")

    assert (outcome.status, outcome.err) == (1, "brushgrip: cannot write: No space left on device\n")
    assert sorted(tmp_path.iterdir()) == before
