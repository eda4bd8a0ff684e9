"""How much a command says, and in which form: chosen once, before anything heavy is imported."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from enum import StrEnum
from typing import TextIO


class Verbosity(StrEnum):
    """What goes to standard output, and whether progress goes to standard error."""

    PLAIN = "plain"
    """Lines and tables; progress."""
    JSON = "json"
    """One JSON document; progress."""
    QUIET = "quiet"
    """Nothing, and no progress; what went wrong is said all the same."""


SPEECH: ContextVar[Verbosity] = ContextVar("SPEECH", default=Verbosity.PLAIN)
"""The speech of the command that runs."""
COMMAND_LINE: ContextVar[tuple[str, ...]] = ContextVar("COMMAND_LINE", default=())
"""Arguments of the command that runs."""
RESULT: ContextVar[TextIO | None] = ContextVar("RESULT", default=None)
"""Where the one JSON document goes; None for standard output."""
FLAGS = ("--quiet", "--json")
"""Options of `brushgrip` itself that may also stand behind the command's name."""


def flags_first(arguments: list[str]) -> list[str]:
    """The arguments with `FLAGS` before the name of the command, as the parser wants them."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    named, rest = arguments[:end], arguments[end:]
    flags = [argument for argument in named if argument in FLAGS]
    return [*flags, *(argument for argument in named if argument not in FLAGS), *rest]


@contextmanager
def stdout_for_json() -> Iterator[None]:
    """Keeps standard output for the JSON document, as a context.

    What a user's effects print, in this process or in those that it starts, goes to standard error.
    """
    try:
        number = sys.stdout.fileno()
    except (OSError, ValueError):  # Something else stands in its place.
        yield
        return
    sys.stdout.flush()
    with open(os.dup(number), "w", encoding=sys.stdout.encoding) as result:  # noqa: PTH123
        os.dup2(sys.stderr.fileno(), number)
        token = RESULT.set(result)
        try:
            yield
        finally:
            RESULT.reset(token)
            sys.stdout.flush()
            os.dup2(result.fileno(), number)
