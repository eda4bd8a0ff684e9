"""Command lines that cannot be: one line, status 2, no file changed; and names that can.

Every fault of a file is in the tests of `identification.reading`.
"""

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from observers.embedded import codegen
from tests.brushgrip.helpers import Run, Write, contents, with_defaults
from tests.each_once import each_once

pytestmark = pytest.mark.usefixtures("interpreted", "no_work", "blank_pictures")
SOURCE_TEXTS = each_once(codegen.source_texts)
"""What `codegen` would write; where a file is in the way that is refused only then."""
DEFAULTS = {
    "simulate": "--rig rig.toml --out new.csv",
    "estimate": "--rig rig.toml --observer ekf --out new.csv",
    "diagnose": "--rig rig.toml --out new",
    "identify": "--rig inertia.toml --out new.json --free-decay run.csv",
    "compare": "--rig rig.toml --out new.json",
    "codegen": "--rig rig.toml --observer ekf --name grip --out new",
    "fetch": "",
    "live": "--rig rig.toml --no-page",
    "plan": "--rig rig.toml --load 400 --out new.csv",
}
"""Options that go before those of a row, which replace them; a row of `brushgrip` has none."""
OVER = "would overwrite what is read"
MODEL = '{"version": 1, "effects": [], "shared": {"k": 2.4e6}, "recordings": {}}'
WRITTEN = (
    "CMakeLists.txt", "check.c", "main.c", "grip.c", "grip.h", "grip.hpp", "grip.json",
    "grip_vector.csv", "grip_sfun.c",
)  # fmt: skip
"""What `codegen` writes."""
FILES = {
    "found.json": MODEL, "models/grip.json": MODEL, "car.dbc": "", "file": "",
    "stiff.json": MODEL.replace("2.4e6", "2.4e7"),
    "sub/author_estimate_run.csv": "", "own_broken.py": "raise RuntimeError('out of\\norder')",
    "own_exit.py": "import sys\nsys.exit(0)", "own_empty.py": "", "ownkit/__init__.py": "",
    "own_mute.py": (
        "class Mute(BaseException):\n    def __str__(self):\n        raise ValueError\nraise Mute"
    ),
    "ownkit/boot.py": (
        "from dataclasses import dataclass\nfrom symbolic import Effect\n"
        "@dataclass(frozen=True, kw_only=True)\nclass Boot(Effect):\n"
        "    def torque(self, signals, values):\n        return 0\n"
    ),
    **{f"ownkit/{module}.py": (
        f"from ownkit.boot import Boot\n"
        f"EFFECTS = [Boot(name='boot', summary='{module}', parameters=())]\n"
    ) for module in ("effects", "again")},
    **{f"has_{name}/{name}": "{}" for name in WRITTEN},
}  # fmt: skip
RESULTS = ("diagnosis.json", "model.json", "report.html", "loops.png")


@pytest.fixture(autouse=True)
def here(
    tmp_path: Path,
    rig: Path,
    write_csv: Write,
    table: dict[str, np.ndarray],
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[None]:
    """The working folder; what is imported from it is forgotten."""
    t, run, text = table["t"], write_csv(), rig.read_text()
    write_csv("text.csv", {"psi": [*t[:3], "left", *t[4:]]})
    write_csv("still.csv", {"t": t * 1e-321})
    write_csv("few.csv", {"M_z": [1.0] * 9 + [""] * 51})
    write_csv("slow.csv", {"psi": 1e-3 * np.sin(t)})
    write_csv("long.csv", {"t": 10 * t})
    write_csv("bare.csv", {"M_z": None})
    write_csv("stiff.csv", top="# k = 1e12\n")
    write_csv("other.csv", {"F_N": np.full(60, 500.0)})
    rigs = {
        "no_k.toml": text.replace("k = 2.4e6", ""), "no_mu.toml": text.replace("mu = 1.2", ""),
        "inertia.toml": text.replace("[tyre]", "J_A = 0.15\n[tyre]"), "rigs/grip.json": text,
        **{f"of_{name}/{name}": text for name in RESULTS},
    }  # fmt: skip
    for name, content in (FILES | rigs).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    for name in ("twin.csv", "sub/run.csv"):
        shutil.copy(run, tmp_path / name)
    for name in ("hard.csv", "hard.png"):
        os.link(run, tmp_path / name)
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "link").symlink_to("nowhere")
    for name in ("report.html", "grip.c"):
        (tmp_path / "linked").mkdir(exist_ok=True)
        (tmp_path / "linked" / name).symlink_to("../ownkit/boot.py")
    monkeypatch.setattr(codegen, "source_texts", SOURCE_TEXTS)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield
    for name in [name for name in sys.modules if name.startswith("own")]:
        del sys.modules[name]


ROWS: list[tuple[str, ...]] = [
    ("diagnose text.csv", "text.csv: row 5", "psi", "'left'", "not a number"),
    ("estimate text.csv", "text.csv: row 5", "'left'"),
    ("identify --free-decay text.csv", "text.csv: row 5", "psi", "not a number"),
    ("diagnose still.csv", "still.csv: row 3", "stands nearly still", "at least 1e-06 s"),
    ("estimate still.csv", "still.csv: row 3"),
    ("diagnose few.csv", "few.csv: M_z is known in 9 of 60 samples, at least 10 needed"),
    ("simulate run.csv stiff.csv", "stiff.csv: row 1: k must lie between"),
    ("compare none", "none: no such recording"),
    ("compare run.csv", "run: ends less than 1.89 s"),
    ("compare slow.csv", "slow: the wheel turns by less than 0.02 rad"),
    ("compare bare.csv", "bare.csv", "M_z"),
    ("identify --free-decay twin.csv", "twin.csv: is the same recording as run.csv"),
    ("diagnose run.csv other.csv --holdout run.csv", "is the same recording as"),
    ("diagnose run.csv --rig no_k.toml", "no_k.toml", "k is missing"),
    ("simulate run.csv --rig no_mu.toml", "brushgrip: run: mu is not known; "),
    ("compare long.csv --rig no_mu.toml", "long: no mu", "--declared MU"),
    ("identify --rig rig.toml", "run.csv: J_A is not known", "[rig]", "# J_A = 0.15"),
    ("codegen --torque M", "lacks J_A and b_t"),
    ("brushgrip diagnose run.csv --out new", "--rig"),
    ("brushgrip none", "none"), ("brushgrip diagnose", "REC"),
    ("brushgrip compare run.csv --out new.json", "run.csv", "--rig"),
    ("brushgrip identify --rig rig.toml --out new.json", "--free-decay"),
    *((f"brushgrip identify {given}", "give --free-decay, with --rig and --write-rig, or --vehicle")
      for given in ("--vehicle c.toml", "--plates p.csv", "--plates p.csv --free-decay p.csv",
                    "--vehicle c.toml --plates p.csv --rig r.toml")),
    ("simulate run.csv --model rig.toml", "rig.toml"),
    ("codegen --model none.json", "none.json"),
    ("compare run.csv --model none.json", "none.json"),
    ("codegen --model sub", "sub: holds no model.json, so it is not the folder of a diagnosis"),
    ("brushgrip plan --rig rig.toml", "--load is missing"),
    ("brushgrip estimate run.csv --vehicle c.toml --steering-ratio 15", "steering_ratio in its vehicle"),
    ("brushgrip plan", "--rig and --vehicle are both missing"),
    ("plan --target a_lot", "--target a_lot", "expected a number"),
    ("plan --target 0", "target must be a share"),
    ("plan --limit speed=3", "--limit speed=3", "angle, rate"),
    ("plan --limit time=1,time=2", "each name once"),
    ("plan --limit torque=x", "--limit torque=x", "expected a number, got 'x'"),
    ("plan --limit acceleration=-1", "limit acceleration must be"),
    ("plan --mu ice", "--mu ice", "expected a number"),
    ("plan --vehicle car.toml", "--rig and --vehicle"),
    ("brushgrip live udp:5005", "needs the rig"),
    ("live run.csv --speed 0", "--speed must be finite"),
    ("live udp:99999", "expected a port from 1 to 65535"),
    ("live can:virtual", "expected can:INTERFACE:CHANNEL"),
    ("live can:virtual:x", "--dbc names the database"),
    ("live replay:nowhere", "no such recording"), ("live nowhere", "no such recording"),
    ("live udp:no.such.host:5005", "the source cannot be opened"),
    ("live run.csv --model stiff.json", "10 times the declared one"),
    *((f"live udp:5005 --send {to}", f"--send {to}: allowed") for to in ("can:nothing:x", "mail:me")),
    ("live udp:5005 --send udp:0", "expected a port"),
    ("simulate run.csv --map psi=x:parsec", "'parsec' is no unit of psi"),
    *((f"{c} run.csv --ground steel=no", "--ground steel=no: no recording 'no'; given are run")
      for c in ("estimate", "simulate", "diagnose")),
    ("codegen --ground ice", "--ground ice: this model knows no grounds"),
    *((f"{line} {line[line.index('--') :]}", f"{line.split()[-2]} is given twice") for line in (
        "brushgrip estimate run.csv --rig rig.toml", "brushgrip simulate run.csv --model found.json",
        "brushgrip plan --load 400", "brushgrip live - --tuning clean",
    )),
    ("brushgrip diagnose run.csv --force --force", "--force is given twice; it may be given once"),
    ("simulate run.csv --mu -1", "--mu must be finite and greater than 0, got -1"),
    ("compare run.csv --declared 1 2", "2 values for 1 recordings"),
    ("compare run.csv --declared -1", "--declared"),
    ("compare run.csv --declared nan", "--declared must be finite", "nan"),
    ("compare run.csv --declared steel", "--declared", "number"),
    ("compare run.csv --author nowhere", "nowhere: no such folder"),
    *((f"diagnose run.csv --jobs {n}",) for n in ("1e20", "9" * 21, "0", "257")),
    ("estimate run.csv --observer crystal", "ekf"),
    ("estimate run.csv --observer root --model found.json", "root", "--model", "ekf"),
    ("estimate run.csv --observer root --tuning clean", "root has no tuning"),
    ("estimate run.csv --observer root --by-direction", "root has", "one friction", "mhe"),
    ("estimate run.csv --stiffness-state --by-direction", "--by-direction has no k as a state"),
    ("estimate run.csv --smooth --by-direction", "--smooth", "not --by-direction"),
    ("estimate run.csv --observer mhe --smooth", "--smooth", "--observer ekf"),
    ("estimate run.csv other.csv --summary t.csv --picture p.png", "--picture is that of one recording"),
    ("estimate run.csv other.csv --summary run.csv", OVER),
    ("estimate run.csv other.csv --summary t_run.csv --out t.csv", "must name different files"),
    ("estimate run.csv other.csv --summary t.csv --observer root --tune gate=9", "root has no tuning"),
    ("codegen --tune mu=9", "mu must lie between least and greatest"),
    ("codegen --tune mist=1", "expected NAME=NUMBER with a name out of mu, mu_std"),
    *((f"estimate run.csv --tune {values}", said) for values, said in (
        ("noise", "expected a number, got ''"),
        ("reset_after=1.5", "expected a whole number, got '1.5'"),
        ("noise=0.1,noise=0.2", "noise is given twice"),
        ("noise=-1", "--tune: noise must be greater than 0, got -1.0"),
    )),
    ("codegen --window 30", "--window is that of the MHE"),
    ("codegen --observer mhe --window 0", "--window must be from 1 to 1000 samples, got 0"),
    ("codegen --observer mhe --window 100000", "--window must be from 1 to 1000 samples"),
    ("codegen --tunable all --target ros2", "--tunable is for the targets c, fmu and fmu3"),
    ("codegen --name 2wheels", "name must be a name in C"),
    ("codegen --name x__", "name must not have two _ in a row"),
    *((f"codegen --name {name}", "name must not be that of a file beside the code, or a target of CMake")
      for name in ("main", "check", "example", "test", "fmi2 --target fmu")),
    *((f"codegen --name {name}", "name must not be that of a keyword of C or C++")
      for name in ("while", "class")),
    *((f"codegen --name {name}", "name must not be that of a header of C")
      for name in ("stdint", "features")),
    *((f"codegen --name {name}", "name must not be that of a function of C")
      for name in ("printf", "cosf")),
    ("estimate run.csv --out mu.png", "mu.png: the result needs a name such as .csv"),
    ("plan --rig rig.toml --load 400 --out p.png", "p.png: the result needs a name such as .csv"),
    ("estimate run.csv --picture mu.pdf", "mu.pdf", ".png"),
    ("compare run.csv --picture boxes.pdf", "boxes.pdf", ".png"),
    ("compare run.csv --table new.json", "must be different files"),
    ("identify --out id.png", ".png is its picture"),
    *((f"{c} --out file/out", "file/out", "cannot be written")
      for c in ("diagnose run.csv", "estimate run.csv", "simulate run.csv")),
    ("identify --out file/id.json", "cannot be written"),
    ("diagnose run.csv --out run.csv", "run.csv", "is not a folder"),
    *((f"{line} --out {out}", OVER) for line, outs in {
        "estimate run.csv": ("nosub/../run.csv", "nosub/../rig.toml", "car.dbc --map dbc=car.dbc",
                             "new.csv --picture nosub/../hard.png", "found.json --model found.json"),
        "compare run.csv --author sub --declared 1": (
            "nosub/../run.csv", "nosub/../car.dbc --map dbc=car.dbc",
            *(f"new.json --{what}" for what in
              ("table nosub/../run.csv", "table nosub/../rig.toml", "picture nosub/../hard.png"))),
        "simulate run.csv": ("nosub/../run.csv", "nosub/../rig.toml", "car.dbc --map dbc=car.dbc",
                             "nosub/../found.json --model found.json"),
        "identify": ("inertia.toml", "nosub/../run.csv", "car.dbc --map dbc=car.dbc"),
        "identify --write-rig inertia.toml": ("new.json",),
    }.items() for out in outs),
    *((f"estimate run.csv --summary {out}", OVER)
      for out in ("rig.toml", "nosub/../hard.csv", "car.dbc --map dbc=car.dbc")),
    *((f"codegen --out {place}has_{name}", f"{name}: is in the way and was not generated by brushgrip")
      for name in WRITTEN for place in ("", "nosub/../" * (name == "main.c"))),
    *((f"codegen --{what}s/grip.json --out {place}{what.split()[1]}s", "grip.json: " + OVER)
      for what in ("rig rig", "model model") for place in ("", "nosub/../")),
    *((f"diagnose run.csv --rig of_{name}/{name} --out nosub/../of_{name}", OVER) for name in RESULTS),
    ("compare sub/run.csv --declared 1 --out sub/author_estimate_run.csv", OVER),
    ("compare run.csv --declared 1 --author sub --out nosub/../sub/author_estimate_run.csv", OVER),
    *((f"{line} --effects ownkit.effects --out ownkit/{source}.py", OVER)
      for source in ("effects", "boot", "__init__")
      for line in ("estimate run.csv", "compare run.csv --declared 1", "simulate run.csv")),
    ("diagnose run.csv --effects ownkit.effects --out linked", OVER),
    ("codegen --effects ownkit.effects --out linked", OVER),
    *((f"{line} --effects own_exit", "--effects own_exit: cannot be imported: SystemExit: 0")
      for line in ("diagnose run.csv", "simulate run.csv", "compare run.csv", "codegen")),
    ("estimate run.csv --effects own_absent", "own_absent: cannot be imported: ModuleNotFoundError"),
    ("estimate run.csv --effects own_broken", "cannot be imported: RuntimeError: out of order"),
    ("estimate run.csv --effects own_mute", "own_mute: cannot be imported: Mute: its message cannot be"),
    ("estimate run.csv --effects ../own_exit", "--effects ../own_exit: cannot be imported"),
    ("estimate run.csv --effects own_empty", "EFFECTS"),
    ("estimate run.csv --effects ownkit.effects,ownkit.again", "effect 'boot' is declared by another"),
]  # fmt: skip
"""A command line, and words of the message."""


@pytest.mark.parametrize("part", range(5))
def test_what_cannot_be(run: Run, part: int) -> None:
    """A fifth of the rows, which share what is in the folder."""
    for line, *message in ROWS[part::5]:
        refuse(run, line.split(), *message)


def refuse(run: Run, words: list[str], *message: str) -> None:
    before, (command, *given) = contents(Path()), words
    usual = [] if command == "brushgrip" else [command, *DEFAULTS[command].split()]
    line = [*usual[:1], *with_defaults(usual[1:], given)]
    run(*line).refused(*message)
    assert contents(Path()) == before


LONG = "n" * 300
NO_NAMES = ["", ".", "/", "..", "a/..", LONG, "loop", "loop/x"]
NO_FILE, NO_FOLDER = [*NO_NAMES, "run.csv/x"], [LONG, "loop", "loop/x", "run.csv", "run.csv/x"]
PLACES = {
    "diagnose {}": [*NO_NAMES, f"loop/{LONG}", "~nobody_of_this_name/x"],
    "simulate run.csv --rig {}": NO_NAMES,
    "simulate run.csv --model {}": NO_NAMES,
    "codegen --model {}": NO_NAMES,
    "simulate run.csv --out {}": NO_FILE,
    "estimate run.csv --out {}": NO_FILE,
    "estimate run.csv --picture {}": NO_FILE,
    "identify --out {}": NO_FILE,
    "compare run.csv --out {}": NO_FILE,
    "compare run.csv --table {}": NO_FILE,
    "diagnose run.csv --out {}": NO_FOLDER,
    "codegen --out {}": NO_FOLDER,
    "fetch --out {}": NO_FOLDER,
}
"""Command lines, and names of nothing in the place of a file or folder."""


@pytest.mark.parametrize("line", PLACES)
def test_names_of_nothing(run: Run, line: str) -> None:
    for name in PLACES[line]:
        refuse(run, [name if word == "{}" else word for word in line.split()])


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
    written = ["e.csv", "e.png", "e.provenance.json", f"{name}.csv"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(written)


def test_a_full_disk(run: Run) -> None:
    before = contents(Path())
    outcome = run("simulate", "run.csv", "--rig", "rig.toml", "--out", "/dev/full")

    assert (outcome.status, outcome.err) == (1, "brushgrip: cannot write: No space left on device\n")
    assert contents(Path()) == before
