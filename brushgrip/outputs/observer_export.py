"""Observers written out as C, as an FMU or as a package of ROS 2, with their origin."""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from brushgrip.outputs.console import say
from observers import (
    AligningTorque,
    Ekf,
    FunctionObserver,
    MeasurementModel,
    Mhe,
    SteeringTorque,
    Tuning,
    car_observer,
    from_files,
    tuning_for,
)
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
from observers.interfaces.factory import read_rig_file, read_vehicle_file
from symbolic import InvalidInputError

KINDS: Mapping[str, type[Ekf] | type[Mhe]] = {"ekf": Ekf, "mhe": Mhe}
TYPES: Mapping[str, Real] = {"float": SINGLE, "double": DOUBLE}
MEASUREMENT_MODELS: Mapping[str, MeasurementModel] = {"M_z": AligningTorque(), "M": SteeringTorque()}
TUNABLE: Mapping[str, Tunable] = {"": "", "tuning": "tuning", "all": "all"}
MAX_WINDOW = 1000
"""Longest window [samples]; ten seconds at 100 Hz."""


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


def window_setting(observer: str, window: int | None) -> dict[str, int]:
    """The setting of an observer that `--window` makes; empty where it is not given."""
    if window is None:
        return {}
    if KINDS[observer] is not Mhe:
        raise InvalidInputError(
            f"--window is that of the MHE; allowed with --observer mhe, got {window}"
        )
    if not 1 <= window <= MAX_WINDOW:
        raise InvalidInputError(f"--window must be from 1 to {MAX_WINDOW} samples, got {window}")
    return {"window": window}


def state_bytes(files: Sequence[Path], name: str) -> int | None:
    """The size of a state that the header among generated files tells; None without a header."""
    for path in files:
        if path.name == f"{name}.h":
            told = re.search(r"One observer, (\d+) bytes", path.read_text(encoding="utf-8"))
            return int(told[1]) if told else None
    return None


def described_by(rig: Path | None, vehicle: Path | None) -> Path:
    """The file that describes the rig or the car."""
    if (described := vehicle if rig is None else rig) is None:
        raise InvalidInputError("--rig and --vehicle are both missing; name one of them")
    return described


def chosen_observer(
    kind: str, torque: str, *, rig: Path | None, vehicle: Path | None, **settings: Any
) -> ModelObserver:
    """The observer of a rig or of a car, with the settings of `observers.from_files`."""
    make = from_files if vehicle is None else build_car_observer
    described, measured = described_by(rig, vehicle), MEASUREMENT_MODELS[torque]
    made: ModelObserver = make(KINDS[kind], described, measurement_model=measured, **settings)
    return made


def build_car_observer(
    kind: Callable[..., Ekf | Mhe], vehicle: Path, model: Path | None, **settings: Any
) -> Ekf | Mhe:
    """The observer of a car, with the settings of `observers.from_files`."""
    if model is not None or settings.pop("ground") is not None:
        raise InvalidInputError("--model and --ground are of a wheel on a rig; leave them out")
    if not isinstance(settings.pop("measurement_model"), AligningTorque):
        raise InvalidInputError("--torque M is that of a wheel on a rig; leave it out")
    settings.pop("effects")
    tuning = tuning_for(None, settings.pop("tuning"), settings.pop("by_hand"), car=True)
    return car_observer(kind, read_vehicle_file(vehicle), tuning=tuning, **settings)


def prior_in_words(tuning: Tuning, rig: Path | None) -> str:
    """The prior in words, and that the rig file's friction is not it."""
    declared = None if rig is None else read_rig_file(rig)[1].mu
    text = (
        f"prior mu {tuning.mu:g} with standard deviation {tuning.mu_std:g}, a tenth of it spread evenly"
        " from ice on: until friction is acquired, mu and mu_std are of both"
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
        say(f"removed {description.name} of an earlier generation")
