"""`brushgrip compare`."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import ModelFile, RecordingNames, RigFile
from brushgrip.comparison.cases import Subject, subject_of
from brushgrip.comparison.methods import Method, methods
from brushgrip.comparison.networks import corrected_root, neural_network
from brushgrip.comparison.scores import compare as compare_methods
from brushgrip.comparison.scores import rows
from brushgrip.comparison.tables import comparison_dict, markdown_text, print_comparison
from brushgrip.console import progress, say
from brushgrip.pictures import draw_boxes
from brushgrip.recordings import keep_inputs, locate, read_all
from brushgrip.tables import json_text
from identification.modelfile import read_model
from identification.thesis.author_estimate import author_file
from identification.thesis.friction_network import label_mean
from symbolic import InvalidInputError

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
        help="Friction to take the error from: one for all recordings, or one each.",
        show_default=False,
    ),
]
Lessons = Annotated[
    list[str] | None,
    typer.Option(
        "--train",
        metavar="REC...",
        help="Recordings with a known mu to train the source's two networks on; they stand in the"
        " table then, beside the mean of their labels. Needs scikit-learn.",
        show_default=False,
    ),
]
TableFile = Annotated[
    Path | None,
    typer.Option("--table", metavar="TABLE.md", help="Tables in Markdown as well.", show_default=False),
]
PictureFile = Annotated[
    Path | None,
    typer.Option("--picture", metavar="PNG", help="Box charts as well.", show_default=False),
]
OutJson = Annotated[
    Path, typer.Option("--out", metavar="OUT.json", help="File to write.", show_default=False)
]


def compare(
    recordings: RecordingNames,
    out: OutJson,
    rig: RigFile = None,
    model: ModelFile = None,
    author: AuthorFolder = None,
    declared: Declared = None,
    train: Lessons = None,
    table: TableFile = None,
    picture: PictureFile = None,
) -> None:
    """Set EKF and MHE beside the source's root solve: its Table 6.1, on any recordings.

    RMSE of mu, its spread, and calculation time over measurement time, here and now; beside them the
    author's own estimate where his file is there, and his published figures. Without --declared the
    error is taken from mu of the author's file, of the published surface, or of the rig.
    """
    finals = [path for path in (out, table, picture) if path is not None]
    _check_names(finals, picture)
    subjects = _subjects(recordings, rig, author, declared or [])
    read_names = [*recordings, *(train or [])]
    keep_inputs(finals, read_names, rig, model, *_author_files(read_names, author))
    chosen = methods(None if model is None else read_model(model))
    if train:
        read_all([*recordings, *train], rig)
        chosen += _networks(_subjects(train, rig, author, ()))
    with ExitStack() as stack:
        stages = {final: stack.enter_context(staged_file(final)) for final in finals}
        with progress() as report:
            compared = compare_methods(subjects, chosen, report)
        made = rows(compared, chosen)
        text = json_text(comparison_dict(compared, made))
        stages[out].write_text(text, encoding="utf-8", newline="\n")
        if table is not None:
            stages[table].write_text(markdown_text(compared, made), encoding="utf-8", newline="\n")
        if picture is not None:
            draw_boxes(stages[picture], compared, [row.method for row in made])
    print_comparison(compared, made)
    say(f"wrote {', '.join(map(str, finals))}")


def _subjects(
    names: Sequence[str], rig: Path | None, author: Path | None, declared: Sequence[float]
) -> list[Subject]:
    if len(declared) not in (0, 1, len(names)):
        raise InvalidInputError(
            f"--declared has {len(declared)} values for {len(names)} recordings;"
            " give one for all, or one for each"
        )
    for mu in declared:
        if not 0 < mu < float("inf"):
            raise InvalidInputError(f"--declared must be finite and greater than 0, got {mu:g}")
    if author is not None and not author.is_dir():
        raise InvalidInputError(
            f"{author}: no such folder; --author takes that of author_estimate_*.csv"
        )
    read = read_all(names, rig, causal=True)
    references = [*declared, *[declared[0] if declared else None] * (len(read) - len(declared))]
    return [
        subject_of(recording, locate(name).parent if author is None else author, mu)
        for recording, name, mu in zip(read, names, references, strict=True)
    ]


def _author_files(names: Sequence[str], author: Path | None) -> list[Path]:
    """The author's estimates that may be read along with these recordings."""
    folders = {locate(name).parent for name in names} if author is None else {author}
    return [path for folder in folders for path in folder.glob(author_file(Path(), "*").name)]


def _networks(lessons: Sequence[Subject]) -> list[Method]:
    """The source's networks trained on these, and the guess that a method has to beat."""
    labelled = [
        replace(one.recording, tyre=replace(one.recording.tyre, mu=one.declared)) for one in lessons
    ]
    return [neural_network(labelled), corrected_root(labelled), label_mean(labelled)]


def _check_names(finals: Sequence[Path], picture: Path | None) -> None:
    if len({path.resolve() for path in finals}) < len(finals):
        raise InvalidInputError("--out, --table and --picture must be different files")
    if picture is not None and picture.suffix.lower() != ".png":
        raise InvalidInputError(f"{picture}: the picture needs a name that ends in .png")
