"""How much a command says, and in which form: chosen once, before anything heavy is imported."""

from contextvars import ContextVar
from enum import StrEnum


class Speech(StrEnum):
    """What goes to standard output, and whether progress goes to standard error."""

    PLAIN = "plain"
    """Lines and tables; progress."""
    JSON = "json"
    """One JSON document; progress."""
    QUIET = "quiet"
    """Nothing, and no progress; what went wrong is said all the same."""


SPEECH: ContextVar[Speech] = ContextVar("SPEECH", default=Speech.PLAIN)
"""The speech of the command that runs."""
COMMAND_LINE: ContextVar[tuple[str, ...]] = ContextVar("COMMAND_LINE", default=())
"""Arguments of the command that runs."""
FLAGS = ("--quiet", "--json")
"""Options of `brushgrip` itself that may also stand behind the command's name."""


def flags_first(arguments: list[str]) -> list[str]:
    """The arguments with `FLAGS` before the name of the command, as the parser wants them."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    named, rest = arguments[:end], arguments[end:]
    flags = [argument for argument in named if argument in FLAGS]
    return [*flags, *(argument for argument in named if argument not in FLAGS), *rest]
