"""`brushgrip` and `python -m brushgrip`: ready for Ctrl-C before anything long is imported."""

try:
    from collections.abc import Callable

    from brushgrip.running.interrupts import run_command_and_exit
except KeyboardInterrupt:
    raise SystemExit(130) from None


def main() -> None:
    """Runs the command line of the process, and exits; see `brushgrip.cli.app.main`."""
    run_command_and_exit(load_command)


def load_command() -> Callable[[], None]:
    """Imports the command; matplotlib keeps to itself that it cannot write its cache of fonts."""
    import logging

    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from brushgrip.cli.app import main

    return main


if __name__ == "__main__":
    main()
