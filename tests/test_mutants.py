"""The runner of the mutants, on a checkout of two lines."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

from tests.mutants.run import Mutant, end_stragglers, judge, passes_unchanged, read_mutants

CODE = "LIMIT = 3\nOTHER = LIMIT\n"
TEST = "from code_under_test import LIMIT\n\n\ndef test_limit():\n    assert LIMIT == 3\n"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "code_under_test.py").write_text(CODE)
    (tmp_path / "test_limit.py").write_text(TEST)
    return tmp_path


def mutant(before: str, after: str, *tests: str) -> Mutant:
    changed = {"before": before, "after": after, "tests": tests or ("test_limit.py",)}
    return Mutant(file="code_under_test.py", **changed)


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        (mutant("LIMIT = 3", "LIMIT = 4"), "noticed"),
        (mutant("OTHER = LIMIT", "OTHER = 7"), "survived"),
        (mutant("LIMIT", "WIDTH"), "occurs 2 times"),
        (mutant("WIDTH", "LIMIT"), "occurs 0 times"),
        pytest.param(
            mutant("LIMIT = 3", "LIMIT = 4", "test_nowhere.py"),
            "pytest ended with 4",
            marks=pytest.mark.long,
        ),
        pytest.param(mutant("LIMIT = 3", "LIMIT ="), "pytest ended with 2", marks=pytest.mark.long),
    ],
)
def test_verdicts(change: Mutant, verdict: str, checkout: Path) -> None:
    outcome = judge(change, checkout)

    assert outcome.verdict == verdict, outcome.output
    assert (checkout / "code_under_test.py").read_text() == CODE


def test_no_process_of_a_change_stays(tmp_path: Path) -> None:
    with started_with(str(tmp_path)) as own, started_with(f"{tmp_path}_2") as other:
        end_stragglers(tmp_path)

        assert own.wait(10) == -signal.SIGKILL
        assert other.poll() is None
        other.kill()


def started_with(path: str) -> subprocess.Popen[bytes]:
    """A process that waits and has spoken: some time after Popen its environment is not yet there."""
    environment, pipe = {**os.environ, "PYTHONPATH": path}, subprocess.PIPE
    command = ["sh", "-c", "echo; read line"]
    process = subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, start_new_session=True)
    assert process.stdout is not None
    assert process.stdout.readline() == b"\n"
    return process


@pytest.mark.long
def test_tests_have_to_pass_before_anything_is_changed(
    checkout: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change = mutant("OTHER = LIMIT", "OTHER = 7")

    assert passes_unchanged([change], checkout)
    (checkout / "code_under_test.py").write_text("LIMIT = 4\n")
    assert not passes_unchanged([change], checkout)
    assert "do not pass on the unchanged code" in capsys.readouterr().out


def test_every_entry_changes_one_place(repository_root: Path) -> None:
    mutants = read_mutants(repository_root / "tests" / "mutants")

    assert mutants
    assert [m.title for m in mutants if m.occurrences(repository_root) != 1] == []
    assert [m.title for m in mutants if m.before == m.after] == []
    named = {test.split("::")[0] for m in mutants for test in m.tests}
    assert [name for name in sorted(named) if not (repository_root / name).exists()] == []
