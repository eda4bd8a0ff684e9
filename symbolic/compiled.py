"""Functions compiled to machine code through C, with a cache; interpreted where no compiler is found."""

import atexit
import errno
import hashlib
import logging
import os
import platform
import re
import shutil
import signal
import stat
import subprocess
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

import casadi as ca

from symbolic.errors import one_line
from symbolic.scratch import claimed_folder, scratch_folder

_LOG = logging.getLogger(__name__)
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

NO_PLACE = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT)
"""Why a library cannot be written where it should be."""
LIBRARY = re.compile(r"\w+_[0-9a-f]{24}_[0-9a-f]{24}\.so")
"""Names of libraries of the cache: Function, digest of what was compiled, digest of the content."""

_BLAMED: set[str] = set()
"""Compilers that failed; it is said once."""


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
            _blame(
                "",
                "no C compiler is found (CC, cc): models are interpreted, which is slow;"
                " BRUSHGRIP_INTERPRET=1 says that this is meant",
            )
        return function
    flags = (*FLAGS, *VECTORISED) if vectorised and _takes(command, VECTORISED) else FLAGS
    try:
        return _loaded(function, command, flags)
    except (OSError, subprocess.SubprocessError, RuntimeError) as error:
        reason = one_line(str(error).partition("\n")[0])
        _blame(command, f"models are not compiled ({reason}), and interpreted instead, which is slow")
        return function


def _blame(command: str, line: str) -> None:
    """Say it once for each compiler."""
    if command not in _BLAMED:
        _BLAMED.add(command)
        _LOG.warning("brushgrip: %s", line)


@cache
def _takes(command: str, flags: tuple[str, ...]) -> bool:
    """Whether the compiler takes these flags beside the usual ones, tried on a program of one line."""
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "try.c"
        source.write_text("int one(void) { return 1; }\n")
        try:
            _run([command, str(source), *FLAGS, *flags, "-o", str(source.with_suffix(".so"))])
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


def _loaded(function: ca.Function, command: str, flags: tuple[str, ...]) -> ca.Function:
    """The Function out of a library of the cache, which is built where there is none that loads."""
    generator = ca.CodeGenerator(f"{function.name()}.c")
    generator.add(function)
    source = generator.dump()
    text = "\0".join((source, command, _processor(), *flags)).encode()
    folder, stem = _private_cache(), f"{function.name()}_{_digest(text)}"
    for library in folder.glob(f"{stem}_*.so"):
        if _is_sound(library):
            try:
                return ca.external(function.name(), str(library))
            except RuntimeError:
                pass  # Of another machine with the same processor, say.
        library.unlink(missing_ok=True)
    try:
        library = _built(source, command, flags, folder / stem)
    except OSError as error:
        if error.errno not in NO_PLACE:
            raise
        own = _in_its_place(folder, f"cannot be written ({error.strerror})")
        library = _built(source, command, flags, own / stem)
    try:
        return ca.external(function.name(), str(library))
    except RuntimeError as error:
        library.unlink(missing_ok=True)
        raise OSError(f"what {command} makes cannot be loaded") from error


def _built(source: str, command: str, flags: tuple[str, ...], stem: Path) -> Path:
    """A new library, which is in the cache whole or not at all."""
    with scratch_folder(stem.parent) as scratch:
        c_file, built = scratch / "function.c", scratch / "function.so"
        c_file.write_text(source)
        _run([command, str(c_file), *flags, "-o", str(built), "-lm"])
        built.chmod(0o700)
        with built.open("rb+") as content:
            digest = _digest(stem.name.encode() + content.read())
            os.fsync(content.fileno())
        return built.replace(f"{stem}_{digest}.so")


def _run(line: list[str]) -> None:
    """Runs a compiler on the source that is named first; interrupted, nothing of it goes on."""
    environment = {**os.environ, "TMPDIR": str(Path(line[1]).parent)}
    silent = subprocess.DEVNULL
    # In a session of its own, so that what it starts has its group and ends with it.
    with subprocess.Popen(
        line, stdout=silent, stderr=silent, env=environment, start_new_session=True
    ) as running:
        try:
            status = running.wait(timeout=300)
        except BaseException:
            if hasattr(os, "killpg"):
                with suppress(ProcessLookupError):
                    os.killpg(running.pid, signal.SIGKILL)
            running.kill()
            running.wait()
            raise
    if status:
        raise subprocess.CalledProcessError(status, line[0])


def _is_sound(library: Path) -> bool:
    """Whether a library of the cache is this user's alone, and what was built for its name."""
    stem, _, digest = library.stem.rpartition("_")
    try:
        return _distrust(library) is None and digest == _digest(stem.encode() + library.read_bytes())
    except OSError:
        return False


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:24]


def _private_cache() -> Path:
    """The cache folder; where others may write to it, an empty one for this process and its children."""
    folder = cache_directory()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        return _in_its_place(folder, f"cannot be written ({error.strerror})")
    # From here on the folder is reached without a link, which might change its aim.
    folder = folder.resolve()
    _close_to_group(folder)
    if (reason := _distrust(folder) or _distrust_parents(folder)) is None:
        return folder
    return _in_its_place(folder, f"{reason}, and compiled code in it would be run unseen")


def _in_its_place(folder: Path, reason: str) -> Path:
    """A cache for this process and its children, empty, and a line that says so."""
    own, _ = claimed_folder(Path(tempfile.gettempdir()))
    atexit.register(_remove_as, os.getpid(), str(own))
    os.environ["BRUSHGRIP_CACHE"] = str(own)
    _LOG.warning(
        "brushgrip: %s %s; what is compiled now is not kept. Remove that folder, or name one of your own"
        " in BRUSHGRIP_CACHE",
        folder,
        reason,
    )
    return own


def _close_to_group(folder: Path) -> None:
    """Takes the group's right to write from an own folder, and the libraries that it may have renamed.

    An earlier release made the folder so where the umask is 002, as it is where every user has a group.
    """
    if not hasattr(os, "geteuid"):
        return
    status = folder.stat()
    if status.st_uid != os.geteuid() or status.st_mode & 0o022 != 0o020:
        return
    folder.chmod(stat.S_IMODE(status.st_mode) & ~0o020)
    for library in folder.glob("*.so"):
        if LIBRARY.fullmatch(library.name):
            library.unlink(missing_ok=True)


def _distrust_parents(folder: Path) -> str | None:
    """Why others could put another folder in the place of this one; None where they could not.

    Where the sticky bit is set, as for /tmp, nobody renames what is another user's. What stands in the
    temporary folder is not asked: nothing better could take its place.
    """
    if not hasattr(os, "geteuid") or folder.parent == Path(tempfile.gettempdir()).resolve():
        return None
    for parent in folder.parents:
        mode = parent.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"lies in {parent}, where other users may replace it"
    return None


def _distrust(path: Path) -> str | None:
    """Why others could have changed what is at a path; None where they could not, or nobody can tell."""
    if not hasattr(os, "geteuid"):
        return None
    status = path.lstat()
    if status.st_uid != os.geteuid():
        return "belongs to another user"
    return "may be written by other users" if status.st_mode & 0o022 else None


def _remove_as(process: int, folder: str) -> None:
    """Removes a folder at the end of the process that made it, not of a fork."""
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)
