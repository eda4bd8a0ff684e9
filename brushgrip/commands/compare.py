"""`brushgrip compare`."""

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from brushgrip.commands.options import ModelFile, OutJson, RecordingRequest, option, output_file_option


@dataclass(frozen=True, kw_only=True)
class CompareRequest(RecordingRequest):
    """Compare EKF and MHE with the root solve of [Györök 2022]: its Table 6.1, on any recordings.

    The table gives the RMSE of mu, its spread, and calculation time over measurement time on this
    machine; beside them the author's estimate, where there is a file of it, and the published figures.
    Without --declared, errors refer to mu of the author's file, of the published surface, or of the rig.
    """

    out: OutJson = None
    model: ModelFile = None
    author: Path | None = option(
        "--author", "DIR", "Folder of author_estimate_*.csv; that of each recording if left out."
    )
    declared: list[float] | None = option(
        "--declared", "MU...", "Friction that errors refer to: one for all recordings, or one each."
    )
    train: list[str] | None = option(
        "--train",
        "REC...",
        "Recordings with a known mu on which the two networks of [Györök 2022] are trained; the"
        " table then has them, and the mean of their labels. Needs scikit-learn.",
    )
    table: Path | None = output_file_option("--table", "TABLE.md", "Tables in Markdown as well.")
    picture: Path | None = output_file_option("--picture", "PNG", "Box charts as well.")

    def run(self) -> None:
        """Write the comparison of methods, and say what it says."""
        from brushgrip.comparison.error_and_calculation_time import compare_methods, summarise
        from brushgrip.comparison.methods import default_methods, trained_methods
        from brushgrip.comparison.recordings_with_reference_friction import (
            author_estimate_files,
            check_reference_frictions,
            make_cases,
        )
        from brushgrip.comparison.tables import comparison_dict, markdown_text, print_comparison
        from brushgrip.estimation.recording_warnings import implausibility_lines
        from brushgrip.outputs.atomic import check_png_name, is_same_file, staged_files, write_utf8
        from brushgrip.outputs.console import print_line, progress, show_json, warn
        from brushgrip.outputs.provenance import KEY, markdown_comment
        from brushgrip.pictures.method_comparison_boxes import draw_method_comparison
        from brushgrip.wording.formatting import json_text
        from symbolic import InvalidInputError

        declared, count = self.declared or [], len(self.recordings)
        finals = [path for path in (self.out, self.table, self.picture) if path is not None]
        if any(is_same_file(*pair) for pair in combinations(finals, 2)):
            raise InvalidInputError("--out, --table and --picture must be different files")
        if self.picture is not None:
            check_png_name(self.picture)
        check_reference_frictions(declared, count, self.author)
        inputs = self.inputs(self.train or (), model=self.model)
        inputs.refuse_overwriting(finals, author_estimate_files(inputs.paths.values(), self.author))
        made = inputs.provenance(declared=declared)
        tested, training = (inputs.part(of) for of in (slice(count), slice(count, None)))
        cases = make_cases(tested, self.author, declared)
        for line in implausibility_lines([case.recording for case in cases]):
            warn(line)
        methods = default_methods(inputs.read_found_model())
        if self.train:
            inputs.recordings()  # One recording for training and for the test is a fault.
            methods += trained_methods(make_cases(training, self.author, ()))
        with staged_files(finals) as stages:
            with progress() as report:
                results = compare_methods(cases, methods, report)
            summaries = summarise(results, methods)
            document = comparison_dict(results, summaries) | {KEY: made}
            staged = dict(zip(finals, stages, strict=True))
            if self.out is not None:
                write_utf8(staged[self.out], json_text(document))
            if self.table is not None:
                write_utf8(
                    staged[self.table], markdown_text(results, summaries) + markdown_comment(made)
                )
            if self.picture is not None:
                draw_method_comparison(staged[self.picture], results, [row.method for row in summaries])
        print_comparison(results, summaries)
        show_json(document)
        if finals:
            print_line(f"wrote {', '.join(map(str, finals))}")
