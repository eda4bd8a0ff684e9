"""The screen: lines and tables of results on standard output, progress on standard error."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console, JustifyMethod, OverflowMethod
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as ProgressBar
from rich.table import Table

from brushgrip.formatting import (
    error_columns,
    error_figures,
    json_text,
    listed,
    parameters,
    plain,
    quantity,
    residual_structure,
    sentence,
)
from brushgrip.friction_outcome import FrictionOutcome, friction_figures
from brushgrip.speech import RESULT, SPEECH, Speech
from brushgrip.verdict import GRADES, explained_grade, headline
from identification import Diagnosis, FoundEffect, FoundModel, FreeDecay, ParameterEstimate, Recording
from identification.thesis import DecrementEstimate
from symbolic.errors import printable

Progress = Callable[[str, int, int], None]
"""Called with the task, the number of its parts that are done, and their number."""

_SECONDS_BETWEEN_LINES = 10.0


def say(text: str) -> None:
    """One line on standard output, not wrapped, so that a path stays whole."""
    if SPEECH.get() is Speech.PLAIN:
        Console(highlight=False, markup=False, soft_wrap=True).print(printable(text))


def show(document: Mapping[str, Any] | Sequence[Any]) -> None:
    """The result of a command as JSON on standard output, where that is wanted."""
    if SPEECH.get() is Speech.JSON:
        # ASCII, so that it is the same on every terminal; what is not finite is null.
        print(json.dumps(json.loads(json_text(document)), indent=2), file=RESULT.get(), flush=True)


def say_ground(recording: Recording, found: FoundModel | None) -> None:
    """One line on the ground whose values are taken from a model, where it has any."""
    if found and (taken := found.ground_taken(recording.ground)):
        say(f"{recording.name}: {taken}")


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
    table = Table(title=title, title_justify="left")
    for place, heading in enumerate(headings):
        justify: JustifyMethod = "right" if place and right else "left"
        table.add_column(heading, justify=justify, overflow=overflow)
    for row in rows:
        table.add_row(*row)
    _screen().print(table)


def _screen() -> Console:
    return Console(highlight=False, markup=False, quiet=SPEECH.get() is not Speech.PLAIN)


def warn(text: str) -> None:
    """One line on standard error."""
    Console(stderr=True, highlight=False, markup=False, soft_wrap=True).print(printable(text))


@contextmanager
def progress() -> Iterator[Progress]:
    """A bar on a terminal, elsewhere a plain line now and then; both with the time that is left.

    How many steps a search takes shows only as it goes: the time is that of the present step, beside
    the time since the beginning.
    """
    screen = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    if SPEECH.get() is Speech.QUIET:
        yield lambda *_: None
        return
    if not screen.is_terminal:
        yield _plain_lines(screen)
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left in this step:"),
        TimeRemainingColumn(),
    )
    with ProgressBar(*columns, console=screen, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def report(message: str, done: int, total: int) -> None:
            bar.update(task, description=message, completed=done, total=total)

        yield report


def _plain_lines(screen: Console) -> Progress:
    """At most one line in ten seconds, the first after ten: a quick fault stands alone."""
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
        line = f"{message}: {done} of {total}, {_spoken_time(now - begun)} so far"
        if done_before < done < total:
            left = (now - step_begun) / (done - done_before) * (total - done)
            line += f", about {_spoken_time(left)} left in this step"
        screen.print(line)

    return report


def _spoken_time(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"


def print_diagnosis(diagnosis: Diagnosis, outcome: FrictionOutcome | None = None) -> None:
    """Print errors, effects and the unexplained residual on standard output."""
    print_text(headline(diagnosis), style="bold")
    stages = {"declared": diagnosis.declared, "before": diagnosis.before, "after": diagnosis.after}
    print_table(
        "Torque error, root mean square",
        ("model", *error_columns(diagnosis).values()),
        [(label, *error_figures(diagnosis, errors)) for label, errors in stages.items()],
        right=True,
    )
    print_text(f"Before any effect: {diagnosis.signatures_before.reading}")
    if diagnosis.effects:
        print_table(
            "Effects found",
            ("effect", "grade", "parameters ± standard deviation", "indistinguishable from"),
            [_effect_row(effect) for effect in diagnosis.effects],
        )
    for effect in diagnosis.effects:
        if effect.grade != "strong":
            print_text(f"{plain(effect.name)}, {GRADES[effect.grade]}: {explained_grade(effect)}")
    for effect in diagnosis.effects:
        if effect.experiment:
            print_text(f"next experiment: {sentence(effect.experiment.sentence)}")
    if outcome:
        figures = [(label, *values) for label, values in friction_figures(outcome)]
        headings = ("figure", *outcome.stages)
        print_table("Effective friction by the EKF", headings, figures, right=True)
    print_text(f"{residual_structure(diagnosis)} {sentence(diagnosis.unexplained.evidence)}")
    for note in diagnosis.notes:
        print_text(f"note: {note}")


def _effect_row(effect: FoundEffect) -> tuple[str, ...]:
    rivals = listed([plain(name) for name in effect.indistinguishable_from], "or")
    return plain(effect.name), GRADES[effect.grade], parameters(effect.parameters), rivals or "–"


def print_free_decay(result: FreeDecay, decrement: DecrementEstimate) -> None:
    """Print k and b_t by maximum likelihood and by [Györök 2022], and what determines them."""
    k, b_t = (
        quantity(ParameterEstimate(value=one.value, std=one.std, unit=one.unit))
        for one in (result.k, result.b_t)
    )
    rough_k, with_J_A, as_printed = (
        quantity(ParameterEstimate(value=value, std=None, unit=unit))
        for value, unit in (
            (decrement.k, result.k.unit),
            (decrement.b_t, result.b_t.unit),
            (decrement.b_t_printed, "1/s"),
        )
    )
    print_table(
        f"From {len(result.vibrations)} free vibrations",
        ("", "k", "b_t"),
        [
            ("maximum likelihood", k, b_t),
            ("FFT and decrement, (5.8) with J_A", rough_k, with_J_A),
            ("FFT and decrement, (5.8) as printed", rough_k, as_printed),
        ],
    )
    forces = [
        f"{quantity(contact.force)} at a = {1000 * contact.a:g} mm"
        for contact in result.contacts
        if contact.force is not None
    ]
    if forces:
        print_text(f"The ends of the patch slide as with μ F_N = {', '.join(forces)}.")
    for line in result.identifiability:
        print_text(line)
