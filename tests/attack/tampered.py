"""Results that somebody changed: values of another kind in JSON, other things in a folder's place."""

import copy
import json
import os
import random
import shutil
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import identification
from observers import Ekf, from_files, run
from symbolic import BrushgripError
from tests.attack.attack_class import one_by_one
from tests.attack.command_lines import folder, outcome_of
from tests.attack.faults import attempt, ended_well
from tests.attack.oracle import check_message
from tests.attack.whole_runs import SEARCH, Sandbox
from tests.attack.workplace import CORPUS, workplace

VALUES: tuple[Any, ...] = (
    *(None, True, "", "x", "1e5", [], {}, [[]], {"a": {}}, 0, -1, 1e308, 10**400, float("nan")),
    *(float("inf"), -float("inf"), 5e-324, "\0", "../../x", "\udcff", "a" * 5000, [1] * 1000, "nan"),
    *({"content": 5}, "brush", ["rate_friction"] * 2, "../x.json", "report.html\0"),
)


def changed(document: Any, chance: Random) -> Any:
    """The document with one to three values replaced, taken away, doubled or put under another key."""
    document = copy.deepcopy(document)
    for _ in range(chance.randint(1, 3)):
        told = document.get("provenance") if isinstance(document, dict) else None
        is_told = isinstance(told, dict | list) and chance.random() < 0.5
        places = [(document, "provenance"), *_places(told)] if is_told else _places(document)
        if not places:
            return chance.choice(VALUES)
        owner, key = chance.choice(places)
        kind = chance.randrange(6)
        if kind == 0:
            del owner[key]
        elif kind == 1 and isinstance(owner, dict):
            other = chance.choice(("", "k", "mu", "x" * 300, "provenance", str(key) + " "))
            owner[other] = owner.pop(key)
        elif kind == 2:
            other, name = chance.choice(places)
            owner[key] = copy.deepcopy(other[name])
        else:
            owner[key] = copy.deepcopy(chance.choice(VALUES))
    return document


def _places(document: Any) -> list[tuple[Any, Any]]:
    found: list[tuple[Any, Any]] = []
    items = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in items:
        found.append((document, key))
        if isinstance(value, dict | list):
            found += _places(value)
    return found


def model_file(number: int) -> str | None:
    """An observer, a simulation and a fit by a changed model: an error of ours in a line, or numbers."""
    chance = Random(number)
    whole = chance.choice(sorted((CORPUS / "model_json").iterdir()))
    path = workplace() / "tampered.json"
    text = json.dumps(changed(json.loads(whole.read_text()), chance))
    path.write_text(text, "utf-8", "surrogatepass")
    rig = CORPUS / "rig_toml" / "rig.toml"
    t = 0.01 * np.arange(40)
    try:
        found = identification.read_model(path)
        observer = from_files(Ekf, rig, path)
        estimates = run(observer, t, 0.1 * np.sin(9 * t), 400 + 0 * t, -2 * np.sin(8 * t))
        found.model.theta(found.values_for_recording("new", 1.0))
    except BrushgripError as error:
        check_message(error)
        return None
    except Exception as error:
        return f"{number}: {type(error).__name__}: {error}"
    return None if np.isfinite([estimates.mu, estimates.mu_std]).all() else f"{number}: no finite mu"


@cache
def results() -> Path:
    """A folder with what a quick run wrote."""
    sandbox = Sandbox(workplace() / "results", quick=True)
    if (ended := sandbox.run()).status:
        raise AssertionError(ended)
    return sandbox.folder / "work"


def diagnosis_file(number: int) -> str | None:
    """The same command over a diagnosis.json or a model.json that was changed, and C of the model."""
    chance = Random(number)
    with folder() as here:
        shutil.copytree(results(), here, dirs_exist_ok=True)
        for name in chance.sample(("diagnosis.json", "model.json"), chance.randint(1, 2)):
            path = here / "out" / name
            text = json.dumps(changed(json.loads(path.read_text()), chance))
            path.write_text(text, "utf-8", "surrogatepass")
        model = ("--rig", "rig.toml", "--model", "out/model.json")
        for words in (
            (*SEARCH, "--out", "out"),
            chance.choice((
                ("codegen", *model, "--observer", "ekf", "--out", "c"),
                ("simulate", "train_a.csv", *model, "--out", "s.csv"),
            )),
        ):  # fmt: skip
            status, err = outcome_of(words)
            if status not in (0, 1, 2) or (status and err.count("\n") != 1):
                return f"{number}: {words[0]} ended with {status!r}: {err[-300:]!r}"
    return None


def folder_of_results(sandbox: Sandbox, chance: random.Random) -> str | None:
    """Links, folders and pipes in the places of results and of kept trials; what they lead to stays."""
    sandbox.run()
    outside = sandbox.folder / "home" / "outside"
    outside.mkdir()
    victims = [outside / "victim", outside / "other.npz"]
    for victim in victims:
        victim.write_text("kept")
    places = [*sandbox.out.iterdir(), sandbox.out, sandbox.out.with_name(".out.unfinished")]
    for place in chance.sample(places, chance.randint(1, 3)):
        if not place.parent.is_dir() or place.parent.is_symlink():
            continue
        if place.is_dir() and not place.is_symlink():
            shutil.rmtree(place)
        place.unlink(missing_ok=True)
        make: tuple[Callable[[], object], ...] = (
            partial(place.symlink_to, outside), partial(place.symlink_to, outside / "victim"),
            partial(place.symlink_to, "nowhere"), partial(place.symlink_to, place.name),
            place.mkdir, partial(os.mkfifo, place), partial(place.write_text, "of somebody else"),
        )  # fmt: skip
        chance.choice(make)()
    ended = sandbox.run()
    wrong = ended_well(ended, (0, 1, 2), most=3)
    if [path.read_text() for path in victims if path.is_file()] != ["kept", "kept"]:
        wrong = "what a link led to is lost"
    for path in (sandbox.out, sandbox.out.with_name(".out.unfinished")):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    return wrong


CLASSES = {
    "model_values": one_by_one(model_file),
    "diagnosis_values": one_by_one(diagnosis_file),
    "run_tampered_folder": one_by_one(partial(attempt, folder_of_results, quick=True)),
}
