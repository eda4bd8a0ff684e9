"""A fuzzer of one target, in a process of its own: python -m tests.attack.fuzz_process TARGET DIR ..."""

import sys
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["identification", "symbolic", "tomllib", "json"]):
    from tests.attack.fuzzing import broken_by
    from tests.attack.targets import TARGETS

NAME, FOUND, *ARGUMENTS = sys.argv[1:]


def one_input(content: bytes) -> None:
    """Keeps the first input of each failure, and goes on."""
    place = broken_by(TARGETS[NAME], content)
    if place and not (path := Path(FOUND) / place).exists():
        path.write_bytes(content)


if __name__ == "__main__":
    atheris.Setup([sys.argv[0], *ARGUMENTS], one_input)
    atheris.Fuzz()
