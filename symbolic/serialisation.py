"""A model that was found, from tables and to tables; SI units throughout.

A table is a mapping as the parser of JSON returns it. A message says what is wrong with the table; the
reader of the file puts its name before, see `symbolic.parsing.naming`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from symbolic.effects.base import Effect, parameter_name
from symbolic.effects.library import effects_named
from symbolic.errors import InvalidInputError
from symbolic.ground import mean_over_grounds
from symbolic.model import Model
from symbolic.model_error import ModelError
from symbolic.parameters import TOLERATED
from symbolic.parsing import excerpt, floats, naming, shown

MODEL_VERSION = 1
"""Version of the model files that are read and written."""


@dataclass(frozen=True, kw_only=True)
class FoundModel:
    """A model that a diagnosis found.

    Attributes:
        model: the structure.
        tyre: values that hold everywhere, by name, `k` among them where it belongs to no ground.
        own: values of the recordings of the diagnosis, by recording.
        grounds: values of each ground, by its name; empty where nothing belongs to a ground.
        rig: what became of the declared values that have a tolerance, by recording: `a`, `e`, `load`, a
            factor on the recorded load, and `zero`, that of the torque channel.
        error: how wrong the model is on recordings that it was not fitted to; None where unknown.
    """

    model: Model
    tyre: Mapping[str, float]
    own: Mapping[str, Mapping[str, float]]
    grounds: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    rig: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    error: ModelError | None = None

    def values_for(
        self, recording: str, mu: float | None = None, ground: str | None = None
    ) -> dict[str, float]:
        """All parameter values for a recording.

        A recording that the file does not know gets `mu` and the neutral value of whatever else
        belongs to a recording, as a torque zero. For grounds see `on_ground`.

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
        return {**self.values_for_estimation(ground), **own}

    def on_ground(self, ground: str | None = None) -> dict[str, float]:
        """What belongs to a ground; its mean over grounds where this is none of them, or unknown."""
        known = self.grounds.get(ground) if ground is not None else None
        return mean_over_grounds(self.grounds) if known is None else dict(known)

    def ground_taken(self, ground: str | None = None) -> str:
        """The ground whose values `on_ground` takes, in words; empty where nothing belongs to one."""
        if not self.grounds or ground in self.grounds:
            return f"values of {ground}" if self.grounds else ""
        known = " and ".join(self.grounds)
        return f"{'ground not given' if ground is None else f'{ground} is unknown'}: mean of {known}"

    def values_for_estimation(self, ground: str | None = None) -> dict[str, float]:
        """All parameter values but mu for a recording to come, as an observer needs them.

        Other parameters of a recording, such as a torque zero, have their neutral values. For grounds
        see `on_ground`.
        """
        neutral = {
            parameter_name(effect, parameter): parameter.neutral
            for effect, parameter in self.model.parameters
            if parameter.scope == "recording" and parameter.neutral is not None
        }
        values = {**self.tyre, **self.on_ground(ground)}
        return neutral | {name: value for name, value in values.items() if name != "mu"}


def units_of(model: Model) -> dict[str, str]:
    """The unit of every parameter of a model, by name."""
    return {parameter_name(effect, parameter): parameter.unit for effect, parameter in model.parameters}


def model_from_tables(document: object, effects: Iterable[Effect] = ()) -> FoundModel:
    """The model and its values from the tables of a model file.

    It holds `version`, `effects` (names), `tyre` (values by name; `shared` in older files), and may hold
    `grounds`, `recordings` and `rig` (a table of values for each ground or recording), `units` (by
    name), which must be those of the parameters: nothing is converted, and `model_error` (`spread`,
    `correlation_time`).

    Args:
        document: the tables.
        effects: effects beside the library's that the document may name.

    Raises:
        InvalidInputError: something is missing, unknown, in another unit, or out of range.
    """
    if not isinstance(document, dict) or document.get("version") != MODEL_VERSION:
        raise InvalidInputError(
            f"not a model file of version {MODEL_VERSION}, the model.json that diagnose writes"
        )
    model = Model(effects=_effects_from_tables(document, effects))
    parameters = {parameter_name(effect, parameter): parameter for effect, parameter in model.parameters}
    _check_units(document.get("units", {}), units_of(model))
    key = "shared" if "shared" in document and "tyre" not in document else "tyre"
    tyre = _numbers(key, document.get(key))
    grounds, own, rig = (_tables(document, name) for name in ("grounds", "recordings", "rig"))
    for place, table in {key: tyre, **grounds, **own}.items():
        _check_names(place, table, parameters, "the model has")
        for name, value in table.items():
            parameters[name].require_within(value, f"{place}.{name}")
    for place, table in rig.items():
        _check_names(place, table, TOLERATED, "allowed:")
    scopes = {"tyre": {key: tyre}, "ground": grounds or {"grounds": {}}, "recording": {}}
    for name, parameter in parameters.items():
        for place, table in scopes[parameter.scope].items():
            if name not in table:
                raise InvalidInputError(f"{place!r} lacks {name} [{parameter.unit}]")
    grounds, own, rig = (
        {place.split(".", 1)[1]: table for place, table in tables.items()}
        for tables in (grounds, own, rig)
    )
    error = _model_error(document)
    return FoundModel(model=model, tyre=tyre, own=own, grounds=grounds, rig=rig, error=error)


def _effects_from_tables(document: Mapping[str, Any], own: Iterable[Effect]) -> tuple[Effect, ...]:
    names = document.get("effects")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInputError("'effects' must be a list of effect names")
    return effects_named(names, own)


def _check_units(table: object, units: Mapping[str, str]) -> None:
    if not isinstance(table, dict):
        raise InvalidInputError("'units' must be a table of units, by parameter")
    _check_names("units", table, units, "the model has")
    for name, unit in table.items():
        if unit != units[name]:
            raise InvalidInputError(
                f"{name} has the unit {shown(unit)}, expected {units[name]!r}; convert the value"
            )


def _check_names(place: str, names: Iterable[str], allowed: Iterable[str], these_are: str) -> None:
    """Check that these names are allowed; the message goes on with those that are."""
    known = list(allowed)
    for name in names:
        if name not in known:
            raise InvalidInputError(
                f"{place} holds an unknown {excerpt(name)}; {these_are} {', '.join(known)}"
            )


def _tables(document: Mapping[str, Any], name: str) -> dict[str, dict[str, float]]:
    """The tables of a section, each under the name of the section and its own."""
    tables = document.get(name, {})
    if not isinstance(tables, dict):
        owner = "ground" if name == "grounds" else "recording"
        raise InvalidInputError(f"{name!r} must hold one table per {owner}")
    return {f"{name}.{each}": _numbers(f"{name}.{each}", table) for each, table in tables.items()}


def _numbers(place: str, table: object) -> dict[str, float]:
    if not isinstance(table, dict):
        raise InvalidInputError(f"{place!r} must be a table of numbers")
    return floats(place, table)


def _model_error(document: Mapping[str, Any]) -> ModelError | None:
    if document.get("model_error") is None:
        return None
    values = _numbers("model_error", document["model_error"])
    if not {"correlation_time", "spread"} <= set(values) <= {"correlation_time", "spread", "relative"}:
        raise InvalidInputError(
            "'model_error' must hold spread and correlation_time, and may hold relative, nothing else"
        )
    with naming("model_error"):
        return ModelError(**values)
