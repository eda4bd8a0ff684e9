"""What is said on screen: results on standard output, progress on standard error."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

Report = Callable[[str, int, int], None]
"""Takes what is being done, how much of it is done, and how much there is."""

_SECONDS_BETWEEN_LINES = 10.0


def say(text: str) -> None:
    """One line on standard output, not wrapped, so that a path stays whole."""
    Console(highlight=False, markup=False, soft_wrap=True).print(text)


def warn(text: str) -> None:
    """One line on standard error."""
    Console(stderr=True, highlight=False, markup=False, soft_wrap=True).print(text)


@contextmanager
def progress() -> Iterator[Report]:
    """A bar on a terminal, elsewhere a plain line now and then."""
    screen = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    if not screen.is_terminal:
        yield _plain_lines(screen)
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def report(message: str, done: int, total: int) -> None:
            bar.update(task, description=message, completed=done, total=total)

        yield report


def _plain_lines(screen: Console) -> Report:
    """At most one line in ten seconds, the first after ten: a quick fault stands alone."""
    last = time.monotonic()

    def report(message: str, done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _SECONDS_BETWEEN_LINES:
            last = now
            screen.print(f"{message}: {done} of {total}")

    return report
