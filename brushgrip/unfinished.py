"""What an unfinished search has done, kept until the same command finishes it."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from brushgrip.console import warn
from identification import Journal


@contextmanager
def kept_trials(out: Path) -> Iterator[Journal]:
    """A journal beside the folder of results; it goes when all is done, and stays after anything else.

    Args:
        out: the folder that the results will be in.
    """
    final = out.resolve()
    beside = next((parent for parent in final.parents if parent.is_dir()), final)
    folder = beside / f".{final.name}.unfinished"
    try:
        yield Journal(folder=folder)
    except BaseException:
        if folder.is_dir():
            warn(f"not finished; what was found so far is kept in {folder}, the same command goes on")
        raise
    shutil.rmtree(folder, ignore_errors=True)
