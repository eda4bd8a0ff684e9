"""The command `brushgrip`: its commands, its exit status and its error messages."""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextvars import copy_context
from dataclasses import fields
from importlib import import_module
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from inspect import Signature, signature
from pkgutil import iter_modules
from typing import Annotated, Any, get_type_hints

import typer
from typer.core import TyperCommand

from brushgrip import commands
from brushgrip.cli.own_packages_shadowed import shadowed_packages_message
from brushgrip.commands.options import OPTION
from brushgrip.outputs.standard_streams import REMARKS, replace_unencodable_characters, stdout_fault
from brushgrip.outputs.verbosity import COMMAND_LINE, SPEECH, Verbosity, flags_first, stdout_for_json

BAD_INPUT, FAILED = 2, 1
"""Exit status for input that the user can correct, and for failures outside, such as of a download."""
LISTS = ("--holdout", "--train", "--free-decay", "--plates", "--lock-to-lock", "--declared")
"""Options that take one or more names after the flag."""

app = typer.Typer(
    name="brushgrip",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # Plain help takes half the time, and fits every terminal.
)
EVERYWHERE = "--json and --quiet stand before or behind the name of a command."
ORDER = ("demo", "fetch", "simulate", "identify", "diagnose", "estimate", "plan", "compare", "codegen")
"""Of the commands in the help; others come after these."""


def command_request_classes() -> dict[str, type]:
    """The request of each command, by its name, from its file; in the order of the help."""
    names = {module.name for module in iter_modules(commands.__path__)} - {"options"}
    places = {name: place for place, name in enumerate(ORDER)}
    return {
        name: getattr(import_module(f"{commands.__name__}.{name}"), f"{name.capitalize()}Request")
        for name in sorted(names, key=lambda name: (places.get(name, len(places)), name))
    }


COMMANDS = command_request_classes()


class NoRepeatedOptionsCommand(TyperCommand):
    """A command that refuses an option which is given twice, unless it may be repeated."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments, of which the parser itself would take the last."""
        _, _, given = self.make_parser(ctx).parse_args(args=list(args))
        for one, count in Counter(given).items():
            if count > 1 and not getattr(one, "multiple", False):
                from symbolic import InvalidInputError

                raise InvalidInputError(f"{one.opts[0]} is given twice; it may be given once")
        return super().parse_args(ctx, args)


def command_of(request: type) -> Callable[..., None]:
    """A function with the fields of a request as its parameters, which fills the request and runs it."""

    def run(**options: object) -> None:
        request(**options).run()

    run.__doc__ = request.__doc__
    run.__annotations__ = get_type_hints(request, include_extras=True)
    asked = {one.name: one.metadata[OPTION] for one in fields(request) if OPTION in one.metadata}
    own = signature(request).parameters.values()
    given = [one.replace(default=asked.get(one.name, one.default)) for one in own]
    run.__signature__ = Signature(given)  # type: ignore[attr-defined]
    return run


for command, request in COMMANDS.items():
    app.command(command, cls=NoRepeatedOptionsCommand, epilog=EVERYWHERE)(command_of(request))


def _say_version(wanted: bool) -> None:
    if not wanted:
        return
    try:
        number = version_of("brushgrip")
    except PackageNotFoundError:
        number = "of a checkout that is not installed"
    print(f"brushgrip {number}")
    raise typer.Exit


@app.callback(epilog=EVERYWHERE)
def global_options(
    context: typer.Context,
    json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Print nothing, and no progress, but what goes wrong.")
    ] = False,
    version: Annotated[  # noqa: ARG001
        bool, typer.Option("--version", help="Print the version.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """Estimates tyre-road friction at standstill from the steering torque."""
    if json and quiet:
        raise typer.BadParameter("--json prints the result, --quiet nothing; give one of them")
    SPEECH.set(Verbosity.JSON if json else Verbosity.QUIET if quiet else Verbosity.PLAIN)
    if json:
        context.with_resource(stdout_for_json())


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs a command; bad input leaves one line on standard error.

    Args:
        arguments: command line without the name of the program; None for that of the process.

    Raises:
        SystemExit: always; status 0 on success, 2 for bad input, 1 for failures outside.
    """
    replace_unencodable_characters()
    if message := shadowed_packages_message():
        print(f"brushgrip: {message}", file=sys.stderr)
        raise SystemExit(FAILED)
    if arguments is not None:
        raise SystemExit(copy_context().run(_run_and_get_exit_status, arguments))
    status = copy_context().run(_run_and_get_exit_status, sys.argv[1:])
    fault = stdout_fault()
    if fault and not status:
        _print_error(f"standard output: cannot be written: {fault}")
    raise SystemExit(status if fault is None else status or FAILED)


def _run_and_get_exit_status(arguments: Sequence[str]) -> int:
    """The exit status of a command line, in a context of its own; what went wrong is said."""
    # A command line without anything asks what there is.
    given = flags_first(repeat_flag_per_value(arguments)) or ["--help"]
    COMMAND_LINE.set(tuple(arguments))
    REMARKS.set(set())
    try:
        status = app(args=given, prog_name="brushgrip", standalone_mode=False)
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
        return _print_error_get_exit_status(error)
    return status or 0


def _print_error_get_exit_status(error: Exception) -> int:
    """The exit status for an error that is ours or the user's, once it is said; any other is raised."""
    from symbolic import BrushgripError, InvalidInputError

    if isinstance(error, BrushgripError):
        _print_error(str(error))
        return BAD_INPUT if isinstance(error, InvalidInputError) else FAILED
    # Faults of usage come from the parser below typer, whose class differs between its versions.
    if not hasattr(error, "format_message"):
        raise error
    message = error.format_message().replace(": Value error, ", ": ")
    _print_error(message or "no command given; brushgrip --help lists them")
    return BAD_INPUT


def _print_error(message: str) -> None:
    from symbolic.errors import cut_to_one_line

    print(f"brushgrip: {cut_to_one_line(' '.join(message.split()))}", file=sys.stderr)


def repeat_flag_per_value(arguments: Sequence[str]) -> list[str]:
    """The arguments with `--holdout A B` written as `--holdout A --holdout B`, and so all of `LISTS`."""
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
