"""The short form of `make attack`, and what it once found."""

import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.attack import fuzzing, names
from tests.attack.attack_class import Attack, Effort, Tried, one_by_one, undertake
from tests.attack.command_lines import attempt
from tests.attack.long_runs import Stream, attack_observers, observers
from tests.attack.run import CLASSES, attack_all, main
from tests.attack.targets import BROKE, FORMATS, TARGETS, broken, seeds
from tests.attack.workplace import PREFIX, sweep, workplace

pytestmark = pytest.mark.usefixtures("interpreted")
PLAIN = [name for name in TARGETS if name not in FORMATS]
FOUND = [path for name in TARGETS for path in broken(name)]


@pytest.mark.parametrize("path", FOUND, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_broke_an_older_version(path: Path) -> None:
    TARGETS[path.parent.name](path.read_bytes())


def test_what_broke_an_older_version_has_a_target() -> None:
    assert {path.name for path in BROKE.glob("*")} <= {*TARGETS, *FORMATS}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.long if n in FORMATS else ()) for n in TARGETS]
)
def test_damaged_files(name: str) -> None:
    whole = seeds(name)
    for content in whole:
        TARGETS[name](content)

    @settings(max_examples=60)
    @given(fuzzing.damaged(whole))
    def attempt(content: bytes) -> None:
        TARGETS[name](content)

    attempt()


@given(st.binary(max_size=200))
def test_any_bytes(content: bytes) -> None:
    for name in PLAIN:
        TARGETS[name](content)


def test_command_lines() -> None:
    assert [fault for fault in map(attempt, range(12)) if fault] == []


@pytest.mark.parametrize(
    "name", ["fetch", "fetch_local", "model_values", pytest.param("contents", marks=pytest.mark.long),
             pytest.param("temporary_folders", marks=pytest.mark.long),
             pytest.param("threads_and_fork", marks=pytest.mark.long),
             pytest.param("diagnosis_values", marks=pytest.mark.long)],
)  # fmt: skip
def test_the_short_form(name: str) -> None:
    if name not in CLASSES:
        pytest.skip("not on this system")
    assert undertake(CLASSES[name], Effort(seconds=4, inputs=20, seed=7)).failures == ()


def test_no_file_under_attack_stays() -> None:
    here = workplace()
    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        pass
    left = here.with_name(f"{PREFIX}{gone.pid}_left")
    left.mkdir()
    sweep()

    assert here.is_dir()
    assert not left.exists()


def test_the_table_counts_inputs_and_failures(capsys: pytest.CaptureFixture[str]) -> None:
    def fails(number: int) -> str | None:
        return f"number\n{number}" if number % 4 == 3 else None

    def raises(_: Effort) -> Iterator[Tried]:
        raise ZeroDivisionError("nothing left")

    classes: dict[str, Attack] = {"numbers": one_by_one(fails), "raises": raises}
    number = attack_all(classes, Effort(seconds=60, inputs=1010, seed=2))
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]

    assert number == 254
    assert lines[0][:3] == ["class", "inputs", "failures"]
    assert lines[1][:3] == ["numbers", "1,010", "253"]
    assert lines[2][:3] == ["raises", "0", "1"]
    assert lines[3][:3] == ["all", "1,010", "254"]
    assert lines[4] == ["numbers:", "number", "3"]
    assert "ZeroDivisionError" in lines[-1]


def test_without_atheris_hypothesis_draws(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def counts_commas(content: bytes) -> None:
        assert content.count(b",") == 9

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fuzzing.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setitem(TARGETS, "csv", counts_commas)
    status = main(["csv", "--inputs", "40"])
    out = capsys.readouterr().out

    assert status == 1
    assert "atheris is not installed" in out
    (kept,) = (tmp_path / "attack_findings" / "csv").iterdir()
    assert kept.read_bytes().count(b",") != 9


@pytest.mark.long
def test_guided_by_coverage(capsys: pytest.CaptureFixture[str]) -> None:
    with_a_library = [*PLAIN, *(["tdms"] if "tdms" in TARGETS else [])]
    status = main([*with_a_library, "--inputs", "2000", "--seconds", "2"])

    assert status == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n == "ekf" else pytest.mark.long) for n in observers()]
)
def test_a_block_of_odd_samples(name: str) -> None:
    assert Stream(name, 0).go_on() is None


def test_an_estimate_that_is_none_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Stream("root", 0)
    monkeypatch.setattr(stream, "loop", lambda _: stream_estimate)
    stream_estimate = type("Broken", (), {"mu": math.nan})

    assert "mu is nan" in (stream.go_on() or "")


@pytest.mark.long
def test_threads_and_a_child_go_on_together() -> None:
    outcome = undertake(attack_observers, Effort(seconds=5, inputs=20_000))

    assert outcome.inputs >= 20_000 or not outcome.failures
    assert outcome.failures == ()


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 9])
def test_odd_names(number: int) -> None:
    assert names.attempt(number) is None
