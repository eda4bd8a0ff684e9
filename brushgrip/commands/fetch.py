"""`brushgrip fetch`."""

from pathlib import Path
from typing import Annotated

import typer

import brushgrip.fetch
from brushgrip.console import say
from brushgrip.recordings import download_folder


def fetch(
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Folder to put them in; the user's data folder if left out.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Download the published measurements at the pinned commit, every digest checked.

    Where BRUSHGRIP_DATA names a folder, they are copied from there and nothing is downloaded.
    """
    folder = out or download_folder()
    files = brushgrip.fetch.fetch(folder, say=say)
    say(f"{len(files)} file{'s' * (len(files) != 1)} in {folder}")
