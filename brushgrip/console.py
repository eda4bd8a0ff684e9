"""The screen: lines and tables of results on standard output, progress on standard error."""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
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
from identification import Diagnosis, FoundModel, FreeDecay, ParameterEstimate, Recording
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


def _screen() -> Console:
    """Standard output for tables; quiet where JSON or nothing is wanted."""
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
    return (
        f"{hours} h {minutes} min"
        if hours
        else f"{minutes} min {seconds} s"
        if minutes
        else f"{seconds} s"
    )


def print_diagnosis(diagnosis: Diagnosis, outcome: FrictionOutcome | None = None) -> None:
    """Print errors, effects and the unexplained residual on standard output."""
    screen = _screen()
    screen.print(headline(diagnosis), style="bold")
    screen.print(_errors_table(diagnosis))
    screen.print(f"Before any effect: {diagnosis.signatures_before.reading}")
    if diagnosis.effects:
        screen.print(_effects_table(diagnosis))
    for effect in diagnosis.effects:
        if effect.grade != "strong":
            screen.print(f"{plain(effect.name)}, {GRADES[effect.grade]}: {explained_grade(effect)}")
    for effect in diagnosis.effects:
        if effect.experiment:
            screen.print(f"next experiment: {sentence(effect.experiment.sentence)}")
    if outcome:
        screen.print(_friction_table(outcome))
    screen.print(f"{residual_structure(diagnosis)} {sentence(diagnosis.unexplained.evidence)}")
    for note in diagnosis.notes:
        screen.print(f"note: {note}")


def _errors_table(diagnosis: Diagnosis) -> Table:
    table = Table(title="Torque error, root mean square", title_justify="left")
    table.add_column("model")
    for heading in error_columns(diagnosis).values():
        table.add_column(heading, justify="right")
    for label, errors in (
        ("declared", diagnosis.declared),
        ("before", diagnosis.before),
        ("after", diagnosis.after),
    ):
        table.add_row(label, *error_figures(diagnosis, errors))
    return table


def _effects_table(diagnosis: Diagnosis) -> Table:
    table = Table(title="Effects found", title_justify="left")
    for heading in ("effect", "grade", "parameters ± standard deviation", "indistinguishable from"):
        table.add_column(heading)
    for effect in diagnosis.effects:
        rivals = listed([plain(name) for name in effect.indistinguishable_from], "or")
        table.add_row(
            plain(effect.name), GRADES[effect.grade], parameters(effect.parameters), rivals or "–"
        )
    return table


def _friction_table(outcome: FrictionOutcome) -> Table:
    table = Table(title="Effective friction by the EKF", title_justify="left")
    table.add_column("figure")
    for stage in outcome.stages:
        table.add_column(stage, justify="right")
    for label, figures in friction_figures(outcome):
        table.add_row(label, *figures)
    return table


def print_free_decay(result: FreeDecay, decrement: DecrementEstimate) -> None:
    """Print k and b_t by maximum likelihood and by [Györök 2022], and what determines them."""
    screen = _screen()
    screen.print(_identified_table(result, decrement))
    forces = [
        f"{quantity(contact.force)} at a = {1000 * contact.a:g} mm"
        for contact in result.contacts
        if contact.force is not None
    ]
    if forces:
        screen.print(f"The ends of the patch slide as with μ F_N = {', '.join(forces)}.")
    for line in result.identifiability:
        screen.print(line)


def _identified_table(result: FreeDecay, decrement: DecrementEstimate) -> Table:
    table = Table(title=f"From {len(result.vibrations)} free vibrations", title_justify="left")
    for heading in ("", "k", "b_t"):
        table.add_column(heading)
    values = (
        ParameterEstimate(value=parameter.value, std=parameter.std, unit=parameter.unit)
        for parameter in (result.k, result.b_t)
    )
    table.add_row("maximum likelihood", *map(quantity, values))
    for label, damping in (
        (
            "FFT and decrement, (5.8) with J_A",
            ParameterEstimate(value=decrement.b_t, std=None, unit=result.b_t.unit),
        ),
        (
            "FFT and decrement, (5.8) as printed",
            ParameterEstimate(value=decrement.b_t_printed, std=None, unit="1/s"),
        ),
    ):
        k = ParameterEstimate(value=decrement.k, std=None, unit=result.k.unit)
        table.add_row(label, quantity(k), quantity(damping))
    return table
