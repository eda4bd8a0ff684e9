"""A fuzzer of one target, in a process of its own: python -m tests.attack.fuzz_process TARGET DIR ..."""

import sys
from importlib import import_module
from pathlib import Path

import atheris

NAME, FOUND, *ARGUMENTS = sys.argv[1:]
LIBRARIES = {"tdms": ["nptdms"], "mdf": ["asammdf"], "can": ["can", "cantools"], "ros": ["rosbags"]}
"""What reads a format, by what its name begins with; h5py and pyarrow are no Python."""
GUIDES = LIBRARIES.get(NAME.partition("_")[0], [])

with atheris.instrument_imports(include=GUIDES or ["identification", "symbolic", "tomllib", "json"]):
    for guide in GUIDES:
        import_module("rosbags.highlevel" if guide == "rosbags" else guide)
    from tests.attack.fuzzing import broken_by
    from tests.attack.targets import TARGETS


def one_input(content: bytes) -> None:
    """Keeps the first input of each failure, and goes on."""
    place = broken_by(TARGETS[NAME], content)
    if place and not (path := Path(FOUND) / place).exists():
        path.write_bytes(content)


if __name__ == "__main__":
    atheris.Setup([sys.argv[0], *ARGUMENTS], one_input)
    atheris.Fuzz()
