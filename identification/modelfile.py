"""`model.json`: a model that a diagnosis found, for simulation and observers."""

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from identification.fitting import parameter_name
from identification.results import Diagnosis
from symbolic import InvalidInputError, Model, Parameter, effects_named

VERSION = 1


@dataclass(frozen=True, kw_only=True)
class FoundModel:
    """A model from a file.

    Attributes:
        model: the structure.
        shared: values shared by all recordings, by name, `k` among them.
        own: values of the recordings that it was found on, by recording.
    """

    model: Model
    shared: Mapping[str, float]
    own: Mapping[str, Mapping[str, float]]

    def values_for(self, recording: str, mu: float | None = None) -> dict[str, float]:
        """All parameter values for a recording.

        A recording that the file does not know gets `mu` and the neutral value of whatever else
        belongs to a recording, as a torque zero.

        Raises:
            InvalidInputError: neither the file nor the caller gives mu.
        """
        own = dict(self.own.get(recording, {}))
        if mu is not None and "mu" not in own:
            own["mu"] = mu
        if "mu" not in own:
            raise InvalidInputError(
                f"{recording}: no mu in the model file for this recording and none in the rig;"
                " add mu under [tyre] of the rig file"
            )
        for effect, parameter in self.model.parameters:
            if parameter.scope == "recording" and parameter.neutral is not None:
                own.setdefault(parameter_name(effect, parameter), parameter.neutral)
        return {**self.shared, **own}


def model_text(diagnosis: Diagnosis) -> str:
    """The content of `model.json` for a diagnosis."""
    content = {
        "version": VERSION,
        "effects": [effect.name for effect in diagnosis.model.effects],
        "shared": _writable(diagnosis.values.shared),
        "recordings": {name: _writable(values) for name, values in diagnosis.values.own.items()},
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _writable(values: Mapping[str, float]) -> dict[str, float]:
    """Values as JSON can hold them: an infinite stiffness becomes the largest number there is."""
    return {name: min(value, sys.float_info.max) for name, value in values.items()}


def read_model(path: Path) -> FoundModel:
    """Read a model file.

    Raises:
        InvalidInputError: the file is missing, no JSON, or lacks something; one line says what.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InvalidInputError(f"{path}: not a JSON file: {error}") from None
    if not isinstance(content, dict) or content.get("version") != VERSION:
        raise InvalidInputError(f"{path}: not a model file of version {VERSION}, as diagnose writes it")
    names = content.get("effects")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInputError(f"{path}: 'effects' must be a list of effect names")
    try:
        model = Model(effects=effects_named(names))
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None
    shared = _numbers(path, "shared", content.get("shared"))
    recordings = content.get("recordings", {})
    if not isinstance(recordings, dict):
        raise InvalidInputError(f"{path}: 'recordings' must hold one table per recording")
    own = {name: _numbers(path, f"recordings.{name}", table) for name, table in recordings.items()}
    for effect, parameter in model.parameters:
        name = parameter_name(effect, parameter)
        if parameter.scope == "shared" and name not in shared:
            raise InvalidInputError(f"{path}: 'shared' lacks {name} [{parameter.unit}]")
    allowed = {parameter_name(effect, parameter): parameter for effect, parameter in model.parameters}
    for place, table in {"shared": shared, **{f"recordings.{n}": v for n, v in own.items()}}.items():
        _check_range(path, place, table, allowed)
    return FoundModel(model=model, shared=shared, own=own)


def _check_range(
    path: Path, place: str, table: Mapping[str, float], allowed: Mapping[str, Parameter]
) -> None:
    for name, value in table.items():
        if name not in allowed:
            raise InvalidInputError(
                f"{path}: {place} holds an unknown {name!r}; the model has {', '.join(allowed)}"
            )
        parameter = allowed[name]
        if not parameter.lower <= value <= parameter.upper:
            raise InvalidInputError(
                f"{path}: {place}.{name} must lie in [{parameter.lower}, {parameter.upper}]"
                f" {parameter.unit}, got {value}"
            )


def _numbers(path: Path, place: str, table: Any) -> dict[str, float]:
    if not isinstance(table, dict):
        raise InvalidInputError(f"{path}: {place!r} must be a table of numbers")
    for name, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidInputError(f"{path}: {place}.{name} must be a number, got {value!r}")
    try:
        return {name: float(value) for name, value in table.items()}
    except OverflowError:
        raise InvalidInputError(f"{path}: {place} holds a number too large to compute with") from None
