"""`brushgrip estimate`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.choices import ObserverName
from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    Jobs,
    ModelFile,
    OneGround,
    RecordingNames,
    RigFile,
    Scheduler,
    TuningProfile,
    TuningValues,
    usable_file,
)

OptionalOutFile = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="OUT.csv", help="File to write.", show_default=False, callback=usable_file
    ),
]
SummaryFile = Annotated[
    Path | None,
    typer.Option(
        "--summary",
        metavar="TABLE.csv",
        help="Table to write with a row for each recording.",
        show_default=False,
        callback=usable_file,
    ),
]

Observer = Annotated[
    ObserverName, typer.Option("--observer", help="Observer to use.", show_default=False)
]
Smooth = Annotated[
    bool, typer.Option("--smooth", help="Estimate every sample from the whole recording; takes ekf.")
]
FrictionPicture = Annotated[
    Path | None,
    typer.Option(
        "--picture",
        metavar="PNG",
        help="Picture of mu(t); OUT.png if left out.",
        show_default=False,
        callback=usable_file,
    ),
]


def estimate(
    recordings: RecordingNames,
    observer: Observer,
    out: OptionalOutFile = None,
    summary: SummaryFile = None,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    tuning: TuningProfile = None,
    tune: TuningValues = None,
    ground: OneGround = None,
    smooth: Smooth = False,
    picture: FrictionPicture = None,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """Estimate friction over time, causally, one row a sample.

    Columns t,mu,mu_std,M_z_predicted,informed,usable,mu_eff,mu_eff_std,M_slide,nis,status. The effective
    friction mu_eff compares between models: the torque M_slide [N m] of a steady full slide over that of
    the declared patch with mu = 1; nis is the square of measured minus predicted over its variance.

    From the aligning torque M_z, or, where the recording has none, from the steering torque M; that
    takes J_A and b_t of the rig. informed and usable are 0 or 1, status a
    number; act on friction where usable is 1; deviations and nis are empty with
    root, the method of [Györök 2022], which has none. A picture of mu_eff(t) goes beside OUT.csv.
    With --smooth an estimate knows later samples too, for those who work offline.

    Several recordings go to OUT_<recording>.csv, without pictures, and friction at the end of each to a
    row of --summary, which suffices for itself. What is wrong with a recording stands in its row; the
    others are estimated all the same, and the exit status is 2.
    """
    from brushgrip.tasks import estimate as task

    task.estimate(
        recordings=recordings,
        observer=observer,
        out=out,
        summary=summary,
        rig=rig,
        channel_map=channel_map,
        model=model,
        effects=effects,
        tuning=tuning,
        tune=tune,
        ground=ground,
        smooth=smooth,
        picture=picture,
        jobs=jobs,
        scheduler=scheduler,
    )
