"""Rig and tyre from a TOML file, and what a recording itself says about them."""

import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from identification.files import excerpt, read_text
from symbolic.errors import InvalidInputError
from symbolic.parameters import Rig, Tyre

_REQUIRED = {"rig": ("a", "e"), "tyre": ("k",)}
_ALLOWED = {"rig": ("a", "e", "J_A", "b_t"), "tyre": ("k", "mu")}

DECLARABLE = (*_ALLOWED["rig"], *_ALLOWED["tyre"])
"""Parameters that a recording may give for itself."""


def read_rig(path: str | Path) -> tuple[Rig, Tyre]:
    """Reads ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu`` (SI units; J_A, b_t and mu optional).

    Raises:
        InvalidInputError: the file cannot be read, a section or key is missing or unknown, or a
            value is not a number within its range.
    """
    path = Path(path)
    try:
        document = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        fault = " ".join(str(error).split())
        raise InvalidInputError(f"{path}: is not valid TOML: {fault}") from None
    unknown = [name for name in document if name not in _ALLOWED]
    if unknown:
        raise InvalidInputError(
            f"{path}: unknown section or key {excerpt(unknown[0])}; allowed: [rig], [tyre]"
        )
    rig, tyre = _section(path, document, "rig"), _section(path, document, "tyre")
    try:
        return Rig(**rig), Tyre(**tyre)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None


def with_declared(nominal: tuple[Rig, Tyre] | None, declared: Mapping[str, float]) -> tuple[Rig, Tyre]:
    """The nominal rig and tyre, overridden by what a recording says.

    Args:
        nominal: rig and tyre from elsewhere; None where only the recording knows them.
        declared: values by name, out of `DECLARABLE` (SI units).

    Raises:
        InvalidInputError: a, e or k is known from neither, or a value is outside its range.
    """
    values: dict[str, float] = {}
    if nominal is not None:
        values |= asdict(nominal[0]) | asdict(nominal[1])
    values |= declared
    missing = [key for keys in _REQUIRED.values() for key in keys if key not in values]
    if missing:
        raise InvalidInputError(
            f"{' and '.join(missing)} not known; name a rig file (--rig RIG.toml), or give a, e "
            "and k in the recording: lines such as '# a = 0.045' before a CSV header, scalars in "
            "a MAT file"
        )
    rig = {key: values[key] for key in _ALLOWED["rig"] if key in values}
    tyre = {key: values[key] for key in _ALLOWED["tyre"] if key in values}
    return Rig(**rig), Tyre(**tyre)


def _section(path: Path, document: Mapping[str, object], name: str) -> dict[str, float]:
    allowed = ", ".join(_ALLOWED[name])
    section = document.get(name)
    if not isinstance(section, dict):
        raise InvalidInputError(f"{path}: section [{name}] is missing; it holds {allowed}")
    for key, value in section.items():
        if key not in _ALLOWED[name]:
            raise InvalidInputError(f"{path}: [{name}] unknown key {excerpt(key)}; allowed: {allowed}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidInputError(
                f"{path}: [{name}] {key} must be a number, got {excerpt(str(value))}"
            )
    for key in _REQUIRED[name]:
        if key not in section:
            raise InvalidInputError(
                f"{path}: [{name}] {key} is missing; required: {', '.join(_REQUIRED[name])}"
            )
    return {key: float(value) for key, value in section.items()}
