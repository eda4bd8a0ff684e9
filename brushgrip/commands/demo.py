"""`brushgrip demo`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.commands.options import Force, usable_folder


def demo(
    out: Annotated[
        Path,
        typer.Option("--out", metavar="DIR", help="Folder to write to.", callback=usable_folder),
    ] = Path("demo_output"),
    examples: Annotated[
        Path | None,
        typer.Option(
            "--examples",
            metavar="DIR",
            help="Write the scripts of the examples to this new folder, and do nothing else.",
            show_default=False,
            callback=usable_folder,
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Show the main job on embedded recordings: diagnosis, report and friction over time."""
    from brushgrip.tasks import demo as task

    task.demo(
        out=out,
        examples=examples,
        force=force,
    )
