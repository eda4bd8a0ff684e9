"""A comparison as tables, on the screen and in Markdown, and as JSON."""

import platform
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from typing import Any

import numpy as np

from brushgrip.comparison.error_and_calculation_time import PUBLISHED, CaseScores, MethodSummary
from brushgrip.comparison.recordings_with_reference_friction import SETTLED
from brushgrip.outputs.console import print_table, print_text
from symbolic.compilation.operating_system import cpuinfo_value

NOTE = (
    "RMSE of the effective friction μ_eff (μ on the declared model) against the declared μ, from"
    " {settled} s after the wheel began to turn; spread: its standard deviation over time after the"
    " first slide; ϑ = calculation time / measurement time, here, samples given one at a time."
)
PUBLISHED_NOTE = "Published: [Györök 2022], Table 6.1, six recordings on steel, ϑ on an Intel i5-8250U."
QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


Cells = tuple[str, ...]
TextTable = tuple[str, Cells, tuple[Cells, ...]]
"""Title, headings, of which the first stands left, and the cells of every row."""


def text_tables(results: Sequence[CaseScores], rows: Sequence[MethodSummary]) -> list[TextTable]:
    """Means beside [Györök 2022], Table 6.1; then error and time of every recording."""
    means = ("method", "RMSE", "spread", "ϑ", "beyond five zones", "deviation")
    published = (_cells(f"published: {row.method}", row) for row in PUBLISHED)
    own = (_cells(row.method, row) for row in rows)
    recordings = ("method", *(result.case.recording.name for result in results))
    errors = (
        ("declared μ", *(f"{result.case.declared:g}" for result in results)),
        *((row.method, *map(_error, metrics_by_case(results, row.method, "rmse"))) for row in rows),
    )
    times = (
        ("length [s]", *(f"{_recording_duration(result):.1f}" for result in results)),
        *(
            (row.method, *map(_time_ratio_text, metrics_by_case(results, row.method, "theta")))
            for row in rows
        ),
    )
    return [
        (f"Mean over {len(results)} recordings", means, (*published, *own)),
        ("RMSE of every recording", recordings, errors),
        ("ϑ of every recording", recordings, times),
    ]


def print_comparison(results: Sequence[CaseScores], rows: Sequence[MethodSummary]) -> None:
    """Prints the tables on standard output."""
    for sheet in text_tables(results, rows):
        print_table(*sheet, right=True, overflow="fold")
    print_text(NOTE.format(settled=SETTLED))
    print_text(PUBLISHED_NOTE)


def markdown_text(results: Sequence[CaseScores], rows: Sequence[MethodSummary]) -> str:
    """The same tables in Markdown."""
    parts: list[str] = []
    for title, headings, lines in text_tables(results, rows):
        rules = ["---", *(["---:"] * (len(headings) - 1))]
        parts += [f"{title}:", "\n".join(map(_markdown_row, (headings, rules, *lines)))]
    return "\n\n".join([*parts, NOTE.format(settled=SETTLED), PUBLISHED_NOTE]) + "\n"


def comparison_dict(results: Sequence[CaseScores], rows: Sequence[MethodSummary]) -> dict[str, Any]:
    """The comparison for JSON; None where a value is unknown, quantiles from least to greatest."""
    processor = cpuinfo_value("model name") or platform.processor() or platform.machine()
    return {
        "settled": SETTLED,
        "machine": {"processor": processor, "python": platform.python_version()},
        "published": [asdict(row) for row in PUBLISHED],
        "methods": [asdict(row) for row in rows],
        "recordings": [
            {
                "name": result.case.recording.name,
                "declared": result.case.declared,
                "declared_from": result.case.origin,
                "duration": _recording_duration(result),
                "samples": int(result.case.settled.sum()),
                "scores": [
                    {n: getattr(score, n) for n in ("method", "rmse", "spread", "theta")}
                    | {"quantiles": np.quantile(score.mu, QUANTILES).tolist()}
                    for score in result.scores
                ],
            }
            for result in results
        ],
    }


def _markdown_row(cells: Sequence[str]) -> str:
    """A row without what Markdown takes for a column, for HTML or for a link."""
    plain = (escape(cell.replace("|", "/"), quote=False).replace("](", "]\\(") for cell in cells)
    return f"| {' | '.join(plain)} |"


def _cells(name: str, row: MethodSummary) -> Cells:
    beyond = "in part" if row.works_beyond_five_zones is None else _yes(row.works_beyond_five_zones)
    errors = map(_error, (row.rmse, row.spread))
    return (name, *errors, _time_ratio_text(row.theta), beyond, _yes(row.gives_deviation))


def metrics_by_case(results: Sequence[CaseScores], method: str, name: str) -> list[float | None]:
    """A figure of one method on every case, `rmse` or `theta` [1]; None where the method has none."""
    return [
        next((getattr(score, name) for score in result.scores if score.method == method), None)
        for result in results
    ]


def _recording_duration(result: CaseScores) -> float:
    t = result.case.recording.t
    return float(t[-1] - t[0])


def _error(value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.3f}"


def _time_ratio_text(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}" if value < 1e-2 else f"{value:.3f}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
