"""`brushgrip codegen`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_directory
from brushgrip.commands.options import EffectModules, ModelFile, OutFolder, TuningProfile
from brushgrip.console import say
from brushgrip.recordings import keep_inputs
from brushgrip.user_effects import effect_files, user_effects
from identification import read_model
from observers import AligningTorque, Ekf, MeasurementModel, Mhe, SteeringTorque, from_files, profile
from observers.embedded import DOUBLE, SINGLE, generate, generate_fmu, require_replaceable


class Kind(StrEnum):
    """Observers that can be written out."""

    EKF = "ekf"
    MHE = "mhe"


class Type(StrEnum):
    """Types of number by their name in C."""

    FLOAT = "float"
    DOUBLE = "double"


class Target(StrEnum):
    """What is written."""

    C = "c"
    FMU = "fmu"


class TorqueChannel(StrEnum):
    """Which torque the target measures, by its name in recordings."""

    GROUND = "M_z"
    HAND = "M"


KINDS = {Kind.EKF: Ekf, Kind.MHE: Mhe}
TYPES = {Type.FLOAT: SINGLE, Type.DOUBLE: DOUBLE}
MEASUREMENT_MODELS: dict[TorqueChannel, MeasurementModel] = {
    TorqueChannel.GROUND: AligningTorque(),
    TorqueChannel.HAND: SteeringTorque(),
}


def codegen(
    rig: Annotated[
        Path, typer.Option("--rig", metavar="R", help="Rig file (TOML).", show_default=False)
    ],
    observer: Annotated[Kind, typer.Option("--observer", help="Observer to write.", show_default=False)],
    out: OutFolder,
    model: ModelFile = None,
    effects: EffectModules = None,
    tuning: TuningProfile = None,
    ground: Annotated[
        str | None,
        typer.Option(
            "--ground",
            metavar="NAME",
            help="Ground whose values are taken from the model file; the mean over its grounds without.",
            show_default=False,
        ),
    ] = None,
    real: Annotated[Type, typer.Option("--real", help="Type of every number.")] = Type.FLOAT,
    target: Annotated[Target, typer.Option("--target", help="What to write.")] = Target.C,
    torque: Annotated[
        TorqueChannel, typer.Option("--torque", help="Torque measured: aligning, or steering.")
    ] = TorqueChannel.GROUND,
    name: Annotated[
        str, typer.Option("--name", metavar="NAME", help="Begins every name in C.")
    ] = "brushgrip",
) -> None:
    """Write an observer as C99 for an embedded target, or as an FMU: no heap, one type of number.

    NAME.h and NAME.c are all that the target needs. main.c is an example that reads a recording; check.c
    holds a build against NAME_vector.csv, what Python made of 400 samples; NAME.json says what
    parameters it was made with; NAME_sfun.c is an S-function for Simulink. With --target fmu, NAME.fmu
    holds the same C with sources and a library for 64-bit Linux: FMI 2.0 co-simulation, a communication
    step is a sample.

    Files that an earlier codegen wrote are replaced; any other file in the way is a fault.
    """
    own = user_effects(effects)
    chosen = from_files(
        KINDS[observer],
        rig,
        model,
        effects=own,
        ground=ground,
        measurement_model=MEASUREMENT_MODELS[torque],
        tuning=None if tuning is None else profile(tuning),
    )
    with staged_directory(out) as stage:
        if target is Target.FMU:
            files = [generate_fmu(chosen, stage, TYPES[real], name=name)]
        else:
            files = generate(chosen, stage, TYPES[real], name=name)
        finals = [out.resolve() / path.name for path in files]
        keep_inputs(finals, [], rig, model, *effect_files(effects))
        require_replaceable(finals)
    if model is not None and (taken := read_model(model, effects=own).ground_taken(ground)):
        say(taken)
    say(f"wrote {', '.join(path.name for path in files)} to {out}")
