"""The code on the pages runs: Python blocks and commands, in the order of the page."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from brushgrip import main

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```", re.MULTILINE | re.DOTALL)
QUICK = ["README.md", "docs/start/controller.md", "docs/start/own_data.md"]
WHOLE = ["docs/start/ecu.md", "docs/start/own_recording.md"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for path in (ROOT / "examples" / "recordings").iterdir():
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("page", [*QUICK, *(pytest.param(p, marks=pytest.mark.long) for p in WHOLE)])
@pytest.mark.usefixtures("folder")
def test_the_code_of_a_page_runs(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    names = {}
    blocks = BLOCK.findall(text)
    assert blocks
    for language, code in blocks:
        if language == "python":
            exec(compile(code, page, "exec"), names)
        for line in code.replace("\\\n", "").splitlines() if language == "sh" else ():
            with pytest.raises(SystemExit) as end:
                main(shlex.split(line)[1:])
            assert end.value.code == 0, line
