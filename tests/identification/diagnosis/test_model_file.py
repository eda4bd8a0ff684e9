import json
from dataclasses import replace
from math import hypot, log
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from identification import ParameterEstimate, Values, model_text, read_model
from observers import Tuning, tuning_for
from symbolic import (
    FoundModel,
    InvalidInputError,
    Model,
    ModelBasis,
    ModelError,
    Rig,
    Tolerances,
    effects_named,
    model_from_tables,
)
from symbolic.tables.found_model import mean_over_grounds
from tests.refusal import fault_of

SHARED = {"k": 2.4e6, "carcass_torsion.k_t": 390.0}
OWN = {"a": {"mu": 1.3, "torque_offset.M_0": 0.1}, "b": {"mu": 1.2, "torque_offset.M_0": -0.2}}
CONTENT = {
    "version": 1,
    "effects": ["carcass_torsion", "torque_offset"],
    "tyre": SHARED,
    "recordings": OWN,
}


UNITS = {"mu": "1", "k": "N/m^2", "carcass_torsion.k_t": "N m/rad", "torque_offset.M_0": "N m"}


def write(folder: Path, content: Any) -> Path:
    path = folder / "model.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def test_round_trip(tmp_path: Path) -> None:
    model = Model(effects=effects_named(CONTENT["effects"]), corners=16)
    error = ModelError(spread=0.03, correlation_time=0.4)
    basis = ModelBasis(training=2, holdout=0, grades={"carcass_torsion": "weak"}, loads=(380.0, 420.5))
    diagnosis = SimpleNamespace(
        model=model, values=Values(tyre=SHARED, own=OWN), model_error=error, basis=basis,
        parameters={"k": ParameterEstimate(value=2.4e6, std=5e4, unit="N/m^2")},
    )  # fmt: skip
    text = model_text(diagnosis)  # type: ignore[arg-type]
    found = read_model(write(tmp_path, text))

    table = {"spread": 0.03, "correlation_time": 0.4}
    expected = {**CONTENT, "grounds": {}, "rig": {}, "units": UNITS, "model_error": table}
    told = {"training": 2, "holdout": 0, "grades": {"carcass_torsion": "weak"}, "unexplained": False}
    told["loads"] = [380.0, 420.5]
    assert json.loads(text) == {**expected, "basis": told, "std": {"k": 5e4}}
    assert (found.error, found.basis, found.k_std) == (error, basis, 5e4)
    assert text.endswith("}\n")
    assert found.model.effects == model.effects
    assert (found.tyre, found.own) == (SHARED, OWN)


@pytest.mark.parametrize(
    ("std", "declared", "taken"),
    [
        (1e5, None, 3**0.5 * 1e5),
        (1e4, None, 0.05 * 2.4e6),
        (1e6, None, 0.2 * 2.4e6),
        (1e5, 2e4, 3**0.5 * 1e5),
        (None, 2e4, 2e4),
        (None, None, None),
    ],
    ids=[
        "found",
        "a tyre changes",
        "no better than usual",
        "the declared one is another",
        "not told",
        "unknown",
    ],
)
def test_k_is_known_as_closely_as_it_was_found(
    tmp_path: Path, std: float | None, declared: float | None, taken: float | None
) -> None:
    found = read_model(write(tmp_path, CONTENT if std is None else {**CONTENT, "std": {"k": std}}))
    declared_rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(k=declared, a=0.001))
    rig = found.rig_with_k_tolerance(declared_rig, 2.4e6)

    assert rig.tolerances.k == (None if taken is None else pytest.approx(taken))
    assert (rig.a, rig.tolerances.a, rig.tolerances.load) == (0.045, 0.001, None)


@pytest.mark.parametrize(
    ("declared", "tolerance", "off"),
    [(2.0e6, None, 0.0), (2.0e6, 4e5, log(1.2)), (3.0e6, 5e5, log(1.25)), (2.2e6, 0.0, log(2.4 / 2.2))],
    ids=["nothing declared", "within", "beyond", "beyond an exact one"],
)
def test_a_k_beyond_its_tolerance_may_be_the_torques_scale(
    tmp_path: Path, declared: float, tolerance: float | None, off: float
) -> None:
    found = read_model(write(tmp_path, CONTENT))
    declared_rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(k=tolerance, load=0.01))
    rig = found.rig_with_k_tolerance(declared_rig, declared)

    assert (rig.tolerances.load, rig.tolerances.scale) == (0.01, pytest.approx(0.5 * 3**0.5 * off))
    rough = replace(declared_rig, tolerances=replace(declared_rig.tolerances, scale=0.1))
    both = found.rig_with_k_tolerance(rough, declared).tolerances.scale
    assert both == pytest.approx(hypot(0.1, rig.tolerances.scale)), "a car declares one of its own"


@pytest.mark.parametrize(
    ("declared", "tolerance", "refused"),
    [
        (2.4e6 / 2.4, None, False), (2.4e6 / 2.6, None, True), (2.4e6 * 2.6, None, True),
        (1.55e6, 3.1e5, False), (1.45e6, 2.9e5, True), (2.2e6, 0.0, False), (2.0e6, 0.0, True),
    ],
)  # fmt: skip
def test_a_k_of_another_scale_is_refused(
    tmp_path: Path, declared: float, tolerance: float | None, refused: bool
) -> None:
    found = read_model(write(tmp_path, CONTENT))
    rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(k=tolerance))

    if not refused:
        found.rig_with_k_tolerance(rig, declared)
        return
    said = r"times the declared one.*check the torque with a weight"
    with pytest.raises(InvalidInputError, match=said):
        found.rig_with_k_tolerance(rig, declared)


@pytest.mark.parametrize(
    ("grades", "unexplained", "error"),
    [({}, True, 0.05), ({"weak": "weak"}, True, 0.05), ({"a": "strong"}, True, None), ({}, False, None)],
)
def test_a_diagnosis_that_explains_nothing_makes_no_model_better(
    grades: dict[str, str], unexplained: bool, error: float | None
) -> None:
    basis = ModelBasis(training=2, holdout=1, grades=grades, unexplained=unexplained)
    measured = ModelError(spread=0.01, relative=0.01, correlation_time=0.2)
    found = FoundModel(model=Model(), tyre={"k": 2e6}, own={}, error=measured, basis=basis)
    taken = tuning_for(found)

    assert taken.error == error if error is not None else taken.error < 0.03
    if basis.explains_nothing:
        larger = replace(found, error=replace(measured, relative=0.1))
        assert (taken, tuning_for(larger)) == (Tuning(), Tuning(error=0.1))


def test_the_k_of_a_ground_is_its_own(tmp_path: Path) -> None:
    found = read_model(write(tmp_path, GROUNDS))
    rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(k=8e5, load=0.01))

    assert found.rig_with_k_tolerance(rig, 5.4e6, "steel") == rig
    off = found.rig_with_k_tolerance(rig, 5.4e6, "emery").tolerances
    assert off.scale == pytest.approx(0.5 * 3**0.5 * log(5.4 / 4.0))
    assert off.k == 8e5


def test_values_for_a_recording(tmp_path: Path) -> None:
    found = read_model(str(write(tmp_path, CONTENT)))

    assert found.values_for_recording("a") == {**SHARED, **OWN["a"]}
    assert found.values_for_recording("a", mu=2.0)["mu"] == 1.3, (
        "what was found goes before what was declared"
    )
    assert found.values_for_recording("new", mu=0.9) == {**SHARED, "mu": 0.9, "torque_offset.M_0": 0.0}
    found.model.theta(found.values_for_recording("new", mu=0.9))
    with pytest.raises(InvalidInputError, match=r"new: no mu in the model file .* under \[tyre\]"):
        found.values_for_recording("new")


GROUNDS = {
    **CONTENT,
    "effects": ["frictional_creep", "stiffness_by_ground", "friction_by_ground"],
    "tyre": {},
    "grounds": {
        "steel": {"k": 5.4e6, "frictional_creep.c": 0.2},
        "emery": {"k": 4.0e6, "frictional_creep.c": 0.05},
    },
    "recordings": {"a": {"mu": 1.3}},
    "rig": {"a": {"a": 0.0462, "load": 0.99}},
}


def test_values_of_a_ground(tmp_path: Path) -> None:
    found = read_model(write(tmp_path, GROUNDS))
    model = Model(effects=effects_named(GROUNDS["effects"]))
    values = Values(tyre={}, own=found.own, grounds=found.grounds, rig=found.rig)
    basis = ModelBasis(training=1, holdout=0)
    diagnosis = SimpleNamespace(model=model, values=values, model_error=None, basis=basis, parameters={})
    written = model_text(diagnosis)  # type: ignore[arg-type]

    assert json.loads(written) == {
        **GROUNDS,
        "basis": {"training": 1, "holdout": 0, "grades": {}, "unexplained": False},
        "units": {"mu": "1", "k": "N/m^2", "frictional_creep.c": "1"},
    }
    assert found.values_for_recording("a", ground="steel") == {
        "mu": 1.3,
        "k": 5.4e6,
        "frictional_creep.c": 0.2,
    }
    assert found.values_for_estimation("emery") == {"k": 4.0e6, "frictional_creep.c": 0.05}
    mean = pytest.approx({"k": (5.4e6 * 4.0e6) ** 0.5, "frictional_creep.c": 0.1})
    assert found.values_for_estimation() == mean
    assert found.values_for_estimation("ice") == mean
    assert found.ground_used_text("steel") == "values of steel"
    assert found.ground_used_text() == "ground not given: mean of steel and emery"
    assert found.ground_used_text("ice") == "ice is unknown: mean of steel and emery"
    assert found.rig == GROUNDS["rig"]
    without = read_model(write(tmp_path, CONTENT))
    assert without.ground_used_text() == ""
    assert without.ground_used_text("ice") == "ice: the model has the same values on every ground"


def test_what_may_be_left_out_and_what_an_older_version_wrote(tmp_path: Path) -> None:
    for units in ({}, {"k": "N/m^2"}, UNITS):
        assert read_model(write(tmp_path, {**CONTENT, "units": units})).tyre == SHARED
    content = {name: value for name, value in CONTENT.items() if name != "recordings"}
    bare = read_model(write(tmp_path, content))
    assert (bare.own, bare.error, bare.basis) == ({}, None, None)
    older = {name: value for name, value in CONTENT.items() if name != "tyre"}
    assert read_model(write(tmp_path, {**older, "shared": SHARED})).tyre == SHARED
    assert fault_of(read_model, write(tmp_path, older)).startswith("'tyre' must be a table of numbers")


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"version": 2}, "not a model file of version 1"),
        ({"version": None}, "not a model file of version 1"),
        ({"effects": None}, "'effects' must be a list of effect names"),
        ({"effects": "carcass_torsion"}, "'effects' must be a list of effect names"),
        ({"effects": [1]}, "'effects' must be a list of effect names"),
        ({"effects": ["magic"]}, "unknown effect 'magic'; known are asymmetric_friction"),
        ({"effects": ["torque_offset"] * 2}, "effect 'torque_offset' is named twice"),
        ({"tyre": None}, "'tyre' must be a table of numbers"),
        ({"tyre": [2.4e6]}, "'tyre' must be a table of numbers"),
        ({"tyre": {"k": 2.4e6}}, "'tyre' lacks carcass_torsion.k_t [N m/rad]"),
        ({"tyre": {**SHARED, "k": "stiff"}}, "tyre.k must be a number, got 'stiff'"),
        ({"tyre": {**SHARED, "k": True}}, "tyre.k must be a number, got 'True'"),
        ({"tyre": {**SHARED, "k": -2.4e6}}, "tyre.k must lie in [1000.0, 1000000000.0] N/m^2"),
        ({"tyre": {**SHARED, "k": float("nan")}}, "tyre.k must lie in"),
        ({"tyre": {**SHARED, "k": 10**400}}, "tyre holds a number too large"),
        ({"tyre": {**SHARED, "wings": 2}}, "tyre holds an unknown 'wings'; the model has mu, k"),
        ({"recordings": []}, "'recordings' must hold one table per recording"),
        ({"recordings": {"a": 3}}, "'recordings.a' must be a table of numbers"),
        ({"recordings": {"a": {"mu": None}}}, "recordings.a.mu must be a number, got 'None'"),
        ({"recordings": {"a": {"mu": 0}}}, "recordings.a.mu must lie in [0.01, 10.0] 1, got 0.0"),
        ({"units": ["N m"]}, "'units' must be a table of units"),
        ({"units": {"k": "N/mm^2"}}, "k has the unit 'N/mm^2', expected 'N/m^2'; convert the value"),
        ({"units": {**UNITS, "torque_offset.M_0": None}}, "torque_offset.M_0 has the unit 'None'"),
        ({"units": {"wings": "1"}}, "units holds an unknown 'wings'; the model has mu, k"),
        ({"model_error": 0.03}, "'model_error' must be a table of numbers"),
        ({"model_error": {"spread": 0.03}}, "'model_error' must hold spread and correlation_time"),
        (
            {"model_error": {"spread": -0.03, "correlation_time": 1}},
            "model_error: spread must be a finite number of at least 0, got -0.03",
        ),
        (
            {"model_error": {"spread": 0.03, "correlation_time": 0}},
            "model_error: correlation_time must be a finite number greater than 0 s, got 0.0",
        ),
        ({"basis": {"training": 1}}, "'basis' must hold training, holdout and grades"),
        ({"basis": {"training": -1, "holdout": 0, "grades": {}}}, "basis: training must be a whole"),
        ({"basis": {"training": 1, "holdout": 0, "grades": {"x": "weak"}}}, "basis.grades holds an"),
        ({"basis": {"training": 1, "holdout": 0, "grades": {"torque_offset": 1}}}, "'basis.grades'"),
        *(
            ({"basis": {"training": 1, "holdout": 0, "grades": {}, "loads": loads}}, message)
            for loads, message in (
                (400.0, "'basis.loads' must be a list of two"),
                ([400.0], "'basis.loads' must be a list of two"),
                (["a", 400.0], "basis.loads.least must be a number"),
                ([0.0, 400.0], "basis: loads must be greater than 0, in order"),
                ([500.0, 400.0], "basis: loads must be greater than 0, in order"),
            )
        ),
        ({"std": {"mu": 0.1}}, "std holds an unknown 'mu'; allowed: k"),
        ({"std": {"k": -1}}, "k_std must be a finite number of at least 0, got -1"),
        ({**GROUNDS, "std": {"k": 1e5}}, "std holds an unknown 'k'; allowed: "),
        ({**GROUNDS, "grounds": {}}, "'grounds' lacks k [N/m^2]"),
        ({**GROUNDS, "grounds": []}, "'grounds' must hold one table per ground"),
        ({**GROUNDS, "grounds": {"steel": {"k": 5e6}}}, "'grounds.steel' lacks frictional_creep.c [1]"),
        ({**GROUNDS, "grounds": {"steel": {"k": 5.0}}}, "grounds.steel.k must lie in"),
        ({**GROUNDS, "rig": {"a": {"b": 1}}}, "rig.a holds an unknown 'b'; allowed: a, e, load, zero"),
        ({**GROUNDS, "rig": 1}, "'rig' must hold one table per recording"),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_faults(tmp_path: Path, change: dict[str, Any], word: str) -> None:
    assert fault_of(read_model, write(tmp_path, {**CONTENT, **change})).startswith(word)


def test_no_model_at_all(tmp_path: Path) -> None:
    for text in ("", "{", "effects: []", '{"version": 1', "[1]", "1"):
        message = fault_of(read_model, write(tmp_path, text))
        assert message.startswith(("not a JSON file", "not a model file"))
    path = tmp_path / "model.json"
    path.write_bytes(b"\xff\xfe\x00")
    assert fault_of(read_model, path).startswith("not a JSON file")
    assert fault_of(read_model, tmp_path / "none.json") == "no such file"
    assert fault_of(read_model, tmp_path) == "is a directory, expected a file"


def test_a_sensor_that_was_not_tared_begins_neutral() -> None:
    """The torque of a controller was not set to zero on the twist that the bench had."""
    values = {"k": 2e6, "tared_pretwist.psi_0": 0.002, "tared_pretwist.M_0": 0.3}
    found = FoundModel(model=Model(effects=effects_named(["tared_pretwist"])), tyre=values, own={})

    neutral = {"tared_pretwist.psi_0": 0.0, "tared_pretwist.M_0": 0.0}
    assert found.values_for_estimation() == values | neutral
    assert found.values_for_estimation(tared=True) == values


def test_a_model_file_may_give_one_drift_for_all_grounds() -> None:
    drift = {"friction_drift.gain": 0.2, "friction_drift.scale": 0.3}
    found = model_from_tables({"version": 1, "effects": ["friction_drift"], "tyre": {"k": 2e6, **drift}})

    assert found.values_for_estimation("steel") == {"k": 2e6, **drift}


def test_the_mean_over_grounds_of_a_drift_that_one_ground_hardly_has() -> None:
    gains = [{"friction_drift.gain": gain} for gain in (0.26, 0.002)]
    mean = mean_over_grounds({"steel": gains[0], "emery": gains[1]})

    assert mean["friction_drift.gain"] == pytest.approx(0.131)
