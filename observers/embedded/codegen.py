"""An observer written out as C99 for an embedded target.

What is computed is written by casadi from the very Functions that run in Python (see
`observers.embedded.casadi_c`); what is around it, five functions on a state of fixed size, stands in
`templates`. The interface does not depend on what is inside.
"""

import hashlib
import importlib.metadata
import re
from collections.abc import Mapping
from pathlib import Path

import casadi as ca

from observers.angle_derivative import MEMORY
from observers.ekf import Ekf
from observers.embedded.casadi_c import embedded_source
from observers.embedded.compact_ekf import compact_body, is_compact
from observers.embedded.compact_mhe import compact_window_body, is_compact_window
from observers.embedded.literals import in_type
from observers.embedded.parameters import parameters_text
from observers.embedded.scalar_type import SINGLE, Real
from observers.embedded.templating import Body, filled
from observers.embedded.test_vector import vector_text
from observers.measurement_model import SENSIBLE
from observers.mhe import Mhe
from observers.protocol import (
    LONGEST_STEP,
    FunctionObserver,
    Status,
)
from symbolic import InvalidInputError

REFUSED = 128
"""Status of a sample that generated code leaves out; Python raises an error there."""
REMEDIES = {
    **{int(status): status.remedy for status in Status if status & ~Status.NO_ROOT},
    REFUSED: "dt out of range, the sample was left out; or numbers failed",
}


def generate(
    observer: FunctionObserver, folder: str | Path, real: Real = SINGLE, *, name: str = "brushgrip"
) -> list[Path]:
    """Write an observer as C99: header, code, example, check, S-function, parameters, test vector.

    Args:
        observer: an `Ekf`, an `Mhe`, or any other `FunctionObserver`.
        folder: where to; made if it is not there.
        real: the type of every number.
        name: begins every name in C and names the files.

    Returns:
        The files written.

    Raises:
        InvalidInputError: the observer is no `FunctionObserver`, the name is none in C, or a constant is
        beyond
            the type.
    """
    texts = texts_of(checked(observer, name), real, name)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        (folder / file).write_text(text, encoding="utf-8", newline="\n")
    return [folder / file for file in texts]


def checked(observer: FunctionObserver, name: str) -> FunctionObserver:
    """The observer, if it can be written out under this name; else `InvalidInputError`."""
    if not all(hasattr(type(observer), n) for n in ("layout", "initial_function", "step_function")):
        raise InvalidInputError(
            "observer must be an Ekf, an Mhe or another observer made of casadi Functions, got"
            f" {type(observer).__name__}"
        )
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", name):
        raise InvalidInputError(
            f"name must be a name in C, small letters, digits and _, at most 31, got {name!r}"
        )
    return observer


def texts_of(observer: FunctionObserver, real: Real, name: str) -> dict[str, str]:
    """Every file's text by its name."""
    terms = terms_of(observer, real, name)
    body = body_of(observer, real, terms)
    terms |= {"types": body.types, "private": body.private, "bytes": str(body.bytes + 7 * real.size + 8)}
    code = in_type(filled("observer.c", {**terms, "core": "@core@", "stepping": "@stepping@"}), real)
    version = terms["version"] = _version(observer, real, body.core + body.stepping + code)
    code = code.replace("@version@", version)
    code = code.replace("@core@", body.core).replace("@stepping@", body.stepping)
    return {
        f"{name}.h": filled("observer.h", terms),
        f"{name}.c": code,
        "main.c": filled("main.c", terms),
        "check.c": filled("check.c", terms),
        f"{name}_sfun.c": filled("sfunction.c", terms),
        "CMakeLists.txt": filled("CMakeLists.txt", terms),
        f"{name}.json": parameters_text(observer, real, version),
        f"{name}_vector.csv": vector_text(observer, real, terms["torque"]),
    }


def body_of(observer: FunctionObserver, real: Real, terms: Mapping[str, str]) -> Body:
    """The compact code where there is one for the observer."""
    if isinstance(observer, Ekf) and is_compact(observer):
        return compact_body(observer, real, terms)
    if isinstance(observer, Mhe) and is_compact_window(observer):
        return compact_window_body(observer, real, terms)
    return casadi_body(observer, real, terms)


def casadi_body(observer: FunctionObserver, real: Real, terms: Mapping[str, str]) -> Body:
    """The observer's own Functions as casadi writes them; any model."""
    step, start = observer.step_function, observer.initial_function
    source = embedded_source([start, step], real, f"{terms['name']}_core")
    sizes = {"arg": str(source.arg), "res": str(source.res), "start": start.name(), "step": step.name()}
    state, integers = observer.layout.size, max(source.iw, 1)
    private = (
        f"    {real.c_type} values[2][{state}]; /* before and after a sample */\n"
        f"    {real.c_type} scratch[{max(source.w, 1)}];\n"
        f"    int32_t integers[{integers}];"
    )
    return Body(
        core=source.text,
        stepping=in_type(filled("stepping.c", {**terms, **sizes}), real),
        private=private,
        bytes=(2 * state + max(source.w, 1)) * real.size + 4 * integers,
    )


def terms_of(observer: FunctionObserver, real: Real, name: str) -> dict[str, str]:
    """What the templates are filled with."""
    prior, torque = observer.prior, observer.channel
    said = {
        "M_z": "aligning torque, moment of the ground on the wheel [N m]",
        "M": "steering torque, of the hand or motor on the wheel [N m]",
    }
    constants = observer.constants.tolist()
    return {
        "name": name,
        "NAME": name.upper(),
        "real": real.c_type,
        "digits": str(real.digits),
        "torque": torque,
        "torque_said": said[torque],
        "rate_said": "not used: the rate is estimated"
        if torque == "M"
        else "yaw rate [rad/s]; where there is none it is taken from the past of psi",
        "M_z": "sample->M_z" if torque == "M_z" else f"({real.c_type})NAN",
        "M": "sample->M" if torque == "M" else f"({real.c_type})NAN",
        "described": f"{observer.title}; {real.c_type}.",
        "brushgrip": release(),
        "casadi": ca.CasadiMeta.version(),
        "flags": "\n".join(
            f"    {name.upper()}_{_flag(n)} = {n}, /* {r} */" for n, r in REMEDIES.items()
        ),
        "constants_count": str(len(constants)),
        "constants": "\n".join(
            f"    {real.literal(value)}, /* {what} */"
            for value, what in zip(constants, observer.constant_labels, strict=True)
        ),
        "prior_mu": real.literal(prior.mu),
        "prior_std": real.literal(prior.mu_std),
        "informed_below": real.literal(observer.informed_below),
        "memory": repr(MEMORY),
        "longest_step": repr(LONGEST_STEP),
        "sensible": repr(SENSIBLE),
        "tolerance": "1e-3" if real is SINGLE else "1e-9",
        "version": "@version@",
    }


def release() -> str:
    """The version of brushgrip; a checkout that is not installed has none."""
    try:
        return importlib.metadata.version("brushgrip")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"


def _flag(number: int) -> str:
    return "REFUSED" if number == REFUSED else str(Status(number).name)


def _version(observer: FunctionObserver, real: Real, code: str) -> str:
    digest = hashlib.sha256(code.encode()).hexdigest()[:12]
    return f"brushgrip {release()} {observer.name} {real.c_type} {digest}"
