"""Rig, tyre and model from tables and to tables; SI units throughout.

A table is a mapping as the parsers of TOML and JSON return it. A message says what is wrong with the
table; the reader of the file puts its name before, see `symbolic.parsing.naming`.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from symbolic.effects.base import Effect, Parameter
from symbolic.effects.library import effects_named
from symbolic.errors import InvalidInputError
from symbolic.model import Model
from symbolic.parameters import Rig, Tyre
from symbolic.parsing import excerpt

RIG_KEYS = {"rig": ("a", "e", "J_A", "b_t"), "tyre": ("k", "mu")}
"""Sections of a rig file and their keys."""
REQUIRED_KEYS = {"rig": ("a", "e"), "tyre": ("k",)}
"""Keys that a rig file must have."""
MODEL_VERSION = 1
"""Version of the model files that are read and written."""
_LONGEST = 1.0
"""Largest length of a rig [m]; a larger number was given in millimetres."""


def rig_from_tables(document: Mapping[str, object]) -> tuple[Rig, Tyre]:
    """Rig and tyre from ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu``; J_A, b_t and mu are optional.

    Raises:
        InvalidInputError: a section or key is missing or unknown, a value is not a number within its
            range, or a length is one in millimetres.
    """
    unknown = [name for name in document if name not in RIG_KEYS]
    if unknown:
        raise InvalidInputError(f"unknown section or key {excerpt(unknown[0])}; allowed: [rig], [tyre]")
    return rig_from_values(_section(document, "rig") | _section(document, "tyre"))


def rig_from_values(
    values: Mapping[str, float], nominal: tuple[Rig, Tyre] | None = None
) -> tuple[Rig, Tyre]:
    """Rig and tyre from values by name; missing values are taken from the nominal ones.

    Args:
        values: out of `RIG_KEYS`; with the nominal ones, those of `REQUIRED_KEYS` must be known.
        nominal: rig and tyre that the values go before; None for none.

    Raises:
        InvalidInputError: a value is outside its range, or a length is one in millimetres; the message
            begins with the name of the value.
    """
    for name in ("a", "e"):
        if _LONGEST < abs(values.get(name, 0.0)) < math.inf:
            raise InvalidInputError(
                f"{name} must be given in metres, at most {_LONGEST:g} m in size, got"
                f" {values[name]:g}; if these are millimetres, write {values[name] / 1000:g}"
            )
    known: dict[str, Any] = {} if nominal is None else asdict(nominal[0]) | asdict(nominal[1])
    known |= values
    rig, tyre = ({key: known[key] for key in RIG_KEYS[part] if key in known} for part in ("rig", "tyre"))
    return Rig(**rig), Tyre(**tyre)


def _section(document: Mapping[str, object], name: str) -> dict[str, float]:
    allowed = ", ".join(RIG_KEYS[name])
    section = document.get(name)
    if not isinstance(section, dict):
        raise InvalidInputError(f"section [{name}] is missing; it holds {allowed}")
    for key, value in section.items():
        if key not in RIG_KEYS[name]:
            raise InvalidInputError(f"[{name}] unknown key {excerpt(key)}; allowed: {allowed}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidInputError(f"[{name}] {key} must be a number, got {excerpt(str(value))}")
    for key in REQUIRED_KEYS[name]:
        if key not in section:
            raise InvalidInputError(
                f"[{name}] {key} is missing; required: {', '.join(REQUIRED_KEYS[name])}"
            )
    return _floats(f"[{name}]", section)


@dataclass(frozen=True, kw_only=True)
class FoundModel:
    """A model that a diagnosis found.

    Attributes:
        model: the structure.
        shared: values shared by all recordings, by name, `k` among them.
        own: values of the recordings of the diagnosis, by recording.
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
        return {**self.values_for_estimation(), **own}

    def model_for_estimation(self) -> Model:
        """The model for an observer: discretised where a compliance is in series with the patch.

        Behind a compliance the memory of the exact patch follows a changing mu badly.
        """
        return self.model if self.model.deflection is None else replace(self.model, discretised=True)

    def values_for_estimation(self) -> dict[str, float]:
        """All parameter values but mu for a recording to come, as an observer needs them.

        Other parameters of a recording, such as a torque zero, have their neutral values.
        """
        neutral = {
            parameter_name(effect, parameter): parameter.neutral
            for effect, parameter in self.model.parameters
            if parameter.scope == "recording" and parameter.neutral is not None
        }
        return neutral | {name: value for name, value in self.shared.items() if name != "mu"}


def parameter_name(effect: Effect | None, parameter: Parameter) -> str:
    """The name of a parameter in files: `mu`, `k`, or `effect.parameter`."""
    return f"{effect.name}.{parameter.name}" if effect else parameter.name


def units_of(model: Model) -> dict[str, str]:
    """The unit of every parameter of a model, by name."""
    return {parameter_name(effect, parameter): parameter.unit for effect, parameter in model.parameters}


def model_from_tables(document: object, effects: Iterable[Effect] = ()) -> FoundModel:
    """The model and its values from the tables of a model file.

    It holds `version`, `effects` (names), `shared` (values by name), and may hold `recordings` (a table
    of values each) and `units` (by name), which must be those of the parameters: nothing is converted.

    Args:
        document: the tables.
        effects: effects beside the library's that the document may name.

    Raises:
        InvalidInputError: something is missing, unknown, in another unit, or out of range.
    """
    if not isinstance(document, dict) or document.get("version") != MODEL_VERSION:
        raise InvalidInputError(f"not a model file of version {MODEL_VERSION}, as diagnose writes it")
    model = Model(effects=_effects_from_tables(document, effects))
    _check_units(document.get("units", {}), units_of(model))
    recordings = document.get("recordings", {})
    if not isinstance(recordings, dict):
        raise InvalidInputError("'recordings' must hold one table per recording")
    shared = _numbers("shared", document.get("shared"))
    own = {name: _numbers(f"recordings.{name}", table) for name, table in recordings.items()}
    allowed = {parameter_name(effect, parameter): parameter for effect, parameter in model.parameters}
    for name, parameter in allowed.items():
        if parameter.scope == "shared" and name not in shared:
            raise InvalidInputError(f"'shared' lacks {name} [{parameter.unit}]")
    for place, table in {"shared": shared, **{f"recordings.{n}": v for n, v in own.items()}}.items():
        _check_range(place, table, allowed)
    return FoundModel(model=model, shared=shared, own=own)


def _effects_from_tables(document: Mapping[str, Any], own: Iterable[Effect]) -> tuple[Effect, ...]:
    names = document.get("effects")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInputError("'effects' must be a list of effect names")
    return effects_named(names, own)


def _check_units(table: object, units: Mapping[str, str]) -> None:
    if not isinstance(table, dict):
        raise InvalidInputError("'units' must be a table of units, by parameter")
    for name, unit in table.items():
        if name not in units:
            raise InvalidInputError(f"units holds an unknown {name!r}; the model has {', '.join(units)}")
        if unit != units[name]:
            raise InvalidInputError(
                f"{name} has the unit {excerpt(str(unit))}, expected {units[name]!r}; convert the value"
            )


def _check_range(place: str, table: Mapping[str, float], allowed: Mapping[str, Parameter]) -> None:
    for name, value in table.items():
        if name not in allowed:
            raise InvalidInputError(
                f"{place} holds an unknown {name!r}; the model has {', '.join(allowed)}"
            )
        parameter = allowed[name]
        if not parameter.lower <= value <= parameter.upper:
            raise InvalidInputError(
                f"{place}.{name} must lie in [{parameter.lower}, {parameter.upper}]"
                f" {parameter.unit}, got {value}"
            )


def _numbers(place: str, table: object) -> dict[str, float]:
    if not isinstance(table, dict):
        raise InvalidInputError(f"{place!r} must be a table of numbers")
    for name, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidInputError(f"{place}.{name} must be a number, got {value!r}")
    return _floats(place, table)


def _floats(place: str, table: Mapping[str, int | float]) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in table.items()}
    except OverflowError:
        raise InvalidInputError(f"{place} holds a number too large to compute with") from None
