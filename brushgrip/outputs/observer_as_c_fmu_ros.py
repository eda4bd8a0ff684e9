"""Observers written out as C, as an FMU or as a package of ROS 2, with their origin."""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from brushgrip.outputs.console import print_line
from observers import FunctionObserver
from observers.embedded import (
    DOUBLE,
    SINGLE,
    Real,
    Tunable,
    generate,
    generate_fmu,
    generate_ros2,
    require_replaceable,
)
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.observer_from_files import read_rig_file
from symbolic import InvalidInputError

TYPES: Mapping[str, Real] = {"float": SINGLE, "double": DOUBLE}
TUNABLE: Mapping[str, Tunable] = {"": "", "tuning": "tuning", "all": "all"}


def _fmu(
    version: int, observer: FunctionObserver, folder: Path, real: Real, *, name: str, tunable: Tunable
) -> list[Path]:
    return [generate_fmu(observer, folder, real, name=name, version=version, tunable=tunable)]


def _ros2(
    observer: FunctionObserver, folder: Path, real: Real, *, name: str, tunable: Tunable
) -> list[Path]:
    if tunable:
        raise InvalidInputError(
            "--tunable is for the targets c, fmu and fmu3; the node of ROS 2 has constants, got ros2"
        )
    return generate_ros2(observer, folder, real, name=name)


WRITERS: Mapping[str, Callable[..., list[Path]]] = {
    "c": generate,
    "fmu": partial(_fmu, 2),
    "fmu3": partial(_fmu, 3),
    "ros2": _ros2,
}
"""Writer of the files of each target."""


def state_size_from_header(files: Sequence[Path], name: str) -> int | None:
    """The size of a state that the header among generated files tells; None without a header."""
    for path in files:
        if path.name == f"{name}.h":
            told = re.search(r"One observer, (\d+) bytes", path.read_text(encoding="utf-8"))
            return int(told[1]) if told else None
    return None


def prior_in_words(observer: ModelObserver, rig: Path | None) -> str:
    """The prior in words, and that the rig file's friction is not it."""
    declared = None if rig is None else read_rig_file(rig)[1].mu
    tuning = observer.tuning
    text = f"prior mu {tuning.mu:g} with standard deviation {tuning.mu_std:g}, "
    text += (
        "a tenth of it spread evenly from ice on: until friction is acquired, mu and mu_std are of both"
        if observer.acquire
        else "from which friction is followed without acquisition: usable does not wait for it"
    )
    if declared is None or declared == tuning.mu:
        return text
    return f"{text}; the rig file's mu = {declared:g} is not used, --tune mu={declared:g} would be"


def append_origin(files: Sequence[Path], comment: str) -> None:
    """Adds a comment on what code was made from to the end of each source file."""
    for path in files:
        if path.suffix in (".c", ".h", ".hpp", ".cpp"):
            with path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(comment)


def remove_stale_description(description: Path, written: Sequence[Path]) -> None:
    """Removes the description of parameters of an earlier generation, which this one has not."""
    if description.is_file() and description.resolve() not in written:
        require_replaceable([description])
        description.unlink()
        print_line(f"removed {description.name} of an earlier generation")
