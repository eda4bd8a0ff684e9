"""`brushgrip demo`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.commands.options import usable_folder


def demo(
    out: Annotated[
        Path,
        typer.Option("--out", metavar="DIR", help="Folder to write to.", callback=usable_folder),
    ] = Path("demo_output"),
) -> None:
    """Show the main job on embedded recordings: diagnosis, report and friction over time."""
    from brushgrip.tasks import demo as task

    task.demo(
        out=out,
    )
