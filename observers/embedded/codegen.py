"""C99 of an observer for an embedded target, and a package of ROS 2 around it.

CasADi writes the computation from the Functions that run in Python (see
`observers.embedded.casadi_c_reduction`); the public functions around it, on a state of fixed size, are
in `templates`. The interface does not depend on the observer.
"""

import hashlib
import json
from collections.abc import Mapping
from inspect import getattr_static
from math import isfinite
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from observers.embedded.casadi_c_reduction import embedded_code
from observers.embedded.compact_codegen import compact_body, compact_patch
from observers.embedded.generated_file_overwriting import (
    file_mark,
    require_usable_code_name,
    write_generated,
)
from observers.embedded.jinja_templates import ObserverBody, render
from observers.embedded.reference_samples import reference_csv
from observers.embedded.run_time_parameters import parameter_placeholders, run_time_parameters
from observers.embedded.scalar_expansion import Tunable, add_function_comments
from observers.embedded.scalar_type import SINGLE, Real, code_in_type, prefix_own_c_names
from observers.estimators.model_observer import RIG_UNITS
from observers.measurement.causal_yaw_rate import FILTER_TIME_CONSTANT
from observers.measurement.directional_friction import OTHER
from observers.measurement.measurement_model import MIN_FIRST_LOAD, RIG
from observers.measurement.torque_error import SENSIBLE
from observers.protocol import (
    ESTIMATE,
    MAX_SAMPLE_PERIOD,
    OUTPUT,
    SAMPLE,
    UNINFORMED,
    FunctionObserver,
    Status,
)
from observers.quality.sample_screening import SLACK
from observers.quality.wrong_units_or_signs import START, build_implausibility_evidence
from observers.tuning import Tuning
from symbolic import SIGNALS, InvalidInputError
from symbolic.compilation.scalar_c import c_function
from symbolic.effects.asymmetric_friction import ASYMMETRY_RATIO, weaker_share_below_mean
from symbolic.tables.found_model import units_of
from symbolic.version import version

REFUSED = 128
"""Status of a sample that generated code ignores; Python raises an error there."""
STATUS_FLAGS = (
    *((str(flag.name), int(flag), flag.remedy) for flag in Status if flag & ~Status.NO_ROOT),
    (
        "REFUSED",
        REFUSED,
        "dt out of range, the sample was ignored; or an estimate was not finite; or the state is none"
        " of this code",
    ),
)
"""Name, number and remedy of every status that generated code can set."""


TORQUE_MEANING = {
    "M_z": "aligning torque, moment of the ground on the wheel",
    "M": "steering torque, of the hand or motor on the wheel",
}
"""Meaning of the torques that an observer may use."""
INPUTS_OF = {"M_z": ("psi", "psi_dot", "M_z", "F_N"), "M": ("psi", "M", "F_N")}
"""Inputs of an observer by its torque; from the steering torque it estimates the rate too."""
MEMBERS = tuple(n for part in FunctionObserver.__mro__ for n in vars(part) if not n.startswith("_"))
"""Names that a `FunctionObserver` has."""


def generate(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip",
    tunable: Tunable = "",
) -> list[Path]:  # fmt: skip
    """Write an observer as C99, with example, check, S-function, parameters and reference samples.

    Args:
        observer: an `Ekf`, an `Mhe`, or any other `FunctionObserver`.
        folder: where the files go; it is created if necessary.
        real: the type of every number.
        name: begins every name in C and names the files.
        tunable: what C takes at run time and describes for calibration tools in `name`.a2l (ASAM
            MCD-2 MC): nothing, the "tuning", or "all", which is model, rig and tuning. On the declared
            model that costs little; with effects, whose tables the model decides, "all" is written by
            CasADi as vectors, and a step takes some fifty times as long.

    Returns:
        The files written.

    Raises:
        InvalidInputError: the observer is no `FunctionObserver`, the name is none in C or is taken, a
            constant is beyond the type, or a file that was not generated is in the way; with `tunable`,
            the observer is neither an `Ekf` nor an `Mhe`.
    """
    return write_generated(folder, source_texts(observer, real, name, tunable=tunable)[0])


def generate_ros2(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip"
) -> list[Path]:
    """Write an observer as a package of ROS 2, to be built by colcon.

    The node takes the joint's position [rad], velocity [rad/s] and effort [N m] from `joint_states`, the
    load [N] from `load` or from a parameter; a message is a sample. It publishes `~/estimate` in the
    order of `ESTIMATE`, and `~/reset` starts the observer anew. The name is that of package, executable
    and node; numbers in messages are double. Arguments, the files returned and errors are as for
    `observers.embedded.generate`.
    """
    texts, terms = source_texts(observer, real, name)
    kept = {file: texts[file] for file in (f"{name}.c", f"{name}.h", f"{name}.hpp", f"{name}.json")}
    templates = {
        f"{name}_node.cpp": "ros2_node.cpp", "package.xml": "ros2_package.xml",
        "CMakeLists.txt": "ros2_CMakeLists.txt",
    }  # fmt: skip
    files = kept | {file: render(template, terms) for file, template in templates.items()}
    return write_generated(folder, files)


def source_texts(
    observer: FunctionObserver, real: Real, name: str, *, tunable: Tunable = ""
) -> tuple[dict[str, str], dict[str, Any]]:
    """The text of every file, by its name, and the values of the templates; errors as for `generate`."""
    require_usable_code_name(name)
    if absent := [name for name in MEMBERS if getattr_static(observer, name, None) is None]:
        raise InvalidInputError(
            "observer must be an Ekf, an Mhe or another observers.FunctionObserver, made of casadi"
            f" Functions, got {type(observer).__name__} without {', '.join(absent)}"
        )
    terms = _placeholders(observer, real, name, tunable)
    patch = compact_patch(observer, real, tunable)
    body = _casadi_body(observer, real, terms) if patch is None else compact_body(patch, terms)
    result = "result" if body.supervised else "output"
    terms |= {
        **vars(body),
        "result": result,
        "bytes": _state_bytes(body, real, terms["constants_size"], len(START) * terms["checked"]),
        "version": "",
        "layout": "",
    }
    text = render("observer.h", terms) + render("observer.c", terms)
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]
    terms["version"] = f"brushgrip {version()} {observer.name} {real.c_type} {digest}"
    terms["layout"] = digest[:8]
    templates = {
        f"{name}.h": "observer.h", f"{name}.c": "observer.c", "main.c": "main.c", "check.c": "check.c",
        f"{name}.hpp": "observer.hpp", f"{name}_sfun.c": "sfunction.c",
        "CMakeLists.txt": "CMakeLists.txt", **({f"{name}.a2l": "parameters.a2l"} if tunable else {}),
    }  # fmt: skip
    texts = {file: render(template, terms) for file, template in templates.items()}
    texts[f"{name}.c"] = prefix_own_c_names(code_in_type(texts[f"{name}.c"], real), name)
    texts[f"{name}.json"] = _parameters_json(observer, real, terms["version"], tunable)
    texts[f"{name}_vector.csv"] = reference_csv(observer, real)
    return texts, terms


def _state_bytes(body: ObserverBody, real: Real, constants: int, checked: int) -> int:
    """Bytes of a state: body, output, constants, eight numbers, four integers, padded to a number."""
    size = body.bytes + (len(OUTPUT) + 8 + checked + constants) * real.size + 16
    return -(-size // real.size) * real.size


def _comparison_tolerance(observer: FunctionObserver, real: Real) -> dict[str, str]:
    """What `check` allows, and why: bristles turn rounding into whole bristles that stick or slide."""
    limit, comment = "1e-8", "Double precision."
    if real is SINGLE and observer.model.uses_exact_patch:
        limit, comment = "1e-3", "Single precision, exact patch."
    elif real is SINGLE:
        limit, comment = "5e-2", "Single precision, bristles: rounding decides which slide."
    return {"limit": limit, "limit_comment": comment}


def _weaker_direction_terms(observer: FunctionObserver, real: Real, tunable: Tunable) -> dict[str, str]:
    """What the weaker direction holds less: a number, or the parameter that tells it, or neither."""
    ratio = ASYMMETRY_RATIO.replace(".", "_") * (tunable == "all" and ASYMMETRY_RATIO in observer.values)
    single = OTHER not in getattr(getattr(observer, "measurement_model", None), "states", ())
    share = real.literal(weaker_share_below_mean(observer.values)) if single and not ratio else ""
    return {"weaker": share, "ratio": ratio * single}


def _placeholders(observer: FunctionObserver, real: Real, name: str, tunable: Tunable) -> dict[str, Any]:
    prior = observer.prior
    changed: dict[str, Any] = {"parameters": (), "constants_size": 0}
    if tunable:
        changed = parameter_placeholders(observer, run_time_parameters(observer, tunable), real)
    return {
        "tunable": tunable, "constants_at": ", state->constants" if tunable else "",
        "name": name, "NAME": name.upper(), "real": real.c_type, "digits": real.digits,
        **_comparison_tolerance(observer, real),
        **_weaker_direction_terms(observer, real, tunable),
        "title": f"{observer.title}; {real.c_type}.",
        "rig_comment": _rig_comment(observer, tunable),
        "torque": observer.channel,
        # Fields of a sample, and their places among the inputs of a program.
        "sensors": (
            ("psi", "PSI"),
            ("psi_dot", "PSI_DOT"),
            (observer.channel, "TORQUE"),
            ("F_N", "LOAD"),
        ),
        "torques": SAMPLE[len(SIGNALS) :],
        "raw_torques": "".join(
            f", sample->{name}" if name == observer.channel else f", ({real.c_type})NAN"
            for name in SAMPLE[len(SIGNALS) :]
        ),
        "torque_meaning": TORQUE_MEANING[observer.channel],
        "uses_rate": "psi_dot" in INPUTS_OF[observer.channel],
        "brushgrip": version(), "generated": file_mark(), "casadi": ca.CasadiMeta.version(),
        "flags": STATUS_FLAGS, "output": OUTPUT, "estimate": ESTIMATE,
        "numbers": tuple(name for name in OUTPUT if name != "status"),
        "constants": [
            (real.literal(value), label)
            for value, label in zip(observer.constants, observer.constant_labels, strict=True)
        ],
        "prior_mu": real.literal(prior.mu),
        "prior_std": real.literal(prior.mu_std),
        "informed_below": real.literal(observer.informed_below),
        "uninformed": UNINFORMED,
        "checked": getattr(observer, "has_unit_and_sign_check", True),
        "evidence": c_function(
            "gather_evidence", build_implausibility_evidence(observer.channel), real.c_type
        ),
        "evidence_start": [
            real.literal(value) if isfinite(value) else f"({real.c_type})NAN" for value in START
        ],
        "half_length": real.literal(observer.rig.a),
        "rate_time_constant": repr(FILTER_TIME_CONSTANT),
        "limits": [
            real.literal(x) for x in getattr(observer, "sample_limits", Tuning().sensor_limits)
        ],
        "slack": real.literal(SLACK),
        "longest_step": repr(MAX_SAMPLE_PERIOD),
        "largest_value": repr(SENSIBLE),
        "least_first_load": repr(MIN_FIRST_LOAD),
        **changed,
    }  # fmt: skip


def _rig_comment(observer: FunctionObserver, tunable: Tunable) -> str:
    """The tyre's stiffness and the geometry that the code is for, where it has them."""
    rig, values = observer.rig, observer.values
    given = [f"k = {values['k']:g} N/m^2"] if "k" in values else []
    given += [f"a = {rig.a:g} m", f"e = {rig.e:g} m"]
    later = "; others at run time" if tunable == "all" else ""
    return f"For {', '.join(given)}{later}."


def _casadi_body(observer: FunctionObserver, real: Real, terms: Mapping[str, Any]) -> ObserverBody:
    """The observer's two Functions as CasADi writes them, for any observer and model."""
    pair = (observer.initial_function, observer.step_function)
    code = embedded_code(pair, real, f"{terms['name']}_core")
    size, reals, integers = observer.layout.size, max(code.w, 1), max(code.iw, 1)
    initial, step = (function.name() for function in pair)
    calls = {"arg": code.arg, "res": code.res, "initial": initial, "step": step}
    return ObserverBody(
        core=add_function_comments(code.text),
        stepping=render("stepping.c", {**terms, **calls}),
        private_fields=f"    {real.c_type} values[2][{size}]; /* before and after a sample */\n"
        f"    {real.c_type} scratch[{reals}];\n"
        f"    int32_t integers[{integers}];",
        bytes=(2 * size + reals) * real.size + 4 * integers,
    )


def _parameters_json(observer: FunctionObserver, real: Real, version: str, tunable: Tunable) -> str:
    """JSON of model, values, rig and settings; what JSON does not have is written as a string."""
    units = units_of(observer.model)
    rig = zip(((name, getattr(observer.rig, name)) for name in RIG), RIG_UNITS, strict=True)
    document = {
        "generated": file_mark(),
        "version": version,
        "observer": observer.name,
        "real": real.c_type,
        "at_run_time": tunable or None,
        "effects": [effect.name for effect in observer.model.effects],
        "parameters": {n: {"value": v, "unit": units[n]} for n, v in observer.values.items()},
        "rig": {name: {"value": value, "unit": unit} for (name, value), unit in rig},
        **observer.settings,
    }
    return json.dumps(_as_json(document), indent=2, allow_nan=False) + "\n"


def _as_json(value: Any) -> Any:
    """Mappings, sequences and arrays as JSON has them; any other value, infinity too, as a string."""
    if isinstance(value, Mapping):
        return {str(name): _as_json(part) for name, part in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _as_json(value.tolist())
    if isinstance(value, list | tuple):
        return [_as_json(part) for part in value]
    if isinstance(value, float):
        return value if isfinite(value) else str(value)
    return value if value is None or isinstance(value, str | int) else str(value)
