"""`brushgrip simulate`."""

from typing import Annotated

import typer

from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    ModelFile,
    OneGround,
    OutFile,
    RecordingNames,
    RigFile,
)


def simulate(
    recordings: RecordingNames,
    out: OutFile,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    ground: OneGround = None,
    mu: Annotated[
        float | None,
        typer.Option(
            "--mu",
            metavar="MU",
            help="Friction coefficient, in place of what model file, recording and rig say.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Simulate the aligning torque for the angle and the load of recordings: t,M_z.

    No M_z is needed. mu is that of --mu, else of the model file where it knows the recording, else of
    the rig.
    Several recordings go to OUT_<recording>.csv.
    """
    from brushgrip.tasks import simulate as task

    task.simulate(
        recordings=recordings,
        out=out,
        rig=rig,
        channel_map=channel_map,
        model=model,
        effects=effects,
        ground=ground,
        mu=mu,
    )
