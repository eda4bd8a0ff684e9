"""Rig and tyre from tables; SI units throughout.

A table is a mapping as the parser of TOML returns it. A message says what is wrong with the table; the
reader of the file puts its name before, see `symbolic.tables.toml_and_json_parsing.prefix_errors`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from symbolic.errors import InvalidInputError
from symbolic.rig_and_tyre import TOLERATED, Rig, Tolerances, Tyre
from symbolic.tables.toml_and_json_parsing import absolute_tolerance, excerpt, floats, require_number

RIG_KEYS = {
    "rig": {"a": "half-length", "e": "caster", "J_A": "inertia", "b_t": "damping", "slide_rate": ""},
    "sensor": {"noise": "", "dry_friction": "", "range": ""},
    "tyre": {"k": "stiffness per length", "mu": "friction"},
}
"""Sections of a rig file and their keys, with words where a key is a symbol."""
REQUIRED_KEYS = {"rig": ("a", "e"), "sensor": (), "tyre": ("k",)}
"""Keys that a rig file must have."""
NEUTRAL = {"load": 1.0, "zero": 0.0}
"""Quantities with a tolerance alone: a factor on the recorded load [1], the zero of the torque [N m]."""
ALLOWED = RIG_KEYS | {"rig": RIG_KEYS["rig"] | dict.fromkeys(NEUTRAL, "tolerance")}
"""Sections of a rig file and what may stand in them, tolerances alone included."""
SIGNALS = "signals"
"""Section of a rig file that says how channels are called; it is for those who read recordings."""
_MAX_LENGTH = 1.0
"""Largest length of a rig [m]; a larger number was given in millimetres."""


def rig_from_tables(document: Mapping[str, object]) -> tuple[Rig, Tyre]:
    """Rig and tyre from ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu``; J_A, b_t and mu are optional.

    a, e and k may be tables ``{value = 0.045, tolerance = 0.0025}``, and so may ``load`` and ``zero``
    of the rig, whose value, if given, is 1 and 0: see `Tolerances`. A tolerance ``"20%"`` is that share
    of the value. ``[sensor] noise, dry_friction, range`` are optional too, see `Rig`.

    Raises:
        InvalidInputError: a section or key is missing or unknown, a value is not a number within its
            range, or a length is one in millimetres.
    """
    refuse_unknown_sections(document, ("rig", "tyre", "sensor", SIGNALS))
    rig, tolerances = _section_values_and_tolerances("rig", document.get("rig"))
    tyre, of_tyre = _section_values_and_tolerances("tyre", document.get("tyre"))
    tolerances |= of_tyre
    if isinstance(rig, dict):
        for name, neutral in NEUTRAL.items():
            if rig.pop(name, neutral) != neutral:
                raise InvalidInputError(
                    f"[rig] {name} must have the value {neutral:g}: it has a tolerance alone;"
                    " correct the recordings instead"
                )
    values = _checked_section_numbers("rig", rig) | _checked_section_numbers("tyre", tyre)
    values |= _checked_section_numbers("sensor", document.get("sensor", {}))
    return rig_and_tyre(values, tolerances=tolerances)


def refuse_unknown_sections(document: Mapping[str, object], sections: Sequence[str]) -> None:
    """Refuse a file with a section beside these."""
    for name in document:
        if name not in sections:
            allowed = ", ".join(f"[{section}]" for section in sections)
            raise InvalidInputError(f"unknown section or key {excerpt(name)}; allowed: {allowed}")


def _section_values_and_tolerances(part: str, section: object) -> tuple[Any, dict[str, float]]:
    """A section with values alone, and the tolerances that stood beside them."""
    if not isinstance(section, dict):
        return section, {}
    allowed = [name for name in TOLERATED if (name == "k") == (part == "tyre")]
    pairs = {
        n: _entry_value_and_tolerance(part, n, value) for n, value in section.items() if n in allowed
    }
    tolerances = floats(f"[{part}]", {n: t for n, (_, t) in pairs.items() if t is not None})
    return section | {name: value for name, (value, _) in pairs.items()}, tolerances


def _entry_value_and_tolerance(part: str, name: str, entry: object) -> tuple[Any, Any]:
    """The value of an entry and its tolerance, None where it has none."""
    if not isinstance(entry, dict):
        return entry, None
    allowed = ("tolerance",) if name in NEUTRAL else ("value", "tolerance")
    if unknown := sorted(set(entry) - {"value", "tolerance"}):
        raise InvalidInputError(
            f"[{part}] {name} holds an unknown {excerpt(unknown[0])}; allowed: value, tolerance"
        )
    for key in allowed:
        if key not in entry:
            raise InvalidInputError(
                f"[{part}] {name} lacks its {key}; write {{ {' = ..., '.join(allowed)} = ... }}"
            )
    value = entry.get("value", NEUTRAL.get(name))
    tolerance = absolute_tolerance(entry["tolerance"], value)
    for key, number in (entry | {"tolerance": tolerance}).items():
        require_number(f"[{part}] {name}: its {key}", number)
    return value, tolerance


def rig_and_tyre(
    values: Mapping[str, float],
    nominal: tuple[Rig, Tyre] | None = None,
    tolerances: Mapping[str, float] | None = None,
) -> tuple[Rig, Tyre]:
    """Rig and tyre from values out of `RIG_KEYS` by name.

    They override those of the nominal ones, of which only `REQUIRED_KEYS` must be known, and tolerances
    out of `TOLERATED` those of the nominal rig. A value outside its range, or a length in millimetres,
    is refused; the message begins with its name.
    """
    for name in ("a", "e"):
        if _MAX_LENGTH < abs(values.get(name, 0.0)) < math.inf:
            raise InvalidInputError(
                f"{name} must be given in metres, at most {_MAX_LENGTH:g} m in size, got"
                f" {values[name]:g}; if these are millimetres, write {values[name] / 1000:g}"
            )
    known: dict[str, Any] = {} if nominal is None else vars(nominal[0]) | vars(nominal[1])
    known = {**known, **values}
    rig, tyre, sensor = (
        {key: known[key] for key in RIG_KEYS[part] if key in known} for part in ("rig", "tyre", "sensor")
    )
    within = replace(known.get("tolerances", Tolerances()), **(tolerances or {}))
    return Rig(**rig, **sensor, tolerances=within), Tyre(**tyre)


def _checked_section_numbers(name: str, section: object) -> dict[str, float]:
    allowed = ", ".join(f"{key} ({words})" if words else key for key, words in ALLOWED[name].items())
    if not isinstance(section, dict):
        raise InvalidInputError(f"section [{name}] is missing; it holds {allowed}")
    for key in section:
        if key not in RIG_KEYS[name]:
            hint = "".join(f", which belongs to [{one}]" for one, keys in ALLOWED.items() if key in keys)
            raise InvalidInputError(f"[{name}] unknown key {excerpt(key)}{hint}; allowed: {allowed}")
    numbers = floats(f"[{name}]", section, "{place} {name}")
    for key in REQUIRED_KEYS[name]:
        if key not in section:
            raise InvalidInputError(
                f"[{name}] {key} is missing; required: {', '.join(REQUIRED_KEYS[name])}"
            )
    return numbers
