"""Functions compiled to machine code through C, with a cache; interpreted where no compiler is found."""

import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import casadi as ca

FLAGS = (
    "-O2",
    "-ftree-vectorize",
    "-march=native",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-shared",
)
VECTORISED = (
    "-O1",
    "-finline-small-functions",
    "-fexpensive-optimizations",
    "-std=gnu90",
    "-fno-semantic-interposition",
    "-fvect-cost-model=dynamic",
    "-D__FAST_MATH__",
    "-lmvec",
)
"""With these all loops take several numbers at a time, in two thirds of the time for compiling.

By the C of 1990 casadi's fmin and fmax are a comparison and not a call, the same but for a NaN; its
log1p, expm1 and hypot would lose digits, and no model has them. The expensive optimisations keep scalar
calls quick beside wide registers. glibc's exp and log of several numbers are right to four units in the
last place; the macro merely shows them."""


def cache_directory() -> Path:
    """Where compiled Functions are kept: `BRUSHGRIP_CACHE`, else the user's cache folder."""
    if own := os.environ.get("BRUSHGRIP_CACHE"):
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brushgrip"


@cache
def compiler() -> str | None:
    """The C compiler in use, `CC` or cc; None where there is none or `BRUSHGRIP_INTERPRET` is set."""
    if os.environ.get("BRUSHGRIP_INTERPRET"):
        return None
    return shutil.which(os.environ.get("CC", "cc"))


def compiled(function: ca.Function, *, vectorised: bool = False) -> ca.Function:
    """The same Function in machine code; the Function itself where it cannot be compiled.

    The library is cached under a digest of the generated C, the compiler and the flags, so a changed
    model never meets a stale library, and concurrent processes may share the folder.

    Args:
        function: what to compile.
        vectorised: exp and log many numbers at a time, where the C library can; quicker, and not to the
            last bit what other code makes of the same Function.
    """
    command = compiler()
    if command is None:
        return function
    flags = (*FLAGS, *VECTORISED) if vectorised and _takes(command, VECTORISED) else FLAGS
    try:
        return ca.external(function.name(), str(_library(function, command, flags)))
    except (OSError, subprocess.SubprocessError, RuntimeError):
        return function


@cache
def _takes(command: str, flags: tuple[str, ...]) -> bool:
    """Whether the compiler takes these flags beside the usual ones, tried on a program of one line."""
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "try.c"
        source.write_text("int one(void) { return 1; }\n")
        line = [command, str(source), *FLAGS, *flags, "-o", str(source.with_suffix(".so"))]
        try:
            subprocess.run(line, check=True, capture_output=True, timeout=60)
        except (OSError, subprocess.SubprocessError):
            return False
    return True


@cache
def _processor() -> str:
    """What -march=native stands for here, so that a cache shared by machines stays right."""
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return " ".join(platform.uname())
    return next((line for line in text.splitlines() if line.startswith("flags")), text)


def _library(function: ca.Function, command: str, flags: tuple[str, ...]) -> Path:
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    source = generator.dump()
    digest = hashlib.sha256("\0".join((source, command, _processor(), *flags)).encode()).hexdigest()[:24]
    folder = cache_directory()
    library = folder / f"{function.name()}_{digest}.so"
    if not library.exists():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            c_file, built = Path(scratch) / "function.c", Path(scratch) / "function.so"
            c_file.write_text(source)
            subprocess.run(
                [command, str(c_file), *flags, "-o", str(built), "-lm"],
                check=True,
                capture_output=True,
                timeout=300,
            )
            built.replace(library)
    return library
