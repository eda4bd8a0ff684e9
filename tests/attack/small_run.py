"""`brushgrip` with three candidates only: a whole search takes seconds. Arguments are the command's."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from brushgrip.__main__ import load_command
from brushgrip.running.interrupts import run_command_and_exit

FEW = ("torque_offset", "contact_damping", "steering_return")


def load() -> Callable[[], None]:
    """The command with few candidates."""
    command = load_command()
    import symbolic
    from brushgrip.report import diagnosis_folder as diagnosing

    quick = bool(os.environ.get("BRUSHGRIP_SMALL_QUICK"))
    symbolic.CANDIDATES = {name: symbolic.CANDIDATES[name] for name in (FEW[:2] if quick else FEW)}
    if quick:
        diagnosing.write_report = lambda *_: None
    return command


if __name__ == "__main__":
    # As in a terminal: a shell starts what is in the background deaf to Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    run_command_and_exit(load)
