"""The cache of what tests compile: nothing is compiled twice, and nothing stale is taken."""

import subprocess
from pathlib import Path

import pytest

from symbolic.compilation.compiled import compiler
from tests.compile_once import compile_once

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")


@pytest.fixture(autouse=True)
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))


def printed(folder: Path, name: str = "number") -> str:
    compile_once([str(compiler()), "main.c", "-o", name], folder, name)
    return subprocess.run([folder / name], capture_output=True, text=True, check=True).stdout


def project(folder: Path, number: int = 3) -> Path:
    folder.mkdir(exist_ok=True)
    text = '#include <stdio.h>\n#include "part.c"\nint main(void) { printf("%d", part()); return 0; }\n'
    (folder / "main.c").write_text(text)
    (folder / "part.c").write_text('#include "number.h"\nint part(void) { return NUMBER; }\n')
    (folder / "number.h").write_text(f"#define NUMBER {number}\n")
    return folder


def test_the_same_text_elsewhere_is_not_compiled_again(tmp_path: Path) -> None:
    assert printed(project(tmp_path / "one")) == "3"
    assert len(list((tmp_path / "cache" / "tests").iterdir())) == 1
    printed(project(tmp_path / "two"))
    printed(project(tmp_path / "two"))

    assert len(list((tmp_path / "cache" / "tests").iterdir())) == 1


@pytest.mark.parametrize(("file", "old", "new"), [("number.h", "3", "4"), ("part.c", "NUMBER;", "4;")])
def test_a_change_of_what_is_included_is_seen(file: str, old: str, new: str, tmp_path: Path) -> None:
    folder = project(tmp_path / "one")
    assert printed(folder) == "3"
    (folder / file).write_text((folder / file).read_text().replace(old, new))

    assert printed(folder) == "4"


def test_a_failure_is_not_kept(tmp_path: Path) -> None:
    folder = project(tmp_path / "one")
    (folder / "number.h").write_text("#error no number\n")

    for _ in range(2):
        with pytest.raises(subprocess.CalledProcessError):
            printed(folder)
    assert printed(project(folder)) == "3"
