"""The folder of compiled Functions: this user's alone, or another one for this process."""

import atexit
import logging
import os
import re
import shutil
import stat
import tempfile
from pathlib import Path

from symbolic.compilation.operating_system import LIBRARY_SUFFIX, user_id
from symbolic.compilation.self_cleaning_folder import create_locked_folder

_LOG = logging.getLogger(__name__)
LIBRARY = re.compile(r"\w+_[0-9a-f]{24}_[0-9a-f]{24}" + re.escape(LIBRARY_SUFFIX))
"""Names of libraries of the cache: Function, digest of what was compiled, digest of the content."""


def cache_directory() -> Path:
    """Folder of the compiled Functions: `BRUSHGRIP_CACHE`, else the user's cache folder."""
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
        return replacement_cache(folder, f"cannot be written ({error.strerror})")
    # Without links, whose targets might change later.
    folder = folder.resolve()
    _revoke_group_write(folder)
    if (reason := reason_for_distrust(folder) or _reason_to_distrust_parents(folder)) is None:
        return folder
    return replacement_cache(folder, f"{reason}, and compiled code in it would be run unseen")


def replacement_cache(folder: Path, reason: str) -> Path:
    """An empty cache for this process and its children; a warning says why."""
    own, _ = create_locked_folder(Path(tempfile.gettempdir()))
    atexit.register(_remove_if_in_process, os.getpid(), str(own))
    os.environ["BRUSHGRIP_CACHE"] = str(own)
    _LOG.warning(
        "brushgrip: %s %s; what is compiled now is not kept. Remove that folder, or name one of your own"
        " in BRUSHGRIP_CACHE", folder, reason,
    )  # fmt: skip
    return own


def _revoke_group_write(folder: Path) -> None:
    """Remove the group's write permission from our folder, and libraries that it could have replaced.

    An earlier release made the folder so where the umask is 002, as it is where every user has a group.
    """
    if (owner := user_id()) is None:
        return
    status = folder.stat()
    if status.st_uid != owner or status.st_mode & 0o022 != 0o020:
        return
    folder.chmod(stat.S_IMODE(status.st_mode) & ~0o020)
    for library in folder.glob(f"*{LIBRARY_SUFFIX}"):
        if LIBRARY.fullmatch(library.name):
            library.unlink(missing_ok=True)


def _reason_to_distrust_parents(folder: Path) -> str | None:
    """Reason why other users could replace this folder through a parent of it; None if they cannot.

    Where the sticky bit is set, as for /tmp, nobody can rename a folder of another user. A folder in the
    temporary folder is taken as it is, as its replacement would stand there too.
    """
    if user_id() is None or folder.parent == Path(tempfile.gettempdir()).resolve():
        return None
    for parent in folder.parents:
        mode = parent.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"lies in {parent}, where other users may replace it"
    return None


def reason_for_distrust(path: Path) -> str | None:
    """Why others could have changed what is at a path; None where they could not, or nobody can tell."""
    if (owner := user_id()) is None:
        return None
    status = path.lstat()
    if status.st_uid != owner:
        return "belongs to another user"
    return "may be written by other users" if status.st_mode & 0o022 else None


def _remove_if_in_process(process: int, folder: str) -> None:
    """Remove a folder when the process that made it ends, and not when a fork of it does."""
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)
