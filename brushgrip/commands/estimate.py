"""`brushgrip estimate`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.choices import ObserverName
from brushgrip.commands.options import (
    EffectModules,
    ModelFile,
    OneGround,
    OutFile,
    RecordingName,
    RigFile,
    TuningProfile,
    usable_file,
)


def estimate(
    recording: RecordingName,
    observer: Annotated[
        ObserverName, typer.Option("--observer", help="Observer to use.", show_default=False)
    ],
    out: OutFile,
    rig: RigFile = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    tuning: TuningProfile = None,
    ground: OneGround = None,
    smooth: Annotated[
        bool,
        typer.Option("--smooth", help="Estimate every sample from the whole recording; takes ekf."),
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture",
            metavar="PNG",
            help="Picture of mu(t); OUT.png if left out.",
            show_default=False,
            callback=usable_file,
        ),
    ] = None,
) -> None:
    """Estimate friction over time, causally, one row a sample.

    Columns t,mu,mu_std,M_z_predicted,informed,mu_eff,mu_eff_std,M_slide,nis,status. The effective
    friction mu_eff compares between models: the torque M_slide [N m] of a steady full slide over that of
    the declared patch with mu = 1; nis is the square of measured minus predicted over its variance.

    From the aligning torque M_z, or, where the recording has none, from the steering torque M; that
    takes J_A and b_t of the rig. informed is 0 or 1, status a number; deviations and nis are empty with
    root, the method of [Györök 2022], which has none. A picture of mu_eff(t) goes beside OUT.csv.
    With --smooth an estimate knows later samples too, for those who work offline.
    """
    from brushgrip.tasks import estimate as task

    task.estimate(
        recording=recording,
        observer=observer,
        out=out,
        rig=rig,
        model=model,
        effects=effects,
        tuning=tuning,
        ground=ground,
        smooth=smooth,
        picture=picture,
    )
