"""Wheel and sdist as they are built, and commands that know nothing of the checkout."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


def finished(*command: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """A command that knows nothing of the checkout."""
    without = ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONDONTWRITEBYTECODE")
    environment = {k: v for k, v in os.environ.items() if k not in without}
    return subprocess.run(
        [str(part) for part in command], cwd=folder, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


def run(*command: str | Path, folder: Path) -> str:
    """Standard output of such a command, which has to succeed."""
    process = finished(*command, folder=folder)
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


def build(repository_root: Path, folder: Path) -> Path:
    """A folder with both, the wheel made of the sdist."""
    pytest.importorskip("build")
    folder.mkdir(exist_ok=True)
    run(sys.executable, "-m", "build", "--outdir", folder, repository_root, folder=folder)
    return folder
