"""Arguments and options that several commands share, and checks of the files they name."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.choices import TuningName

MOST_JOBS = 256


def usable_file(path: Path | None) -> Path | None:
    """The name of a file to write, as it was given; None for none.

    Raises:
        InvalidInputError: it is empty or names a folder by its place, as `.` and `/` do.
    """
    if path is not None and path.name in ("", ".."):
        from symbolic import InvalidInputError

        raise InvalidInputError(f"{str(path)!r} names no file to write; give one such as out.csv")
    return path


def usable_folder(path: Path | None) -> Path | None:
    """The name of a folder to write to, as it was given; None for none.

    Raises:
        InvalidInputError: it is a loop of links, or too long.
    """
    try:
        if path is not None:
            path.resolve().exists()
    except (OSError, RuntimeError) as error:  # The latter is what Python 3.11 says of a loop.
        from symbolic import InvalidInputError

        reason = getattr(error, "strerror", None) or error
        raise InvalidInputError(f"{path}: cannot be written: {reason}") from None
    return path


def model_file(path: Path | None) -> Path | None:
    """The name of a model file: of a folder of a diagnosis, that in it.

    Raises:
        InvalidInputError: the folder holds none.
    """
    from symbolic import InvalidInputError

    try:
        if path is None or not path.is_dir():
            return path
        if (path / "model.json").is_file():
            return path / "model.json"
    except (OSError, ValueError):
        return path
    raise InvalidInputError(f"{path}: holds no model.json, so it is not the folder of a diagnosis")


RecordingNames = Annotated[
    list[str],
    typer.Argument(
        metavar="REC...",
        help="Recordings: files (.csv, .mat, .mf4, .tdms, .parquet, .h5, .blf and more), or names of"
        " published ones, such as fem1.",
        show_default=False,
    ),
]
RigFile = Annotated[
    Path | None,
    typer.Option(
        "--rig",
        metavar="R",
        help="Rig file (TOML). May be left out where the recordings know a, e and k.",
        show_default=False,
    ),
]
ChannelMap = Annotated[
    str | None,
    typer.Option(
        "--map",
        metavar="psi=NAME:deg,...",
        help="Channels of the columns with their units and factors, such as"
        " psi=SteeringAngle:deg,t=time:ms,M_z=-Mz,F_N=0.5*Load:kN; goes before [signals] of the rig"
        " file.",
        show_default=False,
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace what another run wrote into the folder.")]
ModelFile = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="MODEL",
        help="Folder of a diagnosis, or its model file (model.json); the declared model without it.",
        show_default=False,
        callback=model_file,
    ),
]


TuningProfile = Annotated[
    TuningName | None,
    typer.Option(
        "--tuning",
        help="Tuning by name; real_tyre if left out. A model file's model_error goes before its error,"
        " noise, error_travel and explained; what --tune sets goes before both.",
        show_default=False,
    ),
]
EffectModules = Annotated[
    list[str] | None,
    typer.Option(
        "--effects",
        metavar="MODULE",
        help="Module with effects of your own, EFFECTS = [MyEffect(), ...]; it is imported. May be"
        " repeated; several may be separated by commas.",
        show_default=False,
    ),
]
Grounds = Annotated[
    list[str] | None,
    typer.Option(
        "--ground",
        metavar="NAME=REC,REC",
        help="What recordings stand on, such as steel=fem1,fem3; goes before '# ground = steel' in a CSV"
        " file. May be repeated.",
        show_default=False,
    ),
]
OneGround = Annotated[
    list[str] | None,
    typer.Option(
        "--ground",
        metavar="NAME",
        help="What the wheel stands on, or NAME=REC,REC for some of the recordings; picks the values of"
        " that ground from the model file.",
        show_default=False,
    ),
]
OutFile = Annotated[
    Path,
    typer.Option(
        "--out", metavar="OUT.csv", help="File to write.", show_default=False, callback=usable_file
    ),
]
OutJson = Annotated[
    Path,
    typer.Option(
        "--out", metavar="OUT.json", help="File to write.", show_default=False, callback=usable_file
    ),
]
OutFolder = Annotated[
    Path,
    typer.Option(
        "--out", metavar="DIR", help="Folder to write to.", show_default=False, callback=usable_folder
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        "--jobs", metavar="N", min=1, max=MOST_JOBS, help="Processes to use; one per core if left out.",
        show_default=False,
    ),
]  # fmt: skip
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Scheduler of a Dask cluster that does the work in place of processes here, such as"
        " tcp://10.0.0.1:8786.",
        show_default=False,
    ),
]
TuningValues = Annotated[
    list[str] | None,
    typer.Option(
        "--tune",
        metavar="NAME=VALUE",
        help="A value of the tuning in place of the profile's, such as mu_walk=0.02. May be repeated;"
        " several may be separated by commas.",
        show_default=False,
    ),
]
