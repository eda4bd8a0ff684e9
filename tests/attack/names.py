"""Folders and files of odd names, in other locales and encodings: the same results, byte by byte."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from random import Random

from tests.attack.attack_class import one_by_one
from tests.attack.whole_runs import ROOT
from tests.attack.workplace import place_inputs

NAMES = (
    *("two words", "it's", 'a "quoted" one', "`id`", "$HOME", "a;b&c|d", "*?[x]", "#1", "100%", "a=b"),
    *("two\nlines", "tab\there", " ", "\\back\\slash", "mü–ψ", "مسار"),
    *("\u202eturned", "日本語", "e\u0301"),
    *("\udcff\udcfe", "\x1b[31m", "emoji \U0001f600", "<b>&amp;", "{x}", "%s", "~", "-", "n" * 200),
)
"""Names of a folder; each is also part of the names of files in it."""
LOCALES: tuple[Mapping[str, str], ...] = (
    {"LC_ALL": "C.UTF-8"},
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    {"LC_ALL": "POSIX", "PYTHONIOENCODING": "ascii"},
    {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
    {"LC_ALL": "tr_TR.UTF-8", "LANGUAGE": "tr"},
    {"PYTHONIOENCODING": "cp1252", "TZ": "Asia/Kathmandu", "COLUMNS": "20", "TERM": "dumb"},
    {"PYTHONUTF8": "1", "PYTHONHASHSEED": "7", "NO_COLOR": "1"},
)
COMMANDS = {
    "simulate": ("simulate", "{0}.csv", "--rig", "{0}.toml", "--out", "{0} out.csv"),
    "estimate": (
        *("estimate", "{0}.csv", "--rig", "{0}.toml", "--model", "{0}.json", "--observer", "ekf"),
        *("--out", "{0} out.csv"),
    ),
    "codegen": ("codegen", "--observer", "ekf", "--rig", "{0}.toml", "--out", "{0} out"),
}
_BEGINS = {"-": "./-", "~": "./~"}
"""What a shell's user writes for a name that is not one."""


def attempt(number: int) -> str | None:
    """One command in a folder of an odd name; what went wrong."""
    random = Random(number)
    command = random.choice(sorted(COMMANDS))
    name, environment = random.choice(NAMES), random.choice(LOCALES)
    with tempfile.TemporaryDirectory() as top:
        status, err, found, left = outcome(command, Path(top), name, environment)
    wrong = None
    if status or err.count("\n") > 1 or not err.rstrip("\n").isprintable():
        wrong = f"ended with {status}: {err[:300]!r}"
    elif found != usual(command):
        wrong = "another result"
    elif left:
        wrong = f"left {left}"
    return f"{number}: {command} in {name!r} with {dict(environment)}: {wrong}" if wrong else None


_MADE_FROM = b"/* Made by brushgrip from"
"""Begins the comment at the end of generated C that has the names of the files."""


@cache
def usual(command: str) -> tuple[bytes, ...]:
    """What the command writes for a plain name."""
    with tempfile.TemporaryDirectory() as top:
        status, err, found, _ = outcome(command, Path(top), "plain", LOCALES[0])
    if status:
        raise AssertionError(f"{command}: {err}")
    return found


def outcome(
    command: str, top: Path, name: str, environment: Mapping[str, str]
) -> tuple[int, str, tuple[bytes, ...], list[str]]:
    """Exit status, standard error, what was written, and what else is there."""
    here = top / name
    here.mkdir()
    place_inputs(here, f"{name}.csv", f"{name}.toml", f"{name}.json")
    odd = _BEGINS.get(name, f"./{name}" if name.startswith("-") else name)
    words = [word.replace("{0}", odd) for word in COMMANDS[command]]
    before = {path.name for path in here.iterdir()}
    command = [sys.executable, "-m", "brushgrip", *words]
    surroundings = _surroundings(top) | environment
    process = subprocess.run(command, cwd=here, env=surroundings, capture_output=True, check=False)
    out = here / words[-1]
    files = sorted(path for path in out.rglob("*") if path.is_file()) if out.is_dir() else [out]
    found = tuple(path.read_bytes().partition(_MADE_FROM)[0] for path in files if path.is_file())
    beside = {out.name, f"{out.stem}.png", f"{out.stem}.provenance.json"}
    left = sorted({path.name for path in here.iterdir()} - before - beside)
    return process.returncode, process.stderr.decode("utf-8", "replace"), found, left


def _surroundings(top: Path) -> dict[str, str]:
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("LC_", "LANG", "PYTHONIO"))}
    return kept | {"PYTHONPATH": str(ROOT), "BRUSHGRIP_INTERPRET": "1", "HOME": str(top)}


CLASSES = {"names": one_by_one(attempt)}
