"""`brushgrip fetch`."""

from pathlib import Path

import brushgrip.fetch
from brushgrip.choices import Published
from brushgrip.console import say, show
from brushgrip.friction_damper import damper_folder, fetch_friction_damper
from brushgrip.recordings import download_folder


def fetch(
    *,
    which: Published,
    out: Path | None,
) -> None:
    """Bring the published measurements to where recordings are looked for.

    Its arguments are those of the command; see `brushgrip fetch --help`.
    """
    if which is Published.FRICTION_DAMPER:
        folder = out or damper_folder()
        files = fetch_friction_damper(folder, say=say)
    else:
        folder = out or download_folder()
        files = brushgrip.fetch.fetch(folder, say=say)
    show({"folder": str(folder), "files": [str(path) for path in files]})
    say(f"{len(files)} file{'s' * (len(files) != 1)} in {folder}")
