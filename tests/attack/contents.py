"""What stands in generated files: effects whose names, units and bounds are odd."""

import json
import random
import re
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as Xml
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from observers import Ekf
from observers.embedded import DOUBLE, SINGLE, generate, generate_ros2
from observers.embedded.fmi_versions import VERSIONS
from observers.embedded.fmu import _archive_texts
from symbolic import BrushgripError, Effect, Model, Parameter, Rig
from tests.attack.attack_class import one_by_one
from tests.attack.oracle import check_message

TEXTS = (
    *("N m/rad", "", '"', "'", "&", "<b>", "]]>", "*/", "/*", "//", "\\", "\\n", "%s%n", "%%", "${x}"),
    *("{{x}}", "µm", "°", "Ω·m²", "two\nlines", "\r", "\0", "\x1b[2J", "\udcff", "??/", "a" * 3000),
    *("/begin", "/end", "-->", "{% if %}", "#define x", "\u2028", "\ufffe"),
)
NAMES = (
    *("own", "Own", "if", "int", "double", "psi", "mu", "k"),
    *("x" * 80, "größe", "名", "o_", "_o", "a__b"),
)
NUMBERS = (0.0, 1e-320, 1e300, -1e300, float("inf"), -float("inf"), 1.0, -1.0, 1e-9)


@dataclass(frozen=True, kw_only=True)
class Odd(Effect):
    """A spring of the user's own, told in odd words."""

    name: str
    summary: str
    parameters: tuple[Parameter, ...]

    def torque(self, signals: Any, values: Any) -> Any:
        """All parameters times the angle."""
        return -sum(values[parameter.coordinate_name] for parameter in self.parameters) * signals.psi


def odd_effect(chance: random.Random) -> Odd:
    """An effect that may be refused."""
    parameters = []
    for _ in range(chance.randint(1, 2)):
        lower, upper = sorted(chance.choice(NUMBERS) for _ in range(2))
        start = min(max(chance.choice((0.0, 1.0)), lower), upper)
        parameters.append(Parameter(
            name=chance.choice((*NAMES, *TEXTS)) if chance.random() < 0.3 else f"c{len(parameters)}",
            unit=chance.choice(TEXTS), neutral=0.0, start=start, lower=lower, upper=upper, scale=1.0,
        ))  # fmt: skip
    name = chance.choice(NAMES) if chance.random() < 0.4 else "own"
    return Odd(name=name, summary=chance.choice(TEXTS), parameters=tuple(parameters))


def check_xml(text: str) -> None:
    """Well-formed, and what an importer shows of each variable is a name and a number."""
    root = Xml.fromstring(text.encode())
    for variable in root.iter():
        if "start" in variable.attrib and variable.attrib["start"] not in ("NaN", "INF", "-INF"):
            float(variable.attrib["start"])


def check_a2l(text: str) -> None:
    """Strings and comments end, blocks nest, numbers are numbers that the format knows."""
    bare = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    plain = re.sub(r'"(?:[^"\\\n]|\\.)*"', ' "" ', bare)
    assert plain.count('"') % 2 == 0
    assert "*/" not in plain
    assert plain.replace('""', "").count('"') == 0, "a string without end"
    words, blocks = plain.split(), []
    for at, word in enumerate(words):
        if word == "/begin":
            blocks.append(words[at + 1])
        elif word == "/end":
            assert blocks.pop() == words[at + 1]
        assert word.lower() not in ("inf", "-inf", "nan"), f"the number {word}"
    assert blocks == []


def check_c(folder: Path) -> None:
    """The code and the example parse without a warning."""
    line = ["cc", "-std=c99", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "odd.c", "main.c"]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:300]


def attempt(number: int) -> str | None:
    """One effect: refused in a line, or in files that parse and compile."""
    chance = random.Random(number)
    real = chance.choice((SINGLE, DOUBLE))
    try:
        effect = odd_effect(chance)
        values = {f"{effect.name}.{parameter.name}": parameter.start for parameter in effect.parameters}
        model = Model(effects=(effect,))
        observer = Ekf(model=model, values={"k": 2.4e6, **values}, rig=Rig(a=0.045, e=0.009))
        with tempfile.TemporaryDirectory() as top:
            folder = Path(top)
            kind = chance.choice(("c", "c", "fmu", "ros2"))
            if kind == "fmu":
                version = chance.choice(list(VERSIONS.values()))
                texts = _archive_texts(observer, real, "odd", version, tunable="all")
                for text in (text for name, text in texts.items() if name.endswith(".xml")):
                    check_xml(text)
            elif kind == "ros2":
                generate_ros2(observer, folder, real, name="odd_ros")
                check_xml(next(folder.rglob("package.xml")).read_text("utf-8"))
            else:
                generate(observer, folder, real, name="odd", tunable="all")
                json.loads((folder / "odd.json").read_text("utf-8"))
                check_a2l((folder / "odd.a2l").read_text("utf-8"))
                if chance.random() < 0.5 and shutil.which("cc"):
                    check_c(folder)
    except BrushgripError as error:
        check_message(error)
    except Exception as error:
        return f"{number}: {effect!r:.150}: {type(error).__name__}: {error}"
    return None


CLASSES = {"contents": one_by_one(attempt)}
