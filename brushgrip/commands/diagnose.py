"""`brushgrip diagnose`."""

from typing import Annotated

import typer

from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    Force,
    Grounds,
    Jobs,
    OutFolder,
    RecordingNames,
    RigFile,
    Scheduler,
)


def diagnose(
    recordings: RecordingNames,
    out: OutFolder,
    holdout: Annotated[
        list[str] | None,
        typer.Option(
            "--holdout",
            metavar="REC...",
            help="Recordings held out to judge the models: one or more names after the flag.",
            show_default=False,
        ),
    ] = None,
    robust: Annotated[
        float | None,
        typer.Option(
            "--robust",
            metavar="SHARE",
            help="Threshold of Huber's loss, as a share of the torque range, for a torque with outliers:"
            " 1.5 times its noise.",
            show_default=False,
        ),
    ] = None,
    effects: EffectModules = None,
    ground: Grounds = None,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    force: Force = False,
) -> None:
    """Find what the declared model lacks; write diagnosis.json, model.json and report.html.

    An interrupted search is kept; the same command continues it.
    """
    from brushgrip.tasks import diagnose as task

    task.diagnose(
        recordings=recordings,
        out=out,
        holdout=holdout,
        robust=robust,
        effects=effects,
        ground=ground,
        rig=rig,
        channel_map=channel_map,
        jobs=jobs,
        scheduler=scheduler,
        force=force,
    )
