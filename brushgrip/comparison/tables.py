"""A comparison as tables, on the screen and in Markdown, and as JSON."""

import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from brushgrip.comparison.cases import SETTLED
from brushgrip.comparison.scores import PUBLISHED, Compared, Row

NOTE = (
    "RMSE of μ against the declared μ, from {settled} s after the wheel began to turn; spread: standard"
    " deviation of μ over time after the first slide; ϑ = calculation time / measurement time, here,"
    " samples handed over one at a time."
)
PUBLISHED_NOTE = "Published: Table 6.1 of the source, six recordings on steel, ϑ on an Intel i5-8250U."
QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A table as text.

    Attributes:
        title: what it shows.
        headings: of the columns; the first column stands left, the others right.
        lines: cells of every row.
    """

    title: str
    headings: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]


def sheets(compared: Sequence[Compared], rows: Sequence[Row]) -> list[Sheet]:
    """Table 6.1 beside ours, then RMSE and time for every recording."""
    recordings = ("method", *map(_name, compared))
    return [
        Sheet(
            title=f"Mean over {len(compared)} recordings",
            headings=("method", "RMSE", "spread", "ϑ", "beyond five zones", "deviation"),
            lines=tuple(
                [_cells(f"published: {row.method}", row) for row in PUBLISHED]
                + [_cells(row.method, row) for row in rows]
            ),
        ),
        Sheet(
            title="RMSE of every recording",
            headings=recordings,
            lines=(
                ("declared μ", *(f"{one.subject.declared:g}" for one in compared)),
                *((row.method, *(_error(_rmse(one, row)) for one in compared)) for row in rows),
            ),
        ),
        Sheet(
            title="ϑ of every recording",
            headings=recordings,
            lines=(
                ("length [s]", *(f"{_duration(one):.1f}" for one in compared)),
                *((row.method, *(_time(_theta(one, row)) for one in compared)) for row in rows),
            ),
        ),
    ]


def print_comparison(compared: Sequence[Compared], rows: Sequence[Row]) -> None:
    """Prints the tables on standard output."""
    screen = Console(highlight=False, markup=False)
    for sheet in sheets(compared, rows):
        table = Table(title=sheet.title, title_justify="left")
        for place, heading in enumerate(sheet.headings):
            table.add_column(heading, justify="right" if place else "left", overflow="fold")
        for line in sheet.lines:
            table.add_row(*line)
        screen.print(table)
    screen.print(NOTE.format(settled=SETTLED))
    screen.print(PUBLISHED_NOTE)


def markdown_text(compared: Sequence[Compared], rows: Sequence[Row]) -> str:
    """The same tables in Markdown."""
    parts = [part for sheet in sheets(compared, rows) for part in (f"{sheet.title}:", _markdown(sheet))]
    return "\n\n".join([*parts, NOTE.format(settled=SETTLED), PUBLISHED_NOTE]) + "\n"


def comparison_dict(compared: Sequence[Compared], rows: Sequence[Row]) -> dict[str, Any]:
    """The comparison as JSON takes it; null where something is not known.

    Keys: `settled` [s]; `machine`; `published` and `methods`, rows of Table 6.1; `recordings`, each with
    its `scores`, where `quantiles` are minimum, quartiles and maximum of the estimate.
    """
    return {
        "settled": SETTLED,
        "machine": {"processor": processor(), "python": platform.python_version()},
        "published": [asdict(row) for row in PUBLISHED],
        "methods": [asdict(row) for row in rows],
        "recordings": [
            {
                "name": _name(one),
                "declared": one.subject.declared,
                "declared_from": one.subject.origin,
                "duration": _duration(one),
                "samples": int(one.subject.settled.sum()),
                "scores": [
                    {
                        "method": score.method,
                        "rmse": score.rmse,
                        "spread": score.spread,
                        "theta": score.theta,
                        "quantiles": np.quantile(score.mu, QUANTILES).tolist(),
                    }
                    for score in one.scores
                ],
            }
            for one in compared
        ],
    }


def processor() -> str:
    """What the times were measured on."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        text = ""
    names = [
        line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")
    ]
    return names[0] if names else platform.processor() or platform.machine()


def _markdown(sheet: Sheet) -> str:
    rules = ["---", *(["---:"] * (len(sheet.headings) - 1))]
    return "\n".join(_line(cells) for cells in (sheet.headings, rules, *sheet.lines))


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def _cells(name: str, row: Row) -> tuple[str, ...]:
    beyond = "in part" if row.works_beyond_five_zones is None else _yes(row.works_beyond_five_zones)
    return (
        name,
        _error(row.rmse),
        _error(row.spread),
        _time(row.theta),
        beyond,
        _yes(row.gives_deviation),
    )


def _rmse(one: Compared, row: Row) -> float | None:
    return next((score.rmse for score in one.scores if score.method == row.method), None)


def _theta(one: Compared, row: Row) -> float | None:
    return next((score.theta for score in one.scores if score.method == row.method), None)


def _name(one: Compared) -> str:
    return one.subject.recording.name


def _duration(one: Compared) -> float:
    t = one.subject.recording.t
    return float(t[-1] - t[0])


def _error(value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.3f}"


def _time(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}" if value < 1e-2 else f"{value:.3f}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
