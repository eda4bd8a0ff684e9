"""A model that was found, from tables as the parser of JSON returns them; SI units throughout."""

from collections.abc import Iterable, Mapping
from typing import Any

from symbolic.effects.base import Effect, parameter_name
from symbolic.effects.library import effects_named
from symbolic.errors import InvalidInputError
from symbolic.model import Model
from symbolic.rig_and_tyre import TOLERATED
from symbolic.tables.found_model import FoundModel, ModelBasis, ModelError, units_of
from symbolic.tables.toml_and_json_parsing import excerpt, floats, prefix_errors, quoted_value

MODEL_VERSION = 1
"""Version of the model files that are read and written."""
LOADS = ("least", "greatest")
"""Order of the loads of a basis."""


def model_from_tables(document: object, effects: Iterable[Effect] = ()) -> FoundModel:
    """The model and its values from the tables of a model file.

    It holds `version`, `effects` (names), `tyre` (values by name; `shared` in older files), and may hold
    `grounds`, `recordings` and `rig` (a table of values for each ground or recording), `units` (by
    name), which must be those of the parameters: nothing is converted, `model_error` (`spread`,
    `correlation_time`), `basis` (`training`, `holdout`, `grades`, `loads`), and `std` (that of `k`).

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
    names = document.get("effects")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInputError("'effects' must be a list of effect names")
    model = Model(effects=effects_named(names, effects))
    parameters = {parameter_name(effect, parameter): parameter for effect, parameter in model.parameters}
    _check_units(document.get("units", {}), units_of(model))
    key = "shared" if "shared" in document and "tyre" not in document else "tyre"
    tyre = _number_table(key, document.get(key))
    grounds, own, rig = (_tables_of_section(document, name) for name in ("grounds", "recordings", "rig"))
    for place, table in {key: tyre, **grounds, **own}.items():
        _check_names(place, table, parameters, "the model has")
        for name, value in table.items():
            parameters[name].require_within(value, f"{place}.{name}")
    for place, table in rig.items():
        _check_names(place, table, TOLERATED, "allowed:")
    scopes = {"tyre": {key: tyre}, "ground": grounds or {"grounds": {}}, "recording": {}}
    for name, parameter in parameters.items():
        for place, table in scopes[parameter.scope].items():
            # A file may give one value for all grounds.
            if name not in table and not (parameter.scope == "ground" and name in tyre):
                raise InvalidInputError(f"{place!r} lacks {name} [{parameter.unit}]")
    grounds, own, rig = (
        {place.split(".", 1)[1]: table for place, table in tables.items()}
        for tables in (grounds, own, rig)
    )
    error, basis = _parse_model_error(document), _parse_model_basis(document)
    std = _number_table("std", document.get("std", {}))
    _check_names("std", std, {"k"} & set(tyre), "allowed:")
    return FoundModel(
        model=model, tyre=tyre, own=own, grounds=grounds, rig=rig, error=error, basis=basis,
        k_std=std.get("k"),
    )  # fmt: skip


def _check_units(table: object, units: Mapping[str, str]) -> None:
    if not isinstance(table, dict):
        raise InvalidInputError("'units' must be a table of units, by parameter")
    _check_names("units", table, units, "the model has")
    for name, unit in table.items():
        if unit != units[name]:
            raise InvalidInputError(
                f"{name} has the unit {quoted_value(unit)}, expected {units[name]!r}; convert the value"
            )


def _check_names(place: str, names: Iterable[str], allowed: Iterable[str], these_are: str) -> None:
    """Check that these names are allowed; the message goes on with those that are."""
    known = list(allowed)
    for name in names:
        if name not in known:
            raise InvalidInputError(
                f"{place} holds an unknown {excerpt(name)}; {these_are} {', '.join(known)}"
            )


def _tables_of_section(document: Mapping[str, Any], name: str) -> dict[str, dict[str, float]]:
    """The tables of a section, each under the name of the section and its own."""
    tables = document.get(name, {})
    if not isinstance(tables, dict):
        owner = "ground" if name == "grounds" else "recording"
        raise InvalidInputError(f"{name!r} must hold one table per {owner}")
    return {f"{name}.{each}": _number_table(f"{name}.{each}", table) for each, table in tables.items()}


def _number_table(place: str, table: object) -> dict[str, float]:
    if not isinstance(table, dict):
        raise InvalidInputError(f"{place!r} must be a table of numbers")
    return floats(place, table)


def _parse_model_error(document: Mapping[str, Any]) -> ModelError | None:
    if document.get("model_error") is None:
        return None
    values = _number_table("model_error", document["model_error"])
    required, further = {"correlation_time", "spread"}, {"relative", "friction_walk"}
    if not required <= set(values) <= required | further:
        raise InvalidInputError(
            "'model_error' must hold spread and correlation_time, and may hold relative and"
            " friction_walk, nothing else"
        )
    with prefix_errors("model_error"):
        return ModelError(**values)


def _parse_model_basis(document: Mapping[str, Any]) -> ModelBasis | None:
    table = document.get("basis")
    if table is None:
        return None
    required = {"training", "holdout", "grades"}
    if not isinstance(table, dict) or not required <= set(table) <= required | {"unexplained", "loads"}:
        raise InvalidInputError(
            "'basis' must hold training, holdout and grades, and may hold unexplained and loads, nothing"
            " else"
        )
    if not isinstance(table.get("unexplained", False), bool):
        raise InvalidInputError("'basis.unexplained' must be true or false")
    grades = table["grades"]
    if not isinstance(grades, dict) or not all(isinstance(grade, str) for grade in grades.values()):
        raise InvalidInputError("'basis.grades' must be a table of texts")
    _check_names("basis.grades", grades, document["effects"], "the model has")
    loads = table.get("loads")
    if loads is not None and not (isinstance(loads, list) and len(loads) == len(LOADS)):
        raise InvalidInputError("'basis.loads' must be a list of two numbers")
    named = None if loads is None else floats("basis.loads", dict(zip(LOADS, loads, strict=True)))
    with prefix_errors("basis"):
        return ModelBasis(**{**table, "loads": named and (named["least"], named["greatest"])})
