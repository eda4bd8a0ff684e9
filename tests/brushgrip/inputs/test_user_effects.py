"""`--effects MODULE`: effects of a user's own reach the search and the readers of model files."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brushgrip.inputs.user_effects import effect_files, import_user_effects
from symbolic import CANDIDATES, InvalidInputError
from tests.brushgrip.helpers import Run, Write, table_of, write_model
from tests.refusal import refused

pytestmark = pytest.mark.usefixtures("interpreted")
MODULE = """
from dataclasses import dataclass

from symbolic import Effect, Parameter

@dataclass(frozen=True, kw_only=True)
class {kind}(Effect):
    name: str = "{name}"
    summary: str = "an effect of the user's own"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m", neutral=0.0, start=0.1, lower=-9.0, upper=9.0, scale=1.0),
    )

    def torque(self, signals, values):
        return values["c"] * signals.psi / signals.psi

EFFECTS = [{kind}()]
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A current directory with two modules and a package; what is imported from it is forgotten."""
    folder = tmp_path / "here"
    (folder / "ownpackage").mkdir(parents=True)
    (folder / "ownpackage" / "__init__.py").write_text("")
    modules = {"own_stop": "Stop", "own_creak": "Creak", "ownpackage/effects": "Sag"}
    for path, kind in modules.items():
        (folder / f"{path}.py").write_text(MODULE.format(kind=kind, name=kind.lower()))
    (folder / "own_empty.py").write_text("")
    monkeypatch.chdir(folder)
    before, path = set(sys.modules), list(sys.path)
    yield folder
    sys.path[:] = path
    for name in set(sys.modules) - before:
        if name.startswith("own"):
            del sys.modules[name]


@pytest.fixture
def model() -> Path:
    """A model that the user's own effect belongs to: it adds 0.5 N m."""
    return write_model({"stop.c": 0.5})


def names(*modules: str) -> list[str]:
    return [effect.name for effect in import_user_effects(modules)]


def test_modules_may_be_repeated_and_separated_by_commas() -> None:
    assert names("own_stop, own_creak", "ownpackage.effects") == ["stop", "creak", "sag"]
    assert names("own_stop", "own_stop") == ["stop"]
    assert import_user_effects(None) == ()


def test_what_is_on_the_path_goes_before_the_current_directory(here: Path) -> None:
    elsewhere = here.parent / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "own_stop.py").write_text(MODULE.format(kind="Other", name="other"))
    (elsewhere / "own_empty.py").write_text("")
    (here / "own_empty.py").write_text(MODULE.format(kind="Hidden", name="hidden"))
    sys.path.insert(0, str(elsewhere))

    assert names("own_stop", "own_creak") == ["other", "creak"]
    assert sys.path[0] == str(elsewhere)
    assert sys.path.index(str(here)) == len(sys.path) - 1
    with pytest.raises(InvalidInputError, match=f"imported from {elsewhere / 'own_empty.py'}"):
        names("own_empty")


def test_a_module_does_not_import_from_the_current_directory_what_is_installed(here: Path) -> None:
    (here / "fractions.py").write_text("raise RuntimeError('shadowed')")
    (here / "own_stop.py").write_text("import fractions\n" + (here / "own_stop.py").read_text())
    kept = sys.modules.pop("fractions", None)
    try:
        assert names("own_stop") == ["stop"]
    finally:
        sys.modules.pop("fractions", None)
        if kept:
            sys.modules["fractions"] = kept


def test_own_effects_are_candidates_beside_all_of_the_library(
    run: Run, write_csv: Write, rig: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[Any]] = []

    def stop(*_: object, candidates: list[Any], **__: object) -> None:
        asked.append(candidates)
        raise InvalidInputError("enough")

    monkeypatch.setattr("identification.diagnose", stop)
    for options in ([], ["--effects", "own_stop", "--effects", "own_creak"]):
        run("diagnose", write_csv(), "--rig", rig, *options, "--out", "out")

    alone, with_own = asked
    assert alone == list(CANDIDATES.values())
    assert with_own[:-2] == alone
    assert [effect.name for effect in with_own[-2:]] == ["stop", "creak"]


def test_a_model_file_with_an_own_effect_simulates_and_estimates(
    run: Run, write_csv: Write, rig: Path, model: Path
) -> None:
    plain, own, mu = (Path(f"{name}.csv") for name in ("plain", "own", "mu"))
    recording, options = write_csv(), ["--rig", rig, "--model", model, "--effects", "own_stop"]
    run("simulate", recording, "--rig", rig, "--out", plain)
    outcome = run("simulate", recording, *options, "--out", own)
    torques = [table_of(path)["M_z"][1:] for path in (plain, own)]

    assert outcome.status == 0, outcome.err
    np.testing.assert_allclose(torques[1], torques[0] + 0.5, atol=1e-12)
    assert run("estimate", recording, *options, "--observer", "ekf", "--out", mu).status == 0
    assert mu.exists()


def test_what_an_effect_prints_does_not_spoil_json(
    run: Run, write_csv: Write, rig: Path, here: Path
) -> None:
    loud = (here / "own_stop.py").read_text().replace("return", "print('hook'); return")
    (here / "own_loud.py").write_text(f"print('imported')\n{loud}")
    out = Path("out.csv")
    outcome = run("simulate", write_csv(), "--rig", rig, "--effects", "own_loud", "--out", out, "--json")

    assert json.loads(outcome.out) == {"wrote": [str(out)]}
    assert outcome.err.startswith("imported\nhook\n")


def test_nothing_is_imported_because_a_model_file_says_so(
    run: Run, write_csv: Write, rig: Path, model: Path
) -> None:
    out = Path("out.csv")
    outcome = run("simulate", write_csv(), "--rig", rig, "--model", model, "--out", out)

    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert "'stop'" in outcome.err
    assert "own_stop" not in sys.modules
    assert not out.exists()


def test_code_is_generated_with_an_own_effect(run: Run, rig: Path, model: Path) -> None:
    out = Path("c")
    usual = ("codegen", "--rig", rig, "--observer", "ekf", "--real", "double", "--name", "grip")
    outcome = run(*usual, "--model", model, "--effects", "own_stop", "--out", out)

    assert outcome.status == 0, outcome.err
    assert "stop.c" in (out / "grip.json").read_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('values["c"] * signals.psi / signals.psi', "1 if signals.psi > 0 else 2"), "casadi.if_else"),
        (('values["c"]', 'values["k"]'), "KeyError: 'k'; its parameters are c"),
        (("def torque", "def torqe"), "changes nothing: it overrides none of transform_inputs"),
    ],
)
def test_an_effect_that_cannot_work_is_told(here: Path, change: tuple[str, str], words: str) -> None:
    (here / "own_odd.py").write_text(MODULE.format(kind="Odd", name="odd").replace(*change))
    message = refused(names, "own_odd")

    assert words in message
    assert message.isprintable()


def test_a_torque_of_memory_is_enough(here: Path) -> None:
    slow = MODULE.format(kind="Slow", name="slow")
    text = slow.replace("torque(self, signals", "torque_of_memory(self, m")
    remembers = "    memory: int = 1\n\n    def initial(self, signals):\n        return 0\n\n    def "
    text = text.replace("signals.psi / signals.psi", "m").replace("    def ", remembers)
    (here / "own_slow.py").write_text(text)

    assert [effect.adds_torque_from_memory for effect in import_user_effects(["own_slow"])] == [True]


def test_a_file_is_the_module_of_its_name(here: Path) -> None:
    folder = here / "somewhere"
    folder.mkdir()
    (folder / "own_in_folder.py").write_text(MODULE.format(kind="Stop", name="stop_in_folder"))
    effects = import_user_effects(["somewhere/own_in_folder.py"])

    assert [effect.name for effect in effects] == ["stop_in_folder"]
    assert folder / "own_in_folder.py" in effect_files(["somewhere/own_in_folder.py"], effects)
