"""Arguments and options that several commands share, and checks of the files they name."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from symbolic import InvalidInputError

RecordingName = Annotated[
    str,
    typer.Argument(
        metavar="REC",
        help="Recording: a .csv or .mat file, or the name of a published one, such as fem1.",
        show_default=False,
    ),
]
RecordingNames = Annotated[
    list[str],
    typer.Argument(
        metavar="REC...",
        help="Recordings: .csv or .mat files, or names of published ones, such as fem1.",
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
ModelFile = Annotated[
    Path | None,
    typer.Option(
        "--model",
        metavar="MODEL",
        help="Model file of a diagnosis (model.json); the declared model without it.",
        show_default=False,
    ),
]


class TuningName(StrEnum):
    """Tunings by the name that a user gives."""

    REAL_TYRE = "real_tyre"
    CLEAN = "clean"
    CHANGING_GROUND = "changing_ground"


TuningProfile = Annotated[
    TuningName | None,
    typer.Option(
        "--tuning",
        help="Tuning by name; real_tyre if left out. A model file's model_error goes before its error.",
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
OutFile = Annotated[
    Path, typer.Option("--out", metavar="OUT.csv", help="File to write.", show_default=False)
]
OutJson = Annotated[
    Path, typer.Option("--out", metavar="OUT.json", help="File to write.", show_default=False)
]
OutFolder = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="Folder to write to.", show_default=False)
]
Jobs = Annotated[
    int | None,
    typer.Option(
        "--jobs", metavar="N", min=1, help="Processes to use; one per core if left out.",
        show_default=False,
    ),
]  # fmt: skip


def check_picture_name(picture: Path) -> None:
    """Refuses a picture that is no PNG.

    Raises:
        InvalidInputError: the name has another suffix.
    """
    if picture.suffix.lower() != ".png":
        raise InvalidInputError(f"{picture}: the picture needs a name that ends in .png")
