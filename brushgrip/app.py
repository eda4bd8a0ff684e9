"""The command `brushgrip`: its commands, its exit status and its error messages."""

import sys
from collections.abc import Sequence

import typer

from brushgrip.commands.codegen import codegen
from brushgrip.commands.compare import compare
from brushgrip.commands.demo import demo
from brushgrip.commands.diagnose import diagnose
from brushgrip.commands.estimate import estimate
from brushgrip.commands.fetch import fetch
from brushgrip.commands.identify import identify
from brushgrip.commands.simulate import simulate
from brushgrip.terminal import fault_of_output, spell_what_is_lacking
from symbolic import BrushgripError, InvalidInputError
from symbolic.errors import one_line

BAD_INPUT, FAILED = 2, 1
"""Exit status for input that the user can correct, and for failures outside, such as of a download."""
LISTS = ("--holdout", "--train", "--free-decay", "--declared")
"""Options that take one or more names after the flag."""

app = typer.Typer(
    name="brushgrip",
    help="Estimates tyre-road friction at standstill from the steering torque.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (demo, fetch, simulate, identify, diagnose, estimate, compare, codegen):
    app.command()(command)


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs a command; bad input leaves one line on standard error.

    Args:
        arguments: command line without the name of the program; None for that of the process.

    Raises:
        SystemExit: always; status 0 on success, 2 for bad input, 1 for failures outside.
    """
    spell_what_is_lacking()
    if arguments is not None:
        raise SystemExit(_run(arguments))
    status = _run(sys.argv[1:])
    fault = fault_of_output()
    if fault and not status:
        _print_error(f"standard output: cannot be written: {fault}")
    raise SystemExit(status if fault is None else status or FAILED)


def _run(arguments: Sequence[str]) -> int:
    """The exit status of a command line; what went wrong is said."""
    try:
        status = app(args=repeat_lists(arguments), prog_name="brushgrip", standalone_mode=False)
    except BrushgripError as error:
        _print_error(str(error))
        return BAD_INPUT if isinstance(error, InvalidInputError) else FAILED
    except (typer.Abort, BrokenPipeError):
        return FAILED
    except OSError as error:
        # Such as a full disk, which a stream says without a name.
        _print_error(f"{error.filename or 'cannot write'}: {error.strerror or error}")
        return FAILED
    except MemoryError as error:
        _print_error(f"there is not enough memory: {error}")
        return FAILED
    except Exception as error:
        # Faults of usage come from the parser below typer, whose class differs between its versions.
        if not hasattr(error, "format_message"):
            raise
        _print_error(error.format_message() or "no command given; brushgrip --help lists them")
        return BAD_INPUT
    return status or 0


def _print_error(message: str) -> None:
    print(f"brushgrip: {one_line(' '.join(message.split()))}", file=sys.stderr)


def repeat_lists(arguments: Sequence[str]) -> list[str]:
    """The arguments with `--holdout A B` written as `--holdout A --holdout B`, and so all of `LISTS`.

    Everything up to the next argument that begins with a dash belongs to the option.
    """
    spread: list[str] = []
    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        name, sign, value = argument.partition("=")
        if sign and name in LISTS:
            argument, rest = name, [value, *rest]
        if argument == "--":
            return [*spread, argument, *rest]
        if argument not in LISTS or not rest or rest[0].startswith("-"):
            spread.append(argument)
            continue
        while rest and not rest[0].startswith("-"):
            spread += [argument, rest.pop(0)]
    return spread
