"""An observer from the files that describe rig and model."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from observers.casadi_observer import CasadiObserver
from symbolic.errors import InvalidInputError
from symbolic.model import Model
from symbolic.parameters import Rig, Tyre
from symbolic.parsing import json_of, naming, toml_of
from symbolic.serialisation import FoundModel, model_described, rig_described

Kind = TypeVar("Kind", bound=CasadiObserver)


def from_files(
    kind: Callable[..., Kind], rig: str | Path, model: str | Path | None = None, **settings: Any
) -> Kind:
    """An observer from a rig file and, optionally, the file of a model that a diagnosis found.

    Args:
        kind: `Ekf`, `Mhe` or another `CasadiObserver`.
        rig: the rig file, TOML with ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu`` in SI units; J_A and
            b_t are needed where the steering torque is measured, mu is not used.
        model: the model file that `brushgrip diagnose` writes, whose k goes before that of the rig; None
            for the declared model. What belongs to one recording alone, as a torque zero, stays neutral.
        settings: further fields of the observer, such as `tuning` and `measurement_model`.

    Raises:
        InvalidInputError: a file cannot be read, or holds what it must not, such as a value out of range
            or in another unit; or a setting is out of range. One line says which.
    """
    geometry, tyre = read_rig_file(rig)
    if "measurement_model" in settings:
        with naming(rig):
            settings["measurement_model"].check(geometry, Model())
    found = FoundModel(model=Model(), shared={"k": tyre.k}, own={})
    if model is not None:
        found = read_model_file(model)
    return kind(model=found.coming_model(), values=found.coming_values(), rig=geometry, **settings)


def read_rig_file(path: str | Path) -> tuple[Rig, Tyre]:
    """Rig and tyre of a rig file, see `symbolic.serialisation.rig_described`.

    Raises:
        InvalidInputError: the file cannot be read or is no rig file; one line says what is wrong.
    """
    with naming(path):
        return rig_described(toml_of(_content(path)))


def read_model_file(path: str | Path) -> FoundModel:
    """Model and values of a model file, see `symbolic.serialisation.model_described`.

    Raises:
        InvalidInputError: the file cannot be read or is no model file; one line says what is wrong.
    """
    with naming(path):
        return model_described(json_of(_content(path)))


def _content(path: str | Path) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InvalidInputError(f"cannot be read: {error.strerror or error}") from None
