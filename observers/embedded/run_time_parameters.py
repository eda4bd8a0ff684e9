"""Parameters that generated C takes at run time: named numbers with their ranges, in one block.

They are those of the model, the rig and the tuning, in physical units, as `values`, `Rig` and `Tuning`
have them. C checks a block as these classes do, and fills the vector of constants from it.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from observers.embedded.scalar_expansion import Tunable
from observers.embedded.scalar_type import DOUBLE, SINGLE, Real
from observers.estimators.model_observer import RIG_UNITS, ModelObserver
from observers.measurement.measurement_model import RIG
from observers.protocol import OUTPUT, FunctionObserver
from observers.tuning import (
    INFORMED,
    LIMIT_FIELDS,
    NO_LIMIT,
    NON_NEGATIVE_FIELDS,
    PLAUSIBLE,
    POSITIVE,
    TUNING_FIELDS,
    TUNING_UNITS,
    field_meanings,
)
from symbolic import RIG_RANGES, InvalidInputError, parameter_name

A2L_TYPES = {SINGLE: "FLOAT32_IEEE", DOUBLE: "FLOAT64_IEEE"}
"""Types by their names in ASAM MCD-2 MC."""
ESTIMATE_UNITS = {"M_z_predicted": "N m", "M_slide": "N m"}
"""Units of an estimate's numbers that have one."""
PRIOR = ("mu", "mu_std", "zero_std", "stiffness_std", "psi_dot_std")
"""Fields of the tuning that are of the state before the first sample."""
RELATIONS = (
    ("a", "fabs({e}) < {a}"),
    ("mu", "{least} < {mu} && {mu} < {greatest}"),
    ("reset_after", "floor({reset_after}) >= {reset_after}"),
)
"""Conditions on several parameters at once, and the one that is told where one does not hold."""
ORDERED = {
    "mu": "greater than least, less than greatest",
    "least": "greater than 0, less than mu",
    "greatest": "greater than mu",
    "reset_after": "a whole number from 1",
}
"""Ranges of those, in words."""


@dataclass(frozen=True, kw_only=True)
class RunTimeParameter:
    """One number of the block."""

    field: str  # Its name in C.
    unit: str
    about: str  # What it means, or what it belongs to: the tyre, an effect, the rig.
    value: float  # That of the observer, which is the default.
    places: tuple[int, ...]  # Where it stands in the vector of constants.
    lower: float = -inf  # Its least value.
    upper: float = inf  # Its greatest value.
    is_open: bool = False  # The lower end does not belong to the range.
    is_finite: bool = True  # Infinity is not allowed.
    inverse: bool = False  # One over it stands there.

    def c_range_condition(self, real: Real) -> str:
        """C that is true where the field of `at` is in range, and false for NAN."""
        name, parts = f"at->{self.field}", []
        if isfinite(self.lower):
            parts.append(f"{name} {'>' if self.is_open else '>='} {real.literal(self.lower)}")
        if isfinite(self.upper):
            parts.append(f"{name} <= {real.literal(self.upper)}")
        elif self.is_finite:
            parts.append(f"fabs({name}) <= {real.literal(real.greatest)}")
        return " && ".join(parts)

    @property
    def range(self) -> str:
        """The range in words."""
        if self.field in ORDERED:
            return ORDERED[self.field]
        least = f"greater than {self.lower:g}" if self.is_open else f"from {self.lower:g}"
        if not isfinite(self.lower):
            return "any finite number"
        if isfinite(self.upper):
            return f"{least} to {self.upper:g}"
        return least if self.is_finite else f"{least}, INFINITY for none"


def run_time_parameters(observer: FunctionObserver, tunable: Tunable) -> tuple[RunTimeParameter, ...]:
    """The parameters of an observer that C takes at run time.

    Refused are an observer that is no `Ekf` and no `Mhe`, a name of an effect that cannot be one in C,
    and two parameters of one name.
    """
    if not isinstance(observer, ModelObserver):
        raise InvalidInputError(
            "parameters at run time are those of an Ekf or an Mhe, got"
            f" {type(observer).__name__}; generate its code without them"
        )
    tuning = tuple(_tuning_parameters(observer))
    if tunable != "all":
        return tuning
    found = (*_model_parameters(observer), *_rig_parameters(observer), *tuning)
    names = Counter(parameter.field for parameter in found)
    if bad := [name for name, count in names.items() if count > 1 or not name.isascii()]:
        raise InvalidInputError(
            f"parameters at run time need names of their own in ASCII, EFFECT_PARAMETER, got {bad[0]!r};"
            " choose another name for the effect"
        )
    return found


def _model_parameters(observer: ModelObserver) -> Iterator[RunTimeParameter]:
    """K and the parameters of effects; mu is that of the tuning."""
    for place, (effect, parameter) in enumerate(observer.model.parameters):
        if (name := parameter_name(effect, parameter)) != "mu":
            yield RunTimeParameter(
                field=name.replace(".", "_"), unit=parameter.unit,
                about=effect.name.replace("_", " ") if effect else "the tyre",
                value=float(observer.values[name]), places=(place,),
                lower=parameter.lower, upper=parameter.upper, is_finite=not parameter.inverse,
                inverse=parameter.inverse,
            )  # fmt: skip


def _rig_parameters(observer: ModelObserver) -> Iterator[RunTimeParameter]:
    begin = len(observer.model.parameters)
    for place, (name, unit) in enumerate(zip(RIG, RIG_UNITS, strict=True), start=begin):
        if (value := getattr(observer.rig, name)) is not None:
            lower, upper = RIG_RANGES[name]
            yield RunTimeParameter(
                field=name, unit=unit, about="the rig", value=float(value), places=(place,),
                lower=lower, upper=upper, is_open=name == "slide_rate",
            )  # fmt: skip


def _tuning_parameters(observer: ModelObserver) -> Iterator[RunTimeParameter]:
    meaning = field_meanings()
    for place, name in enumerate(TUNING_FIELDS, start=len(observer.model.parameters) + len(RIG)):
        positive = name in (*POSITIVE, "mu", "greatest")
        yield RunTimeParameter(
            field=name, unit=TUNING_UNITS.get(name, "1"), about=meaning.get(name, "the tuning"),
            value=float(getattr(observer.effective_tuning, name)),
            places=(0, place) if name == "mu" else (place,),
            lower=0.0 if positive or name in NON_NEGATIVE_FIELDS else 1.0, is_open=positive,
            is_finite=name not in LIMIT_FIELDS or name in ("mu", "least", "greatest", "reset_after"),
        )  # fmt: skip


def a2l_placeholders(parameters: Sequence[RunTimeParameter], real: Real) -> dict[str, Any]:
    """Values of the placeholders of `templates/parameters.a2l`."""
    most, numbers = real.greatest, [name for name in OUTPUT if name != "status"]
    measured = [
        (name, A2L_TYPES[real], ESTIMATE_UNITS.get(name, "1"), -most, most, i * real.size)
        for i, name in enumerate(numbers)
    ]
    flags = {"informed": 1, "usable": 1, "status": 2**31 - 1}
    begin = len(numbers) * real.size
    measured += [(n, "SLONG", "1", 0, flags[n], begin + 4 * i) for i, n in enumerate(flags)]
    ranges = [
        (p.field, f"{p.about}: {p.range}", p.unit, _lower_limit(p, real), max(min(p.upper, most), -most))
        for p in parameters
    ]
    units = list(dict.fromkeys([*(one[2] for one in ranges), *(one[2] for one in measured)]))
    return {"measured": measured, "characteristics": ranges, "units": units, "real_size": real.size,
            "a2l_real": A2L_TYPES[real]}  # fmt: skip


def _lower_limit(parameter: RunTimeParameter, real: Real) -> float:
    """The least value that is allowed, which a calibration tool may offer."""
    if parameter.is_open and parameter.lower == 0:
        return float(np.finfo(real.dtype).tiny)
    return min(max(parameter.lower, -real.greatest), real.greatest)


def parameter_placeholders(
    observer: FunctionObserver, parameters: Sequence[RunTimeParameter], real: Real
) -> dict[str, Any]:
    """Values of the placeholders of templates: C that reads the constants of a state."""
    place = {parameter.field: parameter.places[-1] for parameter in parameters}
    at = {name: f"state->constants[{i}]" for name, i in place.items()}
    block = {name: f"at->{name}" for name in place}
    most = real.literal(NO_LIMIT)
    return {
        "parameters": [
            {
                **vars(p),
                "literal": real.literal(p.value),
                "start": repr(p.value).replace("inf", "INF"),
                "fmi_unit": p.unit.replace(" ", "."),
                "least": repr(_lower_limit(p, real)) if isfinite(p.lower) else "",
                "most": repr(float(p.upper)) if isfinite(p.upper) else "",
                "condition": p.c_range_condition(real),
                "range": p.range,
            }
            for p in parameters
        ],
        "prior": PRIOR,
        "relations": [
            (1 + list(place).index(name), condition.format(**block))
            for name, condition in RELATIONS
            if name in place
        ],
        **a2l_placeholders(parameters, real),
        "constants": [
            (i, real.literal(value))
            for i, value in enumerate(observer.constants)
            if i not in {place for p in parameters for place in p.places}
        ],
        "constants_size": len(observer.constants),
        "prior_mu": at["mu"],
        "prior_std": at["mu_std"],
        "informed_below": f"{real.literal(INFORMED)} * {at['mu_std']} / {at['mu']}",
        "limits": [f"({at[n]} < {most} ? {at[n]} : {most})" for n in PLAUSIBLE],
    }
