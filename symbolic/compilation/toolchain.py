"""How a C compiler is found and told to make a library: as cc understands it, or as Microsoft's cl."""

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from symbolic.compilation.operating_system import COMPILERS, IS_WINDOWS, kill_process_group

MICROSOFT = ("cl", "clang-cl")
"""Compilers that take Microsoft's options."""


def found_compiler(environment: Mapping[str, str]) -> str | None:
    """Path of the C compiler that `CC` names, else of one by its usual name; None for none."""
    names = (environment["CC"],) if "CC" in environment else COMPILERS
    return next(filter(None, map(shutil.which, names)), None)


def compiler_command(
    command: str, sources: Sequence[str], library: str, flags: Sequence[str], *,
    windows: bool = IS_WINDOWS,
) -> list[str]:  # fmt: skip
    """The command line that makes a library; run it where the sources are.

    Flags are as for cc; Microsoft's compilers take usual ones of their own. Libraries of Windows know
    neither -fPIC nor -lm.
    """
    if Path(command).stem.lower() in MICROSOFT:
        return [command, "/nologo", "/O2", "/fp:precise", "/std:c11", "/LD", *sources, f"/Fe{library}"]
    if windows:
        return [command, *sources, *(flag for flag in flags if flag != "-fPIC"), "-o", library]
    return [command, *sources, *flags, "-o", library, "-lm"]


def run_compiler(line: Sequence[str], folder: Path) -> None:
    """Run a compiler in a folder, which has its temporary files; an interrupt ends all that it started.

    OSError where it cannot be started, subprocess.SubprocessError where it fails or takes too long.
    """
    environment = {**os.environ, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))}
    silent = subprocess.DEVNULL
    # A session of its own: the processes that it starts are in one group, which can be killed whole.
    with subprocess.Popen(
        line, cwd=folder, stdout=silent, stderr=silent, env=environment, start_new_session=True
    ) as running:
        try:
            status = running.wait(timeout=300)
        except BaseException:
            kill_process_group(running)
            running.wait()
            raise
    if status:
        raise subprocess.CalledProcessError(status, line[0])
