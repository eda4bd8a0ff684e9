"""`brushgrip codegen`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.choices import GeneratedObserver, RealType, RunTime, Target, TorqueChannel
from brushgrip.commands.options import EffectModules, ModelFile, OutFolder, TuningProfile, TuningValues

Ground = Annotated[
    str | None,
    typer.Option(
        "--ground",
        metavar="NAME",
        help="Ground whose values are taken from the model file; the mean over its grounds without.",
        show_default=False,
    ),
]
Window = Annotated[
    int | None,
    typer.Option(
        "--window",
        metavar="N",
        help="Samples that the MHE fits at once; 50 if left out.",
        show_default=False,
    ),
]


Tunable = Annotated[
    RunTime | None,
    typer.Option(
        "--tunable",
        help="Parameters that the code takes at run time: the tuning, or all: model, rig and tuning.",
        show_default=False,
    ),
]


def codegen(
    rig: Annotated[
        Path, typer.Option("--rig", metavar="R", help="Rig file (TOML).", show_default=False)
    ],
    observer: Annotated[
        GeneratedObserver, typer.Option("--observer", help="Observer to write.", show_default=False)
    ],
    out: OutFolder,
    model: ModelFile = None,
    effects: EffectModules = None,
    tuning: TuningProfile = None,
    tune: TuningValues = None,
    window: Window = None,
    ground: Ground = None,
    real: Annotated[RealType, typer.Option("--real", help="Type of every number.")] = RealType.FLOAT,
    target: Annotated[Target, typer.Option("--target", help="What to write.")] = Target.C,
    torque: Annotated[
        TorqueChannel, typer.Option("--torque", help="Torque measured: aligning, or steering.")
    ] = TorqueChannel.GROUND,
    tunable: Tunable = None,
    name: Annotated[
        str, typer.Option("--name", metavar="NAME", help="Begins every name in C.")
    ] = "brushgrip",
) -> None:
    """Write an observer as C99 for an embedded target, or as an FMU: no heap, one type of number.

    NAME.h and NAME.c are all that the target needs, NAME.hpp is a class of C++17 around them. main.c is
    an example that reads a recording; check.c holds a build against NAME_vector.csv, what Python made of
    400 samples; NAME.json says what parameters it was made with; NAME_sfun.c is an S-function for
    Simulink. With --target fmu, NAME.fmu holds the same C with sources and a library for 64-bit Linux:
    co-simulation by FMI 2.0 (fmu3: 3.0), a communication step is a sample. With --target ros2 it is a
    package with a node.

    With --tunable tuning the code takes prior, noises and limits at run time, with all also model and
    rig: NAME_set_parameters in C, described by NAME.a2l for calibration tools, and tunable parameters
    of an FMU.

    The prior is that of the tuning (--tune mu=0.8,mu_std=0.2), not the mu of the rig file. Before
    anything is written, a line says what a step will cost.

    Files that an earlier codegen wrote are replaced; any other file in the way is a fault.
    """
    from brushgrip.tasks import codegen as task

    task.codegen(
        rig=rig,
        observer=observer,
        out=out,
        model=model,
        effects=effects,
        tuning=tuning,
        tune=tune,
        window=window,
        ground=ground,
        real=real,
        target=target,
        torque=torque,
        tunable=tunable,
        name=name,
    )
