"""`brushgrip fetch`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.choices import Published


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
    from brushgrip.tasks import fetch as task

    task.fetch(
        which=which,
        out=out,
    )
