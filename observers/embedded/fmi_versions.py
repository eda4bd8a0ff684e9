"""What differs between versions of FMI, and the functions of each that this model does not offer."""

from collections.abc import Mapping
from typing import Any

BASE = {
    "1": {}, "rad": {"rad": 1}, "m": {"m": 1}, "s": {"s": 1}, "kg": {"kg": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
}  # fmt: skip
"""Units of the library by those of FMI, with their exponents."""
_AT = "const fmi{}ValueReference at[], size_t count"


def fmi_base_unit_xml(unit: str) -> str:
    """The BaseUnit of a unit such as N.m/rad; empty where FMI has none for it, as for 1/sqrt(s)."""
    exponents: dict[str, int] = {}
    above, *below = unit.split("/")
    for sign, part in ((1, above), *((-1, part) for part in below)):
        for factor in part.split("."):
            name, _, power = factor.partition("^")
            if name not in BASE or not (power or "1").isdigit():
                return ""
            for base, exponent in BASE[name].items():
                exponents[base] = exponents.get(base, 0) + sign * exponent * int(power or 1)
    order = [base for base in ("kg", "m", "s", "rad") if exponents.get(base)]
    attributes = "".join(f' {base}="{exponents[base]}"' for base in order)
    return f"<BaseUnit{attributes}/>"


def marked_unused(parameters: str) -> str:
    """C that marks parameters as not used."""
    names = (parameter.split()[-1].strip("*[]") for parameter in parameters.split(",") if parameter)
    return ", ".join(f"(void){name}" for name in names) + ";"


def _get_set_functions(
    version: int, verb: str, types: str, more: str = ""
) -> tuple[tuple[str, str], ...]:
    """The functions that get or set variables of some types."""
    const = "const " * (verb == "Set")
    return tuple(
        (f"{verb}{type_}", f"{_AT.format(version)}, {const}fmi{version}{type_} values[]{more}")
        for type_ in types.split()
    )


VERSION_2 = {
    "number": 2, "fmi": "fmi2", "instance": "fmi2Component", "logger": "CallbackLogger",
    "state": "FMUstate", "deserialize": "DeSerializeFMUstate", "real_type": "Real",
    "integer_type": "Integer", "array": "", "description": "modelDescription.xml",
    "library": "linux64", "build": False,
    "unsupported": (
        *_get_set_functions(2, "Set", "Integer Boolean String"),
        *_get_set_functions(2, "Get", "String"),
        ("GetDirectionalDerivative", f"{_AT.format(2)}, const fmi2ValueReference by[], size_t known,"
         " const fmi2Real along[], fmi2Real v[]"),
        ("SetRealInputDerivatives", f"{_AT.format(2)}, const fmi2Integer order[], const fmi2Real v[]"),
        ("GetRealOutputDerivatives", f"{_AT.format(2)}, const fmi2Integer order[], fmi2Real v[]"),
    ),
    # The standard's answer of a slave whose steps are over when they return.
    "discarded": tuple(
        (f"Get{type_}Status", f"const fmi2StatusKind kind, fmi2{type_ or 'Status'} *value")
        for type_ in ("", "Real", "Integer", "Boolean", "String")
    ),
}  # fmt: skip
_CLOCKS = {
    "GetIntervalDecimal": "fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]",
    "GetIntervalFraction": "fmi3UInt64 counters[], fmi3UInt64 resolutions[],"
    " fmi3IntervalQualifier qualifiers[]",
    "GetShiftDecimal": "fmi3Float64 shifts[]",
    "GetShiftFraction": "fmi3UInt64 counters[], fmi3UInt64 resolutions[]",
    "SetIntervalDecimal": "const fmi3Float64 intervals[]",
    "SetIntervalFraction": "const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]",
    "SetShiftDecimal": "const fmi3Float64 shifts[]",
    "SetShiftFraction": "const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]",
}
_NUMBERS = "Float32 Int8 UInt8 Int16 UInt16 UInt32 Int64 UInt64 String"
_DERIVATIVE = (
    f"{_AT.format(3)}, const fmi3ValueReference by[], size_t known, const fmi3Float64 seed[],"
    " size_t seeds, fmi3Float64 along[], size_t n"
)
VERSION_3 = {
    "number": 3, "fmi": "fmi3", "instance": "fmi3Instance", "logger": "LogMessageCallback",
    "state": "FMUState", "deserialize": "DeserializeFMUState", "real_type": "Float64",
    "integer_type": "Int32", "array": ", size_t values_count", "description": "modelDescription3.xml",
    "library": "x86_64-linux", "build": True, "discarded": (),
    "unsupported": (
        *_get_set_functions(3, "Get", _NUMBERS, ", size_t n"),
        *_get_set_functions(3, "Set", f"{_NUMBERS} Int32 Boolean", ", size_t n"),
        *_get_set_functions(3, "Get", "Clock"),
        *_get_set_functions(3, "Set", "Clock"),
        ("GetBinary", f"{_AT.format(3)}, size_t sizes[], fmi3Binary values[], size_t n"),
        ("SetBinary", f"{_AT.format(3)}, const size_t sizes[], const fmi3Binary values[], size_t n"),
        ("GetDirectionalDerivative", _DERIVATIVE),
        ("GetAdjointDerivative", _DERIVATIVE),
        ("GetOutputDerivatives",
         f"{_AT.format(3)}, const fmi3Int32 orders[], fmi3Float64 values[], size_t n"),
        *((name, f"{_AT.format(3)}, {more}") for name, more in _CLOCKS.items()),
        ("UpdateDiscreteStates", "fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,"
         " fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next"),
        ("CompletedIntegratorStep",
         "fmi3Boolean no_set_state, fmi3Boolean *event, fmi3Boolean *terminate"),
        ("SetTime", "fmi3Float64 time"),
        ("SetContinuousStates", "const fmi3Float64 states[], size_t count"),
        *((name, "fmi3Float64 values[], size_t count") for name in (
            "GetContinuousStateDerivatives", "GetEventIndicators", "GetContinuousStates",
            "GetNominalsOfContinuousStates",
        )),
        ("ActivateModelPartition", "fmi3ValueReference clock, fmi3Float64 time"),
        *((mode, "") for mode in (
            "EnterConfigurationMode", "ExitConfigurationMode", "EnterEventMode",
            "EnterContinuousTimeMode", "EnterStepMode", "EvaluateDiscreteStates",
        )),
    ),
}  # fmt: skip
VERSIONS: Mapping[int, Mapping[str, Any]] = {2: VERSION_2, 3: VERSION_3}
"""By the number of the version: types and parts of names for the templates, the folder of the library,
whether there is a buildDescription.xml; functions that report an error, with their parameters behind the
instance, of which those without a `count` are never called by an importer that has read the model
description; and functions that answer `Discard`."""
