"""Compilers that tests start themselves, with the cache that compiled models have."""

import hashlib
import os
import platform
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from symbolic.compilation.cache_folder import cache_directory
from symbolic.compilation.toolchain import found_compiler

OPTIMISATION = os.environ.get("BRUSHGRIP_TEST_OPTIMISATION", "-O0")
"""Flag under which generated C is compared with Python; -O0 compiles in a third of the time."""
UNOPTIMISED = """#!/bin/sh
case " $* " in *" -lmvec "*) exec {0} "$@" ;; esac
exec {0} "$@" -O0
"""
"""A compiler by whose last level scalar models take a fifth of the time; loops keep their vectors."""


def compile_unoptimised() -> None:
    """Name such a compiler in `CC`, for the tests and for what they start; its path never changes."""
    script = cache_directory() / "tests" / "cc"
    if os.name != "posix" or (command := found_compiler(os.environ)) in (None, str(script)):
        return
    script.parent.mkdir(parents=True, exist_ok=True)
    half = script.with_name(f"cc.{os.getpid()}")
    half.write_text(UNOPTIMISED.format(command), "utf-8")
    half.chmod(0o700)
    half.replace(script)
    os.environ["CC"] = str(script)


def compile_once(command: Sequence[str], folder: Path, out: str) -> None:
    """Run a compiler in a folder, unless it made the same file of the same sources before.

    The cache belongs to the user and outlives the tests, so that neither the next run nor a parallel
    worker compiles the same text again.
    """
    kept = cache_directory() / "tests" / _digest(command, folder, out)
    if not kept.exists():
        subprocess.run(command, cwd=folder, check=True, timeout=300)
        kept.parent.mkdir(parents=True, exist_ok=True)
        half = kept.with_name(f"{kept.name}.{os.getpid()}")
        shutil.copy2(folder / out, half)
        half.replace(kept)
    else:
        shutil.copy2(kept, folder / out)


def _digest(command: Sequence[str], folder: Path, out: str) -> str:
    """Digest of the command and of all that it compiles or links, not of where the folder stands."""
    where = command.index("-o")
    line = [*command[:where], *command[where + 2 :]]
    command = [*line, "-E", "-P"]
    preprocessed = subprocess.run(command, cwd=folder, check=True, capture_output=True).stdout
    objects = [(folder / part).read_bytes() for part in line if part.endswith(".o")]
    words = [Path(part).name if part.endswith(".c") else part for part in (*line, out)]
    # A flag may ask for the code of this very machine.
    parts = (platform.node().encode(), preprocessed, *objects, *(word.encode() for word in words))
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:24]
