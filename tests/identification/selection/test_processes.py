"""Effects of a user's own in the processes of a search, and what is said where they cannot go there."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from identification import Recording, diagnose, search
from symbolic import BrushgripError, Effect, InvalidInputError, Parameter
from tests.contributing import example
from tests.identification.factories import read_campaign, with_torque
from tests.refusal import refused

BOOT = example("new effect") + "\nEFFECTS = [BootSpring()]\n"
SEARCH = """
from identification import search
from symbolic import InvalidInputError
try:
    search([], (), jobs=2, candidates=EFFECTS)
except InvalidInputError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Recordings of a rig with a boot of 150 N m/rad^3."""
    plain = read_campaign(None, 3, duration=8.0)[1]
    return [with_torque(recording, recording.M_z - 150 * recording.psi**3) for recording in plain]


@pytest.fixture
def boot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The user's module, imported from a folder on the path."""
    (tmp_path / "ownboot.py").write_text(BOOT)
    monkeypatch.syspath_prepend(tmp_path)
    yield import_module("ownboot")
    del sys.modules["ownboot"]


@pytest.mark.long
@pytest.mark.usefixtures("interpreted")
def test_a_users_effect_goes_to_the_processes(boot: ModuleType, recordings: list[Recording]) -> None:
    (one,) = diagnose(recordings, jobs=2, candidates=boot.EFFECTS).effects

    assert one.name == "boot_spring"
    assert one.parameters["c"].value == pytest.approx(150, rel=0.1)


@pytest.mark.long
@pytest.mark.usefixtures("interpreted")
def test_a_process_that_ends_takes_one_line(
    boot: ModuleType, recordings: list[Recording], tmp_path: Path
) -> None:
    (tmp_path / "ownboot.py").unlink()
    said = r"a process of the search ended .*cannot import.*ModuleNotFoundError.*jobs=1"
    with pytest.raises(BrushgripError, match=said) as caught:
        search(recordings, (), jobs=2, candidates=boot.EFFECTS)
    assert not isinstance(caught.value, InvalidInputError)
    assert "\n" not in str(caught.value)


@dataclass(frozen=True, kw_only=True)
class Field(Effect):
    """An effect with a field of any kind."""

    name: str = "field"
    summary: str = "a field"
    parameters: tuple[Parameter, ...] = ()
    content: Any = None


def test_a_local_class_and_a_field_that_cannot_be_pickled_are_refused() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Local(Field):
        """A class that only this function knows."""

    for effect in (Local(), Field(content=lambda x: x)):
        message = refused(search, [], (), jobs=2, candidates=[effect])
        assert message.startswith("effect 'field' cannot be taken to the processes of the")
        assert "put the effect into a module of its own, or use jobs=1" in message


@pytest.mark.long
def test_a_class_of_a_main_module_without_a_file_is_refused(repository_root: Path) -> None:
    for how, text in (["-c", BOOT + SEARCH], None), (["-"], BOOT + SEARCH):
        command, caught = [sys.executable, *how], {"capture_output": True, "text": True}
        ended = subprocess.run(command, input=text, cwd=repository_root, **caught)
        told = "effect 'boot_spring' cannot be taken to the processes"
        assert ended.stdout.startswith(told), ended.stderr
        assert "put the effect into a module of its own, or use jobs=1" in ended.stdout
