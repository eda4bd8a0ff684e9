"""Observers from files say what those built by hand say, and faults name their file."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from observers import AligningTorque, DirectionalFriction, Ekf, Mhe, SteeringTorque, Tuning, from_files
from observers.interfaces.observer_from_files import read_model_file, read_rig_file
from symbolic import Effect, Model, Rig, Tyre, effects_named
from tests.refusal import refused

TOML = "[rig]\na = 0.045\ne = 0.009\nJ_A = 0.15\nb_t = 1.0\n\n[tyre]\nk = 2.8e6\nmu = 1.1\n"
FOUND = {
    "version": 1,
    "effects": ["carcass_torsion", "torque_offset"],
    "shared": {"k": 2.4e6, "carcass_torsion.k_t": 390.0},
    "recordings": {"rig": {"mu": 0.4, "torque_offset.M_0": 3.0}},
    "units": {"k": "N/m^2", "carcass_torsion.k_t": "N m/rad"},
}
WHOLE = Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.0)


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(TOML, encoding="utf-8")
    return path


def write_model(folder: Path, **changes: Any) -> Path:
    path = folder / "model.json"
    path.write_text(json.dumps({**FOUND, **changes}), encoding="utf-8")
    return path


message_of = partial(refused, from_files)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_the_declared_model_has_the_k_of_the_rig(kind: Any, rig: Path) -> None:
    tuning = Tuning(noise=0.1)

    expected = kind(model=Model(), values={"k": 2.8e6}, rig=WHOLE, tuning=tuning)
    assert from_files(kind, rig, tuning=tuning) == expected


def test_friction_of_each_direction_replaces_the_models_ratio(rig: Path, tmp_path: Path) -> None:
    ratio = "asymmetric_friction.ratio"
    shared = {"k": 2.4e6, ratio: 0.8}
    write_model(tmp_path, effects=["asymmetric_friction"], shared=shared, recordings={}, units={})

    assert from_files(Ekf, rig, tmp_path).values[ratio] == 0.8
    directed = from_files(Ekf, rig, tmp_path, measurement_model=DirectionalFriction())
    assert directed.values[ratio] == 1


def test_a_model_that_was_found(rig: Path, tmp_path: Path) -> None:
    observer = from_files(Mhe, str(rig), str(write_model(tmp_path)), window=7)
    effects = effects_named(["carcass_torsion", "torque_offset"])

    assert observer.model == Model(effects=effects, discretised=True)
    assert from_files(Mhe, rig, tmp_path, window=7) == observer
    # The k of the model goes before that of the rig; nothing fitted to one recording is believed.
    assert observer.values == {"k": 2.4e6, "carcass_torsion.k_t": 390.0, "torque_offset.M_0": 0.0}
    # Beside the declared model k would pass for what that lacks.
    assert (observer.window, observer.measurement_model) == (7, AligningTorque(stiffness=True))
    assert from_files(Mhe, rig).measurement_model == AligningTorque()
    assert observer.rig == WHOLE
    write_model(tmp_path, std={"k": 1e5})
    assert from_files(Mhe, rig, tmp_path).rig.tolerances.k == pytest.approx(3**0.5 * 1e5)


def test_what_the_files_hold(rig: Path, tmp_path: Path) -> None:
    assert read_rig_file(rig) == (WHOLE, Tyre(k=2.8e6, mu=1.1))
    assert read_model_file(write_model(tmp_path)).own == FOUND["recordings"]


def test_faults_name_their_file(rig: Path, tmp_path: Path) -> None:
    model = write_model(tmp_path, shared={"k": 2.4e6})
    lacking = f"{model}: 'shared' lacks carcass_torsion.k_t [N m/rad]"
    assert message_of(Ekf, rig, model).startswith(lacking)
    for text, fault in (
        (TOML.replace("a = 0.045", "a = 45"), "a must be given in metres, at most 1 m in size, got 45"),
        (TOML.replace("e = 0.009", "e = "), "is not valid TOML: "),
        ("", "is empty"),
    ):
        rig.write_text(text, encoding="utf-8")
        assert message_of(Ekf, rig).startswith(f"{rig}: {fault}")


def test_files_that_are_not_there(rig: Path, tmp_path: Path) -> None:
    none = tmp_path / "none"

    assert message_of(Ekf, none) == f"{none}: cannot be read: No such file or directory"
    assert message_of(Ekf, rig, none) == f"{none}: cannot be read: No such file or directory"
    assert message_of(Ekf, tmp_path).startswith(f"{tmp_path}: is a folder, a pipe or a device")
    said = "holds no model.json, so it is not the folder of a diagnosis"
    assert message_of(Ekf, rig, tmp_path).endswith(said)


def test_the_steering_torque_needs_the_wheel(rig: Path) -> None:
    assert from_files(Ekf, rig, measurement_model=SteeringTorque()).rig.J_A == 0.15
    rig.write_text(TOML.replace("J_A = 0.15\n", ""), encoding="utf-8")

    assert from_files(Ekf, rig).rig.J_A is None
    message = message_of(Ekf, rig, measurement_model=SteeringTorque())
    assert message.startswith(f"{rig}: the rig lacks J_A")


def test_faults_of_settings_name_no_file(rig: Path) -> None:
    assert message_of(Mhe, rig, window=0).startswith("window must be a whole number of at least 1")


def test_a_model_with_an_effect_of_the_users_own(rig: Path, tmp_path: Path) -> None:
    own = Effect(name="own", summary="the user's own", parameters=())
    path = write_model(tmp_path, effects=[*FOUND["effects"], "own"])

    assert own in from_files(Ekf, rig, path, effects=[own]).model.effects
    assert "--effects MODULE" in message_of(Ekf, rig, path)
