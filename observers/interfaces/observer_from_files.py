"""An observer from the files that describe rig and model."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from observers.estimators.casadi_observer import CasadiObserver
from observers.interfaces.tuning_profiles import tuning_for
from observers.measurement.directional_friction import DirectionalFriction
from observers.measurement.measurement_model import AligningTorque
from observers.tuning import Tuning
from symbolic import (
    Effect,
    FoundModel,
    InvalidInputError,
    Model,
    Rig,
    Tyre,
    Vehicle,
    model_from_tables,
    rig_from_tables,
    vehicle_from_tables,
)
from symbolic.tables.toml_and_json_parsing import MAX_MODEL_SIZE, parse_json, parse_toml, prefix_errors

MODEL_FILE = "model.json"
"""Name of the model file in the folder of a diagnosis."""
Kind = TypeVar("Kind", bound=CasadiObserver)


def from_files(
    kind: Callable[..., Kind],
    rig: str | Path,
    model: str | Path | None = None,
    *,
    effects: Iterable[Effect] = (),
    tuning: Tuning | None = None,
    by_hand: Mapping[str, float] | None = None,
    ground: str | None = None,
    **settings: Any,
) -> Kind:
    """An observer from a rig file and, optionally, the model that a diagnosis found.

    Args:
        kind: `Ekf`, `Mhe` or another `CasadiObserver`.
        rig: the rig file, TOML with ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu`` in SI units; J_A and
            b_t are needed where the steering torque is measured, mu is not used.
        model: the folder of a diagnosis, or the model.json in it, whose k goes before that of the rig;
            None for the declared model. What belongs to one recording alone, as a torque zero, or to the
            taring of a bench stays neutral. Whether k is a state beside M_z is up to
            `aligning_torque_for`.
        effects: effects beside the library's that the model file may name.
        tuning: of an `Ekf` or `Mhe`, None for the usual one; the error of the model that the model file
            states goes before its own, see `observers.tuning_for`.
        by_hand: fields of the tuning that go before the model's error too, such as `error`.
        ground: the ground whose values are taken from the model file; the mean over its grounds for
            None or another one.
        settings: further fields of the observer, such as `measurement_model`.

    Raises:
        InvalidInputError: a file cannot be read, or holds what it must not, such as a value out of range
            or in another unit; or a setting is out of range. One line says which.
    """
    geometry, tyre = read_rig_file(rig)
    if "measurement_model" in settings:
        with prefix_errors(rig):
            settings["measurement_model"].check(geometry, Model())
    found = FoundModel(model=Model(), tyre={"k": tyre.k}, own={})
    if model is not None:
        found = read_model_file(model, effects)
    fields = getattr(kind, "__dataclass_fields__", {})
    if "measurement_model" in fields:
        settings.setdefault("measurement_model", aligning_torque_for(found))
    by_direction = isinstance(settings.get("measurement_model"), DirectionalFriction)
    if tuning is not None or by_hand or (found.error is not None and "tuning" in fields):
        settings["tuning"] = tuning_for(found, tuning, by_hand, by_direction=by_direction)
    return kind(
        model=found.model,
        values=found.values_for_estimation(ground),
        rig=found.rig_with_k_tolerance(geometry, tyre.k, ground),
        **settings,
    )


def aligning_torque_for(found: FoundModel | None) -> AligningTorque:
    """How M_z is measured by a model that was found, None for the declared one.

    By a model that explains something k is a state, as it differs a little between recordings; else it
    would pass for what the model lacks.
    """
    return AligningTorque(stiffness=found is not None and found.surpasses_declared)


def read_rig_file(path: str | Path) -> tuple[Rig, Tyre]:
    """Rig and tyre of a rig file, see `symbolic.rig_from_tables`; errors as of `from_files`."""
    with prefix_errors(path):
        return rig_from_tables(parse_toml(_content(path)))


def read_model_file(path: str | Path, effects: Iterable[Effect] = ()) -> FoundModel:
    """Model and values of a model file, or of the folder of a diagnosis with one.

    See `symbolic.model_from_tables`. It may name further effects; errors as of `from_files`.
    """
    path = model_file_in(Path(path))
    with prefix_errors(path):
        return model_from_tables(parse_json(_content(path)), effects)


def model_file_in(path: Path) -> Path:
    """The model file that a path names: itself, or that in the folder of a diagnosis, or an error."""
    try:
        if not path.is_dir():
            return path
        if (path / MODEL_FILE).is_file():
            return path / MODEL_FILE
    except (OSError, ValueError):  # Reading it says what is wrong.
        return path
    raise InvalidInputError(f"{path}: holds no {MODEL_FILE}, so it is not the folder of a diagnosis")


def read_vehicle_file(path: str | Path) -> Vehicle:
    """The vehicle of a vehicle file, see `symbolic.vehicle_from_tables`; errors as of `from_files`."""
    with prefix_errors(path):
        return vehicle_from_tables(parse_toml(_content(path)))


def _content(path: str | Path) -> bytes:
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise InvalidInputError("is a folder, a pipe or a device; allowed: a regular file")
        with path.open("rb") as file:
            content = file.read(MAX_MODEL_SIZE + 1)
        if len(content) > MAX_MODEL_SIZE:
            raise InvalidInputError(
                f"holds more than {MAX_MODEL_SIZE} bytes; that is no rig and no model"
            )
        return content
    except OSError as error:
        raise InvalidInputError(f"cannot be read: {error.strerror or error}") from None
