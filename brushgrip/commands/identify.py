"""`brushgrip identify`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.commands.options import ChannelMap, OutJson, RigFile, usable_file


def identify(
    free_decay: Annotated[
        list[str],
        typer.Option(
            "--free-decay",
            metavar="REC...",
            help="Recordings of the wheel swinging freely after an impact: one or more after the flag.",
            show_default=False,
        ),
    ],
    out: OutJson,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
    write_rig: Annotated[
        Path | None,
        typer.Option(
            "--write-rig",
            metavar="R",
            help="Rig file to write: that of --rig with the k and b_t found.",
            show_default=False,
            callback=usable_file,
        ),
    ] = None,
) -> None:
    """Identify k and b_t from free vibrations, with standard deviations.

    A recording needs t and psi alone; lines such as '# a = 0.045' before the header override the rig
    for that recording. a, e and J_A are required. A picture of the fit goes beside ID.json.
    """
    from brushgrip.tasks import identify as task

    task.identify(
        free_decay=free_decay,
        out=out,
        rig=rig,
        channel_map=channel_map,
        write_rig=write_rig,
    )
