"""Runs an example in the process of the tests: what is imported and compiled once serves all of them."""

import importlib
import re
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NUMBER = r"([-+.\de]+)"


@dataclass(frozen=True, kw_only=True)
class Printed:
    """Exit status of a script, and what it printed."""

    status: int
    out: str
    err: str


def execute(example: str, folder: Path, *arguments: object, data: Path | None = None) -> Printed:
    """Call a script's main function as if started in a folder; data are published measurements."""
    out, err = StringIO(), StringIO()
    line = [str(EXAMPLES / example), *map(str, arguments)]
    with pytest.MonkeyPatch.context() as place, redirect_stdout(out), redirect_stderr(err):
        place.chdir(folder)
        place.setenv("XDG_DATA_HOME", str(folder / "none"))
        place.delenv("BRUSHGRIP_DATA", raising=False)
        if data is not None:
            place.setenv("BRUSHGRIP_DATA", str(data))
        with patch.object(sys, "argv", line), patch.object(sys, "path", [*sys.path]):
            try:
                importlib.import_module(Path(example).stem).main()
            except SystemExit as exit_:
                return Printed(status=int(exit_.code or 0), out=out.getvalue(), err=err.getvalue())
    return Printed(status=0, out=out.getvalue(), err=err.getvalue())


def numbers(text: str, pattern: str) -> list[float]:
    """What the groups of a pattern match in a text, one after the other."""
    return [float(each) for found in re.finditer(pattern, text, re.MULTILINE) for each in found.groups()]


def printed_by(
    example: str, tmp_path: Path, *arguments: str, data: Path | None = None, leaves: str = ""
) -> str:
    """What the script prints, run from an empty folder, in which it leaves this file or nothing."""
    printed = execute(example, tmp_path, *arguments, data=data)
    assert printed.status == 0, printed.err
    assert printed.err == ""
    assert [path.name for path in tmp_path.iterdir()] == ([leaves] if leaves else [])
    if leaves.endswith(".png"):
        assert (tmp_path / leaves).read_bytes().startswith(b"\x89PNG")
    return printed.out
