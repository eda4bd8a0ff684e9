"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

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
OutFile = Annotated[
    Path, typer.Option("--out", metavar="OUT.csv", help="File to write.", show_default=False)
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
