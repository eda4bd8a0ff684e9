"""The screen: lines and tables of results on standard output, progress on standard error."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from operator import gt
from typing import Any

from rich.cells import cell_len
from rich.console import Console, JustifyMethod, OverflowMethod
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as ProgressBar
from rich.table import Column, Table

from brushgrip.outputs.verbosity import RESULT, SPEECH, Verbosity
from brushgrip.wording.formatting import json_text
from symbolic.errors import printable

Progress = Callable[[str, int, int], None]
"""Called with the task, the number of its parts that are done, and their number."""

_SECONDS_BETWEEN_LINES = 10.0


def print_line(text: str) -> None:
    """One line on standard output, not wrapped, so that a path stays whole."""
    if SPEECH.get() is Verbosity.PLAIN:
        Console(highlight=False, markup=False, soft_wrap=True).print(printable(text))


def show_json(document: Mapping[str, Any] | Sequence[Any]) -> None:
    """The result of a command as JSON on standard output, where that is wanted."""
    if SPEECH.get() is Verbosity.JSON:
        # ASCII, so that it is the same on every terminal; what is not finite is null.
        print(json.dumps(json.loads(json_text(document)), indent=2), file=RESULT.get(), flush=True)


def print_text(text: str, style: str | None = None) -> None:
    """Text on standard output, wrapped; nothing where JSON or nothing is wanted."""
    _screen().print(text, style=style)


def print_table(
    title: str,
    headings: Iterable[str],
    rows: Iterable[Sequence[str]],
    *,
    right: bool = False,
    overflow: OverflowMethod = "ellipsis",
) -> None:
    """A table on standard output; `right` puts all columns but the first to the right."""
    table, screen = Table(title=title, title_justify="left"), _screen()
    columns = [list(column) for column in zip(headings, *rows, strict=True)]
    widths = _column_widths(columns, screen.width - 3 * len(columns) - 1)
    for place, ((heading, *_), width) in enumerate(zip(columns, widths, strict=True)):
        justify: JustifyMethod = "right" if place and right else "left"
        table.add_column(heading, justify=justify, overflow=overflow, width=width)
    for row in zip(*(cells for _, *cells in columns), strict=True):
        table.add_row(*row)
    screen.print(table)


def _column_widths(columns: Sequence[Sequence[str]], room: int) -> list[int]:
    """Widths that fit the room, taken from the widest columns, as far as no word of a heading breaks."""
    widths = [max(map(cell_len, cells)) for cells in columns]
    whole = [max(map(cell_len, heading.split()), default=1) for heading, *_ in columns]
    while sum(widths) > room and any(map(gt, widths, whole)):
        widths[max(range(len(widths)), key=lambda i: widths[i] * (widths[i] > whole[i]))] -= 1
    return widths


def _screen() -> Console:
    return Console(highlight=False, markup=False, quiet=SPEECH.get() is not Verbosity.PLAIN)


def warn(text: str) -> None:
    """One line on standard error."""
    Console(stderr=True, highlight=False, markup=False, soft_wrap=True).print(printable(text))


@contextmanager
def progress() -> Iterator[Progress]:
    """A bar on a terminal, elsewhere a plain line now and then, with the time since the beginning."""
    screen = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    if SPEECH.get() is Verbosity.QUIET:
        yield lambda *_: None
        return
    if not screen.is_terminal:
        yield _plain_progress(screen)
        return
    # What is done is cut off before bar and count are.
    described = Column(ratio=1, no_wrap=True, overflow="ellipsis")
    columns = (
        TextColumn("{task.description}", markup=False, table_column=described),
        BarColumn(bar_width=12),
        MofNCompleteColumn(table_column=Column(no_wrap=True)),
        TimeElapsedColumn(table_column=Column(no_wrap=True)),
    )
    with ProgressBar(*columns, console=screen, transient=True, expand=True) as bar:
        task = bar.add_task("reading", total=None)

        def report(message: str, done: int, total: int) -> None:
            bar.update(task, description=message, completed=done, total=total)

        yield report


def _plain_progress(screen: Console) -> Progress:
    """A line in ten seconds at most, the first after ten; time left is that of the present step."""
    begun = last = time.monotonic()
    step, step_begun, done_before = "", begun, 0

    def report(message: str, done: int, total: int) -> None:
        nonlocal last, step, step_begun, done_before
        now = time.monotonic()
        if message != step or done < done_before:
            # What is done as a step begins was kept from before, and says nothing of its pace.
            step, step_begun, done_before = message, now, done
        if now - last < _SECONDS_BETWEEN_LINES:
            return
        last = now
        # Its last parts may be its longest: nothing is said of less than the next line's time.
        line = f"{message}: {done} of {total}, {_duration_text(now - begun)} so far"
        left = (now - step_begun) / max(done - done_before, 1) * (total - done)
        if done > done_before and left >= _SECONDS_BETWEEN_LINES:
            line += f", about {_duration_text(left)} left in this step"
        screen.print(line)

    return report


def _duration_text(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
