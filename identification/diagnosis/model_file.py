"""`model.json`: a model that a diagnosis found, for simulation and observers."""

import json
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from identification.diagnosis.result import Diagnosis
from identification.reading.checked_file_reading import read_bytes
from symbolic import Effect, FoundModel, model_from_tables, units_of
from symbolic.tables.found_model_from_tables import MODEL_VERSION
from symbolic.tables.toml_and_json_parsing import MAX_MODEL_SIZE, parse_json, prefix_errors


def model_text(diagnosis: Diagnosis) -> str:
    """The content of `model.json` for a diagnosis."""
    content: dict[str, Any] = {
        "version": MODEL_VERSION,
        "effects": [effect.name for effect in diagnosis.model.effects],
        "tyre": _finite_values_for_json(diagnosis.values.tyre),
        "grounds": _finite_value_tables(diagnosis.values.grounds),
        "recordings": _finite_value_tables(diagnosis.values.own),
        "rig": _finite_value_tables(diagnosis.values.rig),
        "units": units_of(diagnosis.model),
    }
    if diagnosis.model_error is not None:
        error = asdict(diagnosis.model_error)
        content["model_error"] = {name: value for name, value in error.items() if value is not None}
    content["basis"] = {n: value for n, value in asdict(diagnosis.basis).items() if value is not None}
    if (k := diagnosis.parameters.get("k")) is not None and k.std is not None:
        content["std"] = {"k": k.std}
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _finite_value_tables(values: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    return {name: _finite_values_for_json(own) for name, own in values.items()}


def _finite_values_for_json(values: Mapping[str, float]) -> dict[str, float]:
    """Values for JSON, which has no infinity: an infinite stiffness becomes the largest number."""
    return {name: min(value, sys.float_info.max) for name, value in values.items()}


def read_model(path: str | Path, effects: Iterable[Effect] = ()) -> FoundModel:
    """Read a model file, which may name these effects beside the library's.

    Raises:
        InvalidInputError: the file is missing, no JSON, or lacks something; one line says what.
    """
    content = read_bytes(Path(path), MAX_MODEL_SIZE)
    with prefix_errors(path):
        return model_from_tables(parse_json(content), effects)
