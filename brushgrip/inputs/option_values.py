"""Numbers of the command line: the tuning of an observer, and limits, target and frictions of a plan."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from typing import Any, NamedTuple

from observers import SteeringLimits, Tuning, profile
from observers.tuning import TUNING_FIELDS
from symbolic import InvalidInputError, Vehicle
from symbolic.tables.toml_and_json_parsing import prefix_errors


class ChosenTuning(NamedTuple):
    """The profile that is named, or the usual one, and values that go before a model's error too."""

    profile: Tuning
    by_hand: Mapping[str, float]

    @property
    def tuning(self) -> Tuning:
        """Both, where no model states its error."""
        return replace(self.profile, **dict(self.by_hand))  # type: ignore[arg-type]

    def to_dict(self) -> dict[str, Any]:
        """As provenance tells it."""
        return {"tuning": asdict(self.tuning), "by_hand": sorted(self.by_hand)}


def key_value_texts(values: Sequence[str] | None) -> list[tuple[str, str, str]]:
    """Each pair of texts such as "angle=0.2,rate=0.5", with its name and what is behind the sign."""
    pairs = [pair.strip() for text in values or () for pair in text.split(",") if pair.strip()]
    parted = (pair.partition("=") for pair in pairs)
    return [
        (pair, name.strip(), text.strip()) for pair, (name, _, text) in zip(pairs, parted, strict=True)
    ]


def chosen_tuning(name: str | None, values: Sequence[str] | None) -> ChosenTuning | None:
    """The tuning by the name of a profile and texts such as "mu_walk=0.02,mu_std=0.2"; None for none."""
    pairs = key_value_texts(values)
    if name is None and not pairs:
        return None
    given: dict[str, float] = {}
    for pair, field, text in pairs:
        if field not in TUNING_FIELDS:
            allowed = ", ".join(TUNING_FIELDS)
            raise InvalidInputError(f"--tune {pair}: expected NAME=NUMBER with a name out of {allowed}")
        if field in given:
            raise InvalidInputError(f"--tune {pair}: {field} is given twice")
        given[field] = parse_number(f"--tune {pair}", text, whole=field == "reset_after")
    chosen = ChosenTuning(Tuning() if name is None else profile(name), given)
    with prefix_errors("--tune"):
        _ = chosen.tuning
    return chosen


def parse_number(where: str, text: str, *, whole: bool = False) -> float:
    """The number that an option gives."""
    try:
        return int(text) if whole else float(text)
    except ValueError:
        kind = "a whole number" if whole else "a number"
        raise InvalidInputError(f"{where}: expected {kind}, got {text!r}") from None


def chosen_limits(texts: Sequence[str] | None) -> SteeringLimits:
    """The limits that texts such as "angle=0.2,rate=0.5" set."""
    names, given = [field.name for field in fields(SteeringLimits)], {}
    for pair, name, text in key_value_texts(texts):
        if name not in names or name in given:
            raise InvalidInputError(
                f"--limit {pair}: expected NAME=NUMBER, each name once out of {', '.join(names)}"
            )
        given[name] = parse_number(f"--limit {pair}", text)
    with prefix_errors("--limit"):
        return SteeringLimits(**given)


def parse_share(text: str) -> float:
    """A share written as 5% or 0.05."""
    number = parse_number(f"--target {text}", text.strip().removesuffix("%"))
    return number / 100 if text.strip().endswith("%") else number


def parse_frictions(text: str) -> tuple[float, ...]:
    """Frictions separated by commas, in order [1]."""
    return tuple(sorted({parse_number(f"--mu {text}", part) for part in text.split(",")}))


def wheel_load(vehicle: Vehicle | None, load: float | None) -> float:
    """The load of a wheel [N]: that of a car is in its file, that of a rig has to be given."""
    if (vehicle is None) == (load is None):
        raise InvalidInputError(
            "--load is missing; name the vertical load in N"
            if load is None
            else "--load is that of a rig; that of a car is in its file, leave it out"
        )
    return vehicle.wheel_load if vehicle else float(load or 0)
