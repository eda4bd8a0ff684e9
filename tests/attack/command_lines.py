"""Command lines of odd names and values: a status of ours, one line on what is wrong, nothing left."""

import contextlib
import io
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from random import Random
from unittest import mock

import identification
from brushgrip.cli.app import main
from brushgrip.running import dask_or_local_executor, estimate_batch
from symbolic import InvalidInputError
from tests.attack.attack_class import one_by_one
from tests.attack.workplace import place_inputs

NAMES = (
    *("", ".", "..", "a/..", "no/such", "n" * 300, "~nobody_of_this_name/x"),
    *("link", "link/x", "-", "--"),
    *("pipe", "/dev/full", "/dev/zero", "folder", "run.csv", "rig.toml", "model.json", "two\nlines"),
    *("\udcff", "\x1b[2J", "\u202eturned", "<b>", "$x$", "%s%n", "مسار", "a b", "new.csv", "new.json"),
    *("new.png", "folder/new.csv", "run.csv/x", "link.csv", "/proc/self/mem", "/proc/none/x"),
)
"""No place outside the folder of the attack can be written by these names."""
VALUES = (
    *("", "nan", "inf", "-1", "0", "1", "2", "1e20", "9" * 30, "0.5", "1.2", "1e-320"),
    *("ekf", "mhe", "root", "double", "c", "fmu", "M", "math", "x", "real_tyre", "clean"),
    *("psi=psi:deg", "psi=-psi,psi=psi", "t=t:ms,M_z=-M_z", "psi=0*psi", "=", "psi=", "dbc=rig.toml"),
    *("psi=1e999*psi", "M_z=M_z:parsec", "t=" + "x" * 5000, "mu_walk=0.02", "noise=nan", "mu_walk="),
    *("mu_walk=1,mu_walk=2", "reset_after=1.5", "steel", "steel=run.csv", "=run.csv", "steel=", ","),
    *("tcp://127.0.0.1:1", "tcp://", "nobody:99999999", "friction-damper"),
)
_READING = ("--rig", "--map", "--effects", "--steering-ratio", "--from", "--to")
OPTIONS = {
    "simulate": (*_READING, "--model", "--out", "--ground", "--mu"),
    "estimate": (
        *(*_READING, "--model", "--out", "--observer", "--picture", "--tuning", "--tune", "--ground"),
        *("--smooth", "--summary", "--jobs", "--scheduler"),
    ),
    "diagnose": (
        *(*_READING, "--holdout", "--out", "--robust", "--jobs", "--ground", "--force", "--scheduler"),
    ),
    "identify": (
        *("--rig", "--map", "--free-decay", "--out", "--write-rig"),
        *("--vehicle", "--plates", "--write-vehicle", "--lock-to-lock", "--ground-friction"),
        *("--friction-tolerance",),
    ),
    "compare": (
        *(*_READING, "--model", "--out", "--author", "--declared", "--table", "--picture", "--train"),
    ),
    "codegen": (
        *("--rig", "--model", "--effects", "--out", "--observer", "--real", "--torque", "--name"),
        *("--target", "--tuning", "--ground"),
    ),
    "demo": ("--out", "--examples", "--force"),
    "fetch": ("--out",),
}
EVERYWHERE = ("--json", "--quiet", "--version", "--help")
FLAGS = ("--smooth", "--force", *EVERYWHERE)
"""Options without a value; those of `EVERYWHERE` go with each command."""
USUAL = {"--rig": "rig.toml", "--out": "new.csv", "--observer": "ekf", "--free-decay": "run.csv"}
READ = ("--rig", "--model", "--holdout", "--free-decay", "--train")
"""Options that name a file to be read; so does the word behind the command."""
FILES = ("run.csv", "link.csv", "rig.toml", "model.json")
_ODD, _RARE = 0.3, 0.05
_SELDOM = ("--scheduler", "--steering-ratio", "--from", "--to")
_NONE = ("identify", "codegen", "fetch", "demo")
"""Commands without recordings."""


def attempt(number: int) -> str | None:
    """One command line in a folder of its own; what went wrong with it."""
    arguments = command_line(Random(number))
    with folder() as here:
        before, read = set(here.iterdir()), inputs(arguments)
        status, err = outcome_of(arguments)
        lost = [name for name, content in read.items() if not _holds(Path(name), content)]
        left = {path.name for path in set(here.iterdir()) - before}
    fault = None
    if not isinstance(status, int) or status not in (0, 1, 2):
        fault = f"ended with {status!r}"
    elif status and (err.count("\n") != 1 or not err[:-1].isprintable() or len(err) > 2000):
        fault = f"said {err[:200]!r}"
    elif status and left:
        fault = f"left {sorted(left)!r}"
    elif lost:
        fault = f"wrote over {lost!r}"
    return f"{number}: {arguments!r} {fault}" if fault else None


def inputs(arguments: Sequence[str]) -> dict[str, bytes]:
    """Files that a command line names to be read, and what they hold."""
    names = {*arguments[1:2], *(value for option, value in pairwise(arguments) if option in READ)}
    return {name: Path(name).read_bytes() for name in names if name in FILES}


def _holds(path: Path, content: bytes) -> bool:
    return path.is_file() and path.read_bytes() == content


def command_line(random: Random) -> list[str]:
    """A command with its options, some of them odd, missing or twice."""
    command = random.choice(tuple(OPTIONS))
    words = [command]
    if command not in _NONE:
        words.append("run.csv" if random.random() > _ODD else random.choice(NAMES))
    if command == "fetch" and random.random() < _ODD:
        words.append(random.choice(VALUES))
    words += [flag for flag in EVERYWHERE if random.random() < _RARE]
    for option in OPTIONS[command]:
        usual = USUAL.get(option)
        if option in FLAGS:
            words += [option] * (random.random() < _ODD)
        elif random.random() < _ODD * (_RARE if option in _SELDOM else 1):
            words += [option, random.choice((*NAMES, *VALUES))]
        elif usual is not None and random.random() > _ODD / 10:
            words += [option, usual]
    return words


@contextlib.contextmanager
def folder() -> Iterator[Path]:
    """A working folder with a recording, a rig, a model, a pipe and a loop of links, two levels deep."""
    with tempfile.TemporaryDirectory() as top:
        here = Path(top) / "above" / "here"
        (here / "folder").mkdir(parents=True)
        place_inputs(here, "run.csv", "rig.toml", "model.json")
        (here / "link").symlink_to("link")
        (here / "link.csv").symlink_to("run.csv")
        os.mkfifo(here / "pipe")
        with contextlib.chdir(here):
            yield here


def outcome_of(
    arguments: Sequence[str], environment: Mapping[str, str] | None = None
) -> tuple[object, str]:
    """Exit status, or the exception that got out, and standard error; nothing is estimated."""
    out, err = io.StringIO(), io.StringIO()
    hidden = {"BRUSHGRIP_DATA": "nowhere", "XDG_DATA_HOME": "nowhere", **(environment or {})}
    with (
        mock.patch.object(dask_or_local_executor, "PATIENCE", "1s"),
        mock.patch.object(identification, "diagnose", _refuse),
        mock.patch.object(estimate_batch, "estimate_all", _refuse),
        mock.patch.dict(os.environ, hidden),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main(arguments)
        except SystemExit as end:
            return end.code, err.getvalue()
        except BaseException as error:
            return f"{type(error).__name__}: {error}", err.getvalue()
    return None, err.getvalue()


def _refuse(*_: object, **__: object) -> None:
    raise InvalidInputError("work has begun")


CLASSES = {"command_lines": one_by_one(attempt)}
