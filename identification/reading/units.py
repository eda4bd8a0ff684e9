"""Units in which a column of a recording may be given, and their factors to SI."""

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError
from symbolic.tables.toml_and_json_parsing import excerpt

_TORQUE = {
    "N m": 1.0,
    "mN m": 1e-3,
    "N mm": 1e-3,
    "cN m": 1e-2,
    "N cm": 1e-2,
    "kN m": 1e3,
    "lbf ft": 1.3558179483314004,
    "lbf in": 0.1129848290276167,
}
UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "psi": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "rev": 2 * math.pi},
    "psi_dot": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.pi / 180, "rpm": math.pi / 30},
    "F_N": {"N": 1.0, "daN": 10.0, "kN": 1e3, "kgf": 9.80665, "lbf": 4.4482216152605},
    "M_z": _TORQUE,
    "M": _TORQUE,
    "rack": {"m": 1.0, "mm": 1e-3, "cm": 1e-2},
    "handwheel": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "rev": 2 * math.pi},
    "F_rack": {"N": 1.0, "daN": 10.0, "kN": 1e3},
    "T_bar": _TORQUE,
    "T_motor": _TORQUE,
    "brake": {"1": 1.0},
    "speed": {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704},
}
"""Factor of each unit to SI, by column; the first is the SI unit."""
OF_SIZE = {
    "rack": (0.15, "mm"),
    "handwheel": (20.0, "deg"),
    "T_bar": (150.0, "mN m"),
    "T_motor": (150.0, "mN m"),
}
"""Car columns: magnitude in SI that none reaches, and the unit to suspect where it is exceeded."""
MIN_RACK_FORCE = 30.0
"""Least force that moves a rack: its gear's friction alone is more [N]."""
IN_UNIT = 10
"""Samples beyond that are no glitches any more."""
_WITH_UNIT = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*")
_UNIT_WORDS = {
    "sec": "s", "second": "s", "seconds": "s", "sekunden": "s", "msec": "ms", "millisecond": "ms",
    "milliseconds": "ms", "microseconds": "us", "degree": "deg", "degrees": "deg", "grad": "deg",
    "radian": "rad", "radians": "rad", "degps": "deg/s", "radps": "rad/s", "1/min": "rpm",
    "newton": "N", "newtonmeter": "N m", "newtonmetre": "N m", "lb": "lbf", "ftlb": "lbf ft",
    "ftlbf": "lbf ft", "lbft": "lbf ft", "inlb": "lbf in", "lbin": "lbf in",
}  # fmt: skip
"""What else units are called, in lower case and without blanks."""
_NO_UNIT = ("", "-", "1")
UNSURE_AT_END = ("min", "h", "rev", "grad", "lb")
"""What ends a name without being its unit, too: a minimum, reversed, a gradient, a lower bound."""
_SIGNS = str.maketrans({"°": "deg", "º": "deg", "µ": "u", "μ": "u", **dict.fromkeys(" *.·⋅", "")})


def factor_of(column: str, unit: str) -> float | None:
    """The factor to SI of a unit such as `°` or `[Nm]`, 1 for none; None if the column has none such."""
    bare, *_ = _strip_unit_brackets(unit).split(
        " since "
    )  # times of CF conventions are counted from an instant
    if bare in _NO_UNIT:
        return 1.0
    known = {name.replace(" ", ""): factor for name, factor in UNITS[column].items()}
    text = bare.translate(_SIGNS)
    if text not in known and not _UNIT_WORDS.get(text.lower()):
        text = bare.removeprefix("in ").translate(_SIGNS)  # a heading such as `Zeit (in ms)`
    word = _UNIT_WORDS.get(text.lower(), "").replace(" ", "")
    # Upper case matters where a letter is a prefix: MN m is no mN m.
    relaxed = text.lower() if column in ("psi", "psi_dot") or text in ("S", "Sec") else text
    return next((known[name] for name in (text, word, relaxed) if name in known), None)


def car_unit_by_size(column: str, values: NDArray[np.float64]) -> str:
    """The unit suggested by the size of a car column's numbers; empty if they are plausible in SI."""
    sizes = np.sort(np.abs(values[np.isfinite(values)]))
    if sizes.size < IN_UNIT:
        return ""
    if column == "F_rack":
        return "kN" if 0 < sizes[-1] < MIN_RACK_FORCE else ""
    most, unit = OF_SIZE.get(column, (math.inf, ""))
    return unit if sizes[-IN_UNIT] > most >= sizes[-IN_UNIT] * UNITS[column][unit] else ""


def is_unit(column: str, text: str) -> bool:
    """Whether a text is a unit of the column, other than none at all."""
    return _strip_unit_brackets(text) not in _NO_UNIT and factor_of(column, text) is not None


def unit_in_brackets(name: str) -> str:
    """The unit that a heading such as `Angle [deg]` holds; empty for none."""
    found = _WITH_UNIT.fullmatch(name)
    return found[2].strip() if found else ""


def unit_attribute(attributes: Mapping[str, Any]) -> Any:
    """What files say beside a channel under `unit` or `units`, however spelt; empty for nothing."""
    return next((text for key, text in attributes.items() if key.lower() in ("unit", "units")), "")


def name_without_unit(name: str) -> str:
    """A heading without its unit."""
    found = _WITH_UNIT.fullmatch(name)
    return (found[1] if found and found[1] else name).strip()


def unit_at_end(column: str, name: str) -> str:
    """The unit that a name such as `steer_deg` or `torque_kN_m` ends in; empty for none."""
    *first, before, last = ["", "", *re.split(r"[_\s]+", name)]
    if any(first) and (compound := {f"{before} {last}", f"{before}/{last}"} & {*UNITS[column]}):
        return compound.pop().replace(" ", "")
    return _strip_unit_brackets(last) if before and is_unit(column, last) else ""


def require_factor(column: str, unit: str, channel: str) -> float:
    """The factor from a unit to SI; where there is none, the message proposes a map of the channel."""
    factor = factor_of(column, unit)
    if factor is None:
        likely = unit_at_end(column, channel) or next(iter(UNITS[column]))
        raise InvalidInputError(
            f"{excerpt(unit)} is no unit of {column}; allowed: {', '.join(UNITS[column])}; say which it"
            f" is, such as --map {column}={channel}:{likely.replace(' ', '')}"
        )
    return factor


def _strip_unit_brackets(unit: str) -> str:
    return unit.strip().strip("[]()").strip()
