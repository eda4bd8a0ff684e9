"""What generated code was made of, for a reader: parameters by name, with units."""

import json
from dataclasses import asdict
from typing import Any

from observers.embedded.scalar_type import Real
from observers.protocol import FunctionObserver
from symbolic.serialisation import units_of


def parameters_text(observer: FunctionObserver, real: Real, version: str) -> str:
    """JSON of model, values, rig, beliefs and settings; infinity stands as text."""
    units = units_of(observer.model)
    document = {
        "version": version,
        "observer": observer.name,
        "real": real.c_type,
        "effects": [effect.name for effect in observer.model.effects],
        "parameters": {n: {"value": v, "unit": units[n]} for n, v in observer.values.items()},
        "rig": {
            name: {"value": value, "unit": unit}
            for (name, value), unit in zip(
                asdict(observer.rig).items(), ("m", "m", "kg m^2", "N m s/rad"), strict=True
            )
        },
        **observer.settings,
    }
    return json.dumps(_plain(document), indent=2, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(part) for name, part in value.items()}
    return str(value) if value in (float("inf"), float("-inf")) else value
