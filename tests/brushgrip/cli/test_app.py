import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec, spec_from_file_location
from pathlib import Path

import pytest

import brushgrip
from brushgrip import commands
from brushgrip.cli import own_packages_shadowed
from brushgrip.cli.app import COMMANDS, app, command_of, command_request_classes, repeat_flag_per_value
from brushgrip.cli.own_packages_shadowed import BEGINNINGS, shadowed_packages_message
from brushgrip.published.fetch import FetchError
from symbolic import InvalidInputError
from tests.brushgrip.helpers import Run, Write
from tests.contributing import example


@pytest.mark.parametrize(
    ("given", "spread"),
    [
        ("diagnose a b --out d", "diagnose a b --out d"),
        ("diagnose a --holdout c d e --out d", "diagnose a --holdout c --holdout d --holdout e --out d"),
        ("diagnose a --holdout c --holdout d", "diagnose a --holdout c --holdout d"),
        ("--holdout c d --holdout e", "--holdout c --holdout d --holdout e"),
        ("--holdout c d -- a b", "--holdout c --holdout d -- a b"),
        ("-- --holdout a b", "-- --holdout a b"),
        ("--holdout=c a", "--holdout c --holdout a"),
        ("identify --free-decay a b --out c", "identify --free-decay a --free-decay b --out c"),
        ("a --holdout", "a --holdout"),
        ("a --holdout --out d", "a --holdout --out d"),
        ("", ""),
    ],
)
def test_repeat_lists(given: str, spread: str) -> None:
    assert repeat_flag_per_value(given.split()) == spread.split()


@pytest.mark.parametrize(
    ("error", "status"), [(InvalidInputError("bad\nthing"), 2), (FetchError("bad\nthing"), 1)]
)
def test_known_errors_take_one_line(
    run: Run, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("brushgrip.cli.app.app", fail)
    outcome = run("fetch")

    assert outcome.status == status
    assert outcome.err == "brushgrip: bad thing\n"


def test_fetch_goes_to_the_users_folder(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path.cwd() / "user_data" / "brushgrip"

    def fetch(destination: Path, *, say: Callable[[str], None]) -> list[Path]:
        say("1/1 x.mat")
        return [destination / "x.mat"]

    monkeypatch.setattr("brushgrip.published.fetch.fetch", fetch)
    outcome = run("fetch")

    assert outcome.status == 0
    assert outcome.out == f"1/1 x.mat\n1 file in {folder}\n"


def test_help_needs_neither_numbers_nor_pictures_and_observers_no_extras() -> None:
    # Each costs a good part of a second, and help is asked for often.
    program = """
import sys
from brushgrip.cli.app import COMMANDS, main
for name in ("", *COMMANDS):
    try:
        main([*filter(None, [name]), "--help"])
    except SystemExit as end:
        assert end.code == 0, name
extras = {"bokeh", "can", "cantools", "playwright", "pyarrow", "tornado"}
heavy = {"casadi", "control", "jinja2", "matplotlib", "numpy", "pooch", "scipy", "symbolic"}
print(*sorted((extras | heavy) & set(sys.modules)), file=sys.stderr)
import observers, identification
print(*sorted(extras & set(sys.modules)), file=sys.stderr)
"""
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert process.stderr == "\n\n"
    assert process.stdout.count("--help") > 10
    assert process.stdout.count("  --out ") == 9


def test_a_bare_command_line_prints_the_help(run: Run) -> None:
    bare = run()

    assert (bare.status, bare.err) == (0, "")
    assert bare.out == run("--help").out
    assert bare.out.startswith("Usage: brushgrip [OPTIONS] COMMAND [ARGS]...\n")


def test_the_door_opens_late() -> None:
    from brushgrip.estimation import observe_recording as estimation

    assert brushgrip.FrictionTrack is estimation.FrictionTrack
    assert brushgrip.write_report.__name__ == "write_report"
    with pytest.raises(AttributeError, match="module 'brushgrip' has no attribute 'nothing'"):
        _ = brushgrip.nothing


def test_a_command_is_a_file(
    run: Run, write_csv: Write, rig: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "load.py").write_text(example("new command"))
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    found = command_request_classes()
    monkeypatch.delitem(sys.modules, "brushgrip.commands.load")
    monkeypatch.delattr(commands, "load", raising=False)
    monkeypatch.setattr(app, "registered_commands", [*app.registered_commands])
    app.command("load")(command_of(found["load"]))

    assert [*found] == [*COMMANDS, "load"]
    outcome = run("load", write_csv("run.csv", {"M_z": None}), "--rig", rig)
    assert (outcome.status, outcome.out, outcome.err) == (0, "run: 400 N\n", "")
    assert "Print the mean load of recordings." in run("load", "--help").out


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder where `symbolic` stands, and no `observers` is anywhere."""
    (tmp_path / "symbolic").mkdir()
    elsewhere = spec_from_file_location("symbolic", tmp_path / "symbolic" / "__init__.py")
    places = {"symbolic": elsewhere, "observers": None}
    monkeypatch.setattr(
        own_packages_shadowed, "find_spec", lambda name: places.get(name, find_spec(name))
    )
    return tmp_path


def test_ours_are_ours() -> None:
    assert shadowed_packages_message() == ""


def test_a_package_elsewhere_is_not_ours(place: Path) -> None:
    (place / "symbolic" / "__init__.py").write_text(f"{BEGINNINGS['symbolic']}\nraise SystemExit\n")
    said = shadowed_packages_message()

    assert f"'symbolic' in {place / 'symbolic'} is another distribution's" in said
    assert "'observers' is missing" in said
    assert "identification" not in said


def test_a_package_written_over_is_not_ours(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = place / "symbolic" / "__init__.py"
    monkeypatch.setattr(
        own_packages_shadowed, "__file__", str(place / "brushgrip" / "cli" / "own_packages_shadowed.py")
    )
    package.write_text('"""Something else."""\n')
    assert f"'symbolic' in {package.parent} is another" in shadowed_packages_message()
    package.write_text(BEGINNINGS["symbolic"])
    assert "'symbolic'" not in shadowed_packages_message()
