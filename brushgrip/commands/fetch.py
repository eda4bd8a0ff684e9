"""`brushgrip fetch`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

import brushgrip.fetch
from brushgrip.console import say
from brushgrip.friction_damper import damper_folder, fetch_friction_damper
from brushgrip.recordings import download_folder


class Published(StrEnum):
    """Sets of recordings that can be fetched."""

    WHEEL = "wheel"
    FRICTION_DAMPER = "friction-damper"


def fetch(
    which: Annotated[
        Published,
        typer.Argument(
            metavar="[wheel|friction-damper]",
            help="The thesis's wheel, or another rig's friction damper with backlash (CC BY-SA 4.0).",
        ),
    ] = Published.WHEEL,
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
    if which is Published.FRICTION_DAMPER:
        folder = out or damper_folder()
        files = fetch_friction_damper(folder, say=say)
    else:
        folder = out or download_folder()
        files = brushgrip.fetch.fetch(folder, say=say)
    say(f"{len(files)} file{'s' * (len(files) != 1)} in {folder}")
