"""Limits, target, frictions and load of a plan as the command line says them."""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from brushgrip.inputs.tunings import named_texts, number_of
from observers import SteeringLimits
from observers.interfaces.factory import read_vehicle_file
from symbolic import InvalidInputError


def chosen_limits(texts: Sequence[str] | None) -> SteeringLimits:
    """The limits that texts such as "angle=0.2,rate=0.5" set."""
    names, given = [field.name for field in fields(SteeringLimits)], {}
    for pair, name, text in named_texts(texts):
        if name not in names or name in given:
            raise InvalidInputError(
                f"--limit {pair}: expected NAME=NUMBER, each name once out of {', '.join(names)}"
            )
        given[name] = number_of(f"--limit {pair}", text)
    try:
        return SteeringLimits(**given)
    except InvalidInputError as error:
        raise InvalidInputError(f"--limit: {error}") from None


def share_of(text: str) -> float:
    """A share written as 5% or 0.05."""
    number = number_of(f"--target {text}", text.strip().removesuffix("%"))
    return number / 100 if text.strip().endswith("%") else number


def frictions_of(text: str) -> tuple[float, ...]:
    """Frictions separated by commas, in order [1]."""
    return tuple(sorted({number_of(f"--mu {text}", part) for part in text.split(",")}))


def load_of(vehicle: Path | None, load: float | None) -> float:
    """The load of a wheel [N]: that of a car is in its file, that of a rig has to be given."""
    if (vehicle is None) == (load is None):
        raise InvalidInputError(
            "--load is missing; name the vertical load in N"
            if load is None
            else "--load is that of a rig; that of a car is in its file, leave it out"
        )
    return read_vehicle_file(vehicle).wheel_load if load is None and vehicle else float(load or 0)
