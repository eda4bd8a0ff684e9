"""The folder of compiled Functions: this user's alone, or another one for this process."""

import atexit
import logging
import os
import re
import shutil
import stat
import tempfile
from pathlib import Path

from symbolic.compilation.temporary_folder import claim_folder

_LOG = logging.getLogger(__name__)
LIBRARY = re.compile(r"\w+_[0-9a-f]{24}_[0-9a-f]{24}\.so")
"""Names of libraries of the cache: Function, digest of what was compiled, digest of the content."""


def cache_directory() -> Path:
    """Where compiled Functions are kept: `BRUSHGRIP_CACHE`, else the user's cache folder."""
    if own := os.environ.get("BRUSHGRIP_CACHE"):
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brushgrip"


def private_cache() -> Path:
    """The cache folder; where others may write to it, an empty one for this process and its children."""
    folder = cache_directory()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        return place_of_its_own(folder, f"cannot be written ({error.strerror})")
    # From here on the folder is reached without a link, which might change its aim.
    folder = folder.resolve()
    _close_to_group(folder)
    if (reason := distrust(folder) or _distrust_parents(folder)) is None:
        return folder
    return place_of_its_own(folder, f"{reason}, and compiled code in it would be run unseen")


def place_of_its_own(folder: Path, reason: str) -> Path:
    """A cache for this process and its children, empty, and a line that says so."""
    own, _ = claim_folder(Path(tempfile.gettempdir()))
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


def distrust(path: Path) -> str | None:
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
