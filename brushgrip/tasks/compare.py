"""`brushgrip compare`."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from itertools import combinations
from pathlib import Path

from brushgrip.atomic import check_picture_name, is_same_file, staged_file
from brushgrip.comparison.cases import Case, make_case
from brushgrip.comparison.methods import Method, default_methods
from brushgrip.comparison.networks import corrected_root, neural_network
from brushgrip.comparison.scores import compare as compare_methods
from brushgrip.comparison.scores import summarise
from brushgrip.comparison.tables import comparison_dict, markdown_text, print_comparison
from brushgrip.console import progress, say, show, warn
from brushgrip.estimation import implausible
from brushgrip.formatting import json_text
from brushgrip.pictures import draw_boxes
from brushgrip.provenance import KEY, markdown_comment, provenance_of
from brushgrip.recordings import files_read, keep_inputs, locate, read_all, signal_map
from brushgrip.user_effects import effect_files, user_effects
from identification import read_model
from identification.thesis import author_file, label_mean
from symbolic import InvalidInputError


def compare(
    *,
    recordings: Sequence[str],
    out: Path,
    rig: Path | None,
    channel_map: str | None,
    model: Path | None,
    effects: Sequence[str] | None,
    author: Path | None,
    declared: Sequence[float] | None,
    train: Sequence[str] | None,
    table: Path | None,
    picture: Path | None,
) -> None:
    """Write the comparison of methods, and say what it says.

    Its arguments are those of the command; see `brushgrip compare --help`.
    """
    finals = [path for path in (out, table, picture) if path is not None]
    _check_names(finals, picture)
    own = user_effects(effects)
    cases = _cases(recordings, rig, author, declared or [], channel_map)
    read_names = [*recordings, *(train or [])]
    signals = signal_map(rig, channel_map)
    files = files_read(read_names, signals, effect_files(effects))
    keep_inputs(finals, files, rig, model, *_author_files(read_names, author))
    for line in implausible([case.recording for case in cases]):
        warn(line)
    chosen = default_methods(None if model is None else read_model(model, effects=own))
    made = provenance_of(files, rig, model, signals.to_dict(), declared=list(declared or ()))
    if train:
        read_all([*recordings, *train], rig, given_map=channel_map)
        chosen += _networks(_cases(train, rig, author, (), channel_map))
    with ExitStack() as stack:
        stages = {final: stack.enter_context(staged_file(final)) for final in finals}
        with progress() as report:
            results = compare_methods(cases, chosen, report)
        summaries = summarise(results, chosen)
        document = comparison_dict(results, summaries) | {KEY: made}
        stages[out].write_text(json_text(document), encoding="utf-8", newline="\n")
        if table is not None:
            stages[table].write_text(
                markdown_text(results, summaries) + markdown_comment(made),
                encoding="utf-8",
                newline="\n",
            )
        if picture is not None:
            draw_boxes(stages[picture], results, [row.method for row in summaries])
    print_comparison(results, summaries)
    show(document)
    say(f"wrote {', '.join(map(str, finals))}")


def _cases(
    names: Sequence[str],
    rig: Path | None,
    author: Path | None,
    declared: Sequence[float],
    given_map: str | None,
) -> list[Case]:
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
    read = read_all(names, rig, causal=True, given_map=given_map)
    references = [*declared, *[declared[0] if declared else None] * (len(read) - len(declared))]
    return [
        make_case(recording, locate(name).parent if author is None else author, mu)
        for recording, name, mu in zip(read, names, references, strict=True)
    ]


def _author_files(names: Sequence[str], author: Path | None) -> list[Path]:
    """The estimates of [Györök 2022] that may be read along with these recordings."""
    folders = {locate(name).parent for name in names} if author is None else {author}
    return [path for folder in folders for path in folder.glob(author_file(Path(), "*").name)]


def _networks(training: Sequence[Case]) -> list[Method]:
    """The networks of [Györök 2022] trained on these cases, and the mean that a method has to beat."""
    labelled = [
        replace(one.recording, tyre=replace(one.recording.tyre, mu=one.declared)) for one in training
    ]
    return [neural_network(labelled), corrected_root(labelled), label_mean(labelled)]


def _check_names(finals: Sequence[Path], picture: Path | None) -> None:
    if any(is_same_file(*pair) for pair in combinations(finals, 2)):
        raise InvalidInputError("--out, --table and --picture must be different files")
    if picture is not None:
        check_picture_name(picture)
