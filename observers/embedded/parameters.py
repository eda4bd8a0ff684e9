"""What generated code was made of, for a reader: parameters by name, with units."""

import json
from dataclasses import asdict
from typing import Any

from observers.base import ModelObserver
from observers.embedded.origin import mark
from observers.embedded.scalar_type import Real
from symbolic import units_of


def parameters_text(observer: ModelObserver, real: Real, version: str) -> str:
    """JSON of model, values, rig, beliefs and settings; infinity stands as text."""
    units = units_of(observer.model)
    document = {
        "generated": mark(),
        "version": version,
        "observer": type(observer).__name__.lower(),
        "real": real.c_type,
        "sensing": type(observer.measurement_model).__name__,
        "states": list(observer.states),
        "effects": [effect.name for effect in observer.model.effects],
        "parameters": {n: {"value": v, "unit": units[n]} for n, v in observer.values.items()},
        "rig": {
            name: {"value": value, "unit": unit}
            for (name, value), unit in zip(
                asdict(observer.rig).items(), ("m", "m", "kg m^2", "N m s/rad"), strict=True
            )
        },
        "beliefs": asdict(observer.tuning),
        "settings": {n: getattr(observer, n) for n in ("iterations", "window") if hasattr(observer, n)},
    }
    return json.dumps(_plain(document), indent=2, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(part) for name, part in value.items()}
    return str(value) if value in (float("inf"), float("-inf")) else value
