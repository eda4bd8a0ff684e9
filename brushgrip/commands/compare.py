"""`brushgrip compare`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    ModelFile,
    OutJson,
    RecordingNames,
    RigFile,
    usable_file,
)

AuthorFolder = Annotated[
    Path | None,
    typer.Option(
        "--author",
        metavar="DIR",
        help="Folder of author_estimate_*.csv; that of each recording if left out.",
        show_default=False,
    ),
]
Declared = Annotated[
    list[float] | None,
    typer.Option(
        "--declared",
        metavar="MU...",
        help="Friction that errors refer to: one for all recordings, or one each.",
        show_default=False,
    ),
]
TrainingNames = Annotated[
    list[str] | None,
    typer.Option(
        "--train",
        metavar="REC...",
        help="Recordings with a known mu on which the two networks of [Györök 2022] are trained; the"
        " table then has them, and the mean of their labels. Needs scikit-learn.",
        show_default=False,
    ),
]
TableFile = Annotated[
    Path | None,
    typer.Option(
        "--table",
        metavar="TABLE.md",
        help="Tables in Markdown as well.",
        show_default=False,
        callback=usable_file,
    ),
]
PictureFile = Annotated[
    Path | None,
    typer.Option(
        "--picture", metavar="PNG", help="Box charts as well.", show_default=False, callback=usable_file
    ),
]


def compare(
    recordings: RecordingNames,
    out: OutJson,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    author: AuthorFolder = None,
    declared: Declared = None,
    train: TrainingNames = None,
    table: TableFile = None,
    picture: PictureFile = None,
) -> None:
    """Compare EKF and MHE with the root solve of [Györök 2022]: its Table 6.1, on any recordings.

    The table gives the RMSE of mu, its spread, and calculation time over measurement time on this
    machine; beside them the author's estimate, where there is a file of it, and the published figures.
    Without --declared, errors refer to mu of the author's file, of the published surface, or of the rig.
    """
    from brushgrip.tasks import compare as task

    task.compare(
        recordings=recordings,
        out=out,
        rig=rig,
        channel_map=channel_map,
        model=model,
        effects=effects,
        author=author,
        declared=declared,
        train=train,
        table=table,
        picture=picture,
    )
