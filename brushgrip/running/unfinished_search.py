"""Trials of an unfinished search, kept until the same command finishes it."""

import hashlib
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from brushgrip.outputs.console import warn
from identification import Journal
from symbolic.compilation.cache_folder import cache_directory


@contextmanager
def trial_journal(out: Path) -> Iterator[Journal | None]:
    """A journal, which stays where the search is not done; None where no folder can be written."""
    folder = _first_writable_folder(out.resolve())
    if folder is None:
        warn("what is found cannot be kept, no folder can be written; interrupted, all begins anew")
        yield None
        return
    if kept := sum(1 for _ in folder.glob("*.npz")):
        warn(f"going on: an interrupted search left {kept} of its trials in {folder}")
    try:
        yield Journal(folder=folder)
    except BaseException:
        with suppress(OSError):
            folder.rmdir()  # Nothing was found yet.
        if folder.is_dir():
            warn(f"not finished; what was found so far is kept in {folder}, the same command goes on")
        raise
    shutil.rmtree(folder, ignore_errors=True)


def _first_writable_folder(final: Path) -> Path | None:
    """The first folder that can be written: beside the results, in them, in the user's cache."""
    beside = next((parent for parent in final.parents if parent.is_dir()), final)
    name = hashlib.sha256(bytes(final)).hexdigest()[:16]
    places = [beside / f".{final.name}.unfinished", cache_directory() / "unfinished" / name]
    if final.is_dir():
        places.insert(1, final / ".unfinished")
    for place in places:
        try:
            place.mkdir(parents=place is places[-1], exist_ok=True)
            (place / "try.part").touch()
            (place / "try.part").unlink()
        except OSError:
            continue
        return place
    return None
