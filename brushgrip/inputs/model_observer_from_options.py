"""The observer of a rig or of a car that a command line names, to be written as C or to plan with."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from brushgrip.inputs.command_inputs import Inputs
from brushgrip.inputs.option_values import ChosenTuning
from observers import AligningTorque, Ekf, Mhe, SteeringTorque, car_observer, from_files, tuning_for
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.observer_from_files import read_vehicle_file
from symbolic import InvalidInputError

KINDS: Mapping[str, type[Ekf] | type[Mhe]] = {"ekf": Ekf, "mhe": Mhe}
MAX_WINDOW = 1000
"""Longest window [samples]; ten seconds at 100 Hz."""


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


def rig_or_vehicle_file(inputs: Inputs) -> Path:
    """The file that describes the rig or the car."""
    if (described := inputs.rig or inputs.vehicle) is None:
        raise InvalidInputError("--rig and --vehicle are both missing; name one of them")
    return described


def model_observer_from_options(
    name: str,
    torque: str,
    inputs: Inputs,
    chosen: ChosenTuning | None,
    ground: str | None = None,
    *,
    stiffness_state: bool | None = None,
    **settings: Any,
) -> ModelObserver:
    """The observer of this name for a torque, "M_z" or "M"; settings are further fields of it."""
    if stiffness_state and (inputs.vehicle is not None or torque != "M_z"):
        raise InvalidInputError("--stiffness-state needs M_z of a wheel on a rig; leave it out")
    kind, described, (tuning, by_hand) = KINDS[name], rig_or_vehicle_file(inputs), chosen or (None, None)
    if inputs.vehicle is None:
        if torque != "M_z":
            settings["measurement_model"] = SteeringTorque()
        elif stiffness_state is not None:
            settings["measurement_model"] = AligningTorque(stiffness=stiffness_state)
        return from_files(
            kind, described, inputs.model, effects=inputs.effects, ground=ground, tuning=tuning,
            by_hand=by_hand, **settings,
        )  # fmt: skip
    if ground is not None:
        raise InvalidInputError("--model and --ground are of a wheel on a rig; leave them out")
    if torque != "M_z":
        raise InvalidInputError("--torque M is that of a wheel on a rig; leave it out")
    tuning = tuning_for(None, tuning, by_hand, car=True)
    return car_observer(kind, read_vehicle_file(described), tuning=tuning, **settings)
