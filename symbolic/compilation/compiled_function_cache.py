"""Functions compiled to machine code through C, with a cache; interpreted where no compiler is found."""

import ctypes
import errno
import hashlib
import logging
import os
import platform
import shutil
import subprocess
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import TypeVar

import casadi as ca

from symbolic.compilation.cache_folder import private_cache, reason_for_distrust, replacement_cache
from symbolic.compilation.operating_system import COMPILERS, LIBRARY_SUFFIX, cpuinfo_value
from symbolic.compilation.self_cleaning_folder import temporary_folder
from symbolic.compilation.toolchain import compiler_command, found_compiler, run_compiler
from symbolic.errors import cut_to_one_line

_LOG = logging.getLogger(__name__)
Loaded = TypeVar("Loaded")
FLAGS = (
    *("-O2", "-ftree-vectorize"),
    "-mcpu=native" if platform.machine() in ("arm64", "aarch64") else "-march=native",
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared"),
)
"""Nothing is contracted, so that steps one by one and many in one call agree to the last digit."""
VECTORISED = (
    *("-O1", "-finline-small-functions", "-fexpensive-optimizations", "-std=gnu90"),
    *("-fno-semantic-interposition", "-fvect-cost-model=dynamic", "-D__FAST_MATH__", "-lmvec"),
)
"""With these all loops take several numbers at a time, in two thirds of the time for compiling.

By the C of 1990 casadi's fmin and fmax are a comparison and not a call, the same but for a NaN; its
log1p, expm1 and hypot would lose digits, and no model has them. The expensive optimisations keep scalar
calls quick beside wide registers. glibc's exp and log of several numbers are right to four units in the
last place; the macro merely shows them."""

LOOPS = ("-O3", "-fno-semantic-interposition", "-D__FAST_MATH__", "-lmvec")
"""Flags that give the loops of `bristle_kernel.c` glibc's vector exp and log."""
BRANCHES = "-fno-tree-pre"
"""Turns off gcc's partial-redundancy elimination, after which loops with branches call exp and log one
number at a time. clang does not know the flag."""
WIDE = "-mprefer-vector-width=512"
"""Eight bristles at a time where the processor can, in a quarter less time; no result of an operation
changes, but glibc may round another exp and log."""
UNWRITABLE = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT)
"""Errors by which a folder cannot take a library."""
_WARNED: set[str] = set()
"""Compilers whose failure has been warned of."""


@cache
def compiler() -> str | None:
    """The C compiler in use, see `found_compiler`; None where `BRUSHGRIP_INTERPRET` is set, too."""
    if os.environ.get("BRUSHGRIP_INTERPRET"):
        return None
    return found_compiler(os.environ)


def compiled(function: ca.Function, *, vectorised: bool = False) -> ca.Function:
    """The same Function in machine code; the Function itself where it cannot be compiled.

    The library is cached under a digest of the generated C, the compiler and the flags, so a changed
    model never meets a stale library, and concurrent processes may share the folder. A second digest in
    its name, of its content, tells a whole library from a damaged one, which is built anew. A folder
    that another user owns, may write to or may replace is not used: what it holds would be run.

    Args:
        function: what to compile.
        vectorised: exp and log many numbers at a time, where the C library can; quicker, and not to the
            last bit what other code makes of the same Function.
    """
    command = compiler()
    if command is None:
        if not os.environ.get("BRUSHGRIP_INTERPRET"):
            _warn_not_compiled(
                "",
                f"no C compiler is found ({', '.join(('CC', *COMPILERS))}): models are interpreted,"
                " which is slow; BRUSHGRIP_INTERPRET=1 says that this is meant",
            )
        return function
    flags = (
        (*FLAGS, *VECTORISED) if vectorised and _compiler_accepts_flags(command, VECTORISED) else FLAGS
    )
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    load = partial(ca.external, function.name())
    try:
        return _load_or_build_library(function.name(), generator.dump(), command, flags, load)
    except (OSError, subprocess.SubprocessError, RuntimeError) as error:
        reason = cut_to_one_line(str(error).partition("\n")[0])
        line = f"models are not compiled ({reason}), and interpreted instead, which is slow"
        _warn_not_compiled(command, line)
        return function


def _warn_not_compiled(command: str, line: str) -> None:
    if command not in _WARNED:
        _WARNED.add(command)
        _LOG.warning("brushgrip: %s", line)


@cache
def _compiler_accepts_flags(command: str, flags: tuple[str, ...]) -> bool:
    """Whether the compiler takes these flags beside the usual ones, tried once for a cache."""
    try:
        _load_or_build_library("one", "int one(void) { return 1; }\n", command, (*FLAGS, *flags), str)
    except (OSError, subprocess.SubprocessError):
        return False
    return True


@cache
def _compiler_fingerprint(command: str) -> str:
    """Which build of a compiler a command runs, as another one may take other flags."""
    place = Path(shutil.which(command.split()[0]) or command).resolve()
    state = place.stat() if place.exists() else None
    return f"{place} {state.st_size} {state.st_mtime_ns}" if state else str(place)


@cache
def _processor_fingerprint() -> str:
    """What -march=native stands for here, so that a cache shared by machines stays right."""
    known = cpuinfo_value("flags") or cpuinfo_value("Features")
    return known or " ".join(platform.uname())


def compiled_c_library(name: str, source: str) -> ctypes.CDLL | None:
    """C source as a library, by the same cache; None where it cannot be compiled."""
    command = compiler()
    if command is None:
        return None
    sets = (*LOOPS, BRANCHES, WIDE), (*LOOPS, BRANCHES), LOOPS
    known = (flags for flags in sets if _compiler_accepts_flags(command, flags))
    flags = (*FLAGS, *next(known, ()))
    try:
        return _load_or_build_library(name, source, command, flags, ctypes.CDLL)
    except (OSError, subprocess.SubprocessError) as error:
        _LOG.debug("brushgrip: %s is not compiled (%s)", name, error)
        return None


def _load_or_build_library(
    name: str, source: str, command: str, flags: tuple[str, ...], load: Callable[[str], Loaded]
) -> Loaded:
    """Load a library of the cache; build it first where the cache has none that loads."""
    text = "\0".join(
        (source, command, _compiler_fingerprint(command), _processor_fingerprint(), *flags)
    ).encode()
    folder, stem = private_cache(), f"{name}_{_digest(text)}"
    for library in folder.glob(f"{stem}_*{LIBRARY_SUFFIX}"):
        if _is_intact_and_private(library):
            try:
                return load(str(library))
            except (RuntimeError, OSError):
                pass  # Of another machine with the same processor, say.
        library.unlink(missing_ok=True)
    try:
        library = _build_library(source, command, flags, folder / stem)
    except OSError as error:
        if error.errno not in UNWRITABLE:
            raise
        own = replacement_cache(folder, f"cannot be written ({error.strerror})")
        library = _build_library(source, command, flags, own / stem)
    try:
        return load(str(library))
    except (RuntimeError, OSError) as error:
        library.unlink(missing_ok=True)
        raise OSError(f"what {command} makes cannot be loaded") from error


def _build_library(source: str, command: str, flags: tuple[str, ...], stem: Path) -> Path:
    """Build a library, which appears in the cache whole or not at all."""
    with temporary_folder(stem.parent) as folder:
        (folder / "function.c").write_text(source, "utf-8")
        built = folder / f"function{LIBRARY_SUFFIX}"
        run_compiler(compiler_command(command, ["function.c"], built.name, flags), folder)
        built.chmod(0o700)
        with built.open("rb+") as content:
            digest = _digest(stem.name.encode() + content.read())
            os.fsync(content.fileno())
        final = stem.with_name(f"{stem.name}_{digest}{LIBRARY_SUFFIX}")
        try:
            return built.replace(final)
        except PermissionError:
            # On Windows nobody replaces what another process has loaded; it is the same.
            if not _is_intact_and_private(final):
                raise
            return final


def _is_intact_and_private(library: Path) -> bool:
    """Whether a library of the cache is this user's alone, and what was built for its name."""
    stem, _, digest = library.stem.rpartition("_")
    try:
        if reason_for_distrust(library) is not None:
            return False
        return digest == _digest(stem.encode() + library.read_bytes())
    except OSError:
        return False


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:24]
