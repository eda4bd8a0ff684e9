"""The cache of what tests compile: nothing is compiled twice, and nothing stale is taken."""

import subprocess
from pathlib import Path

import pytest

from symbolic.compilation.compiled_function_cache import compiler
from tests.compile_once import compile_once

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")


@pytest.fixture(autouse=True)
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))


def printed(folder: Path, name: str = "number") -> str:
    compile_once([str(compiler()), "main.c", "-o", name], folder, name)
    return subprocess.run([folder / name], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("changed", ["number.h", "part.c"])
def test_only_what_is_compiled_counts(tmp_path: Path, changed: str) -> None:
    text = '#include <stdio.h>\n#include "part.c"\nint main(void) { printf("%d", NUMBER); return 0; }\n'
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "main.c").write_text(text)
        (tmp_path / name / "part.c").write_text('#include "number.h"\n')
        (tmp_path / name / "number.h").write_text("#define NUMBER 3\n")
        assert printed(tmp_path / name) == "3"
    assert len(list((tmp_path / "cache" / "tests").iterdir())) == 1
    for _ in range(2):
        (tmp_path / "one" / changed).write_text("#error no number\n")
        with pytest.raises(subprocess.CalledProcessError):
            printed(tmp_path / "one")
    (tmp_path / "one" / changed).write_text("#define NUMBER 4\n")
    assert printed(tmp_path / "one") == "4"
