"""Rig, tyre and model from tables; text and tables from bytes. Files are read, and named, elsewhere."""

import json
import tomllib
from typing import Any

import pytest

from symbolic import (
    EFFECTS,
    FoundModel,
    InvalidInputError,
    Model,
    Rig,
    Tyre,
    effects_named,
    model_from_tables,
    parameter_name,
    rig_from_tables,
    units_of,
)
from symbolic.tables.model_tables import MODEL_VERSION
from symbolic.tables.parsing import excerpt, json_of, naming, text_of, toml_of
from symbolic.tables.rig_tables import rig_from_values
from tests.refusal import refused

RIG = {"rig": {"a": 0.045, "e": 0.009, "J_A": 0.15, "b_t": 1}, "tyre": {"k": 2_400_000, "mu": 1.5}}
MODEL = {
    "version": MODEL_VERSION,
    "effects": ["carcass_torsion", "torque_offset", "pretwist"],
    "tyre": {"k": 2.4e6, "carcass_torsion.k_t": 390},
    "recordings": {"a": {"mu": 1.3, "torque_offset.M_0": 0.1, "pretwist.psi_0": 0.02}},
}


def changed(document: dict[str, Any], place: str, **values: Any) -> dict[str, Any]:
    return {**document, place: {**document[place], **values}}


def test_a_rig() -> None:
    rig, tyre = rig_from_tables(RIG)

    assert (rig, tyre) == (Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.0), Tyre(k=2.4e6, mu=1.5))
    assert isinstance(tyre.k, float)
    least = rig_from_tables({"rig": {"a": 1.0, "e": 0}, "tyre": {"k": 1e4}})
    assert least == (Rig(a=1.0, e=0.0), Tyre(k=1e4))


@pytest.mark.parametrize(
    ("document", "fault"),
    [
        ({}, "section [rig] is missing; it holds a, e, J_A, b_t, slide_rate"),
        ({"rig": RIG["rig"]}, "section [tyre] is missing; it holds k, mu"),
        (changed(RIG, "rig", a=45), "a must be given in metres, at most 1 m in size, got 45; if"),
        (changed(RIG, "rig", e=9.0), "e must be given in metres, at most 1 m in size, got 9; if"),
        (changed(RIG, "rig", a=True), "[rig] a must be a number, got 'True'"),
        (changed(RIG, "rig", J=0.1), "[rig] unknown key 'J'; allowed: a, e, J_A, b_t, slide_rate"),
        (changed(RIG, "tyre", k=2.4), "k must lie between 1000 and 1e+09 N/m^2, got 2.4"),
        (changed(RIG, "tyre", k=10**400), "[tyre] holds a number too large to compute with"),
        ({**RIG, "wheel": {}}, "unknown section or key 'wheel'; allowed: [rig], [tyre]"),
    ],
)
def test_faults_of_a_rig(document: dict[str, Any], fault: str) -> None:
    assert refused(rig_from_tables, document).startswith(fault)


def test_values_go_before_the_nominal_ones() -> None:
    nominal = (Rig(a=0.045, e=0.009, J_A=0.15), Tyre(k=2.4e6))

    assert rig_from_values({}, nominal) == nominal
    assert rig_from_values({"a": 0.05, "mu": 0.9}, nominal) == (
        Rig(a=0.05, e=0.009, J_A=0.15),
        Tyre(k=2.4e6, mu=0.9),
    )


def test_a_model() -> None:
    found = model_from_tables(MODEL)

    assert found.model == Model(effects=effects_named(MODEL["effects"]))
    assert found.tyre == MODEL["tyre"]
    assert found.own == MODEL["recordings"]
    assert isinstance(found.tyre["carcass_torsion.k_t"], float)


def test_values_for_what_is_to_come_leave_recordings_out() -> None:
    found = model_from_tables(changed(MODEL, "tyre", mu=1.1))
    values = found.values_for_estimation()

    assert values == {
        "k": 2.4e6,
        "carcass_torsion.k_t": 390.0,
        "torque_offset.M_0": 0.0,
        "pretwist.psi_0": 0.0,
    }
    found.model.theta({**values, "mu": 1.0})
    assert found.values_for("new", 0.9) == {**values, "mu": 0.9}


def test_the_declared_model_needs_k_alone() -> None:
    assert FoundModel(model=Model(), tyre={"k": 2e6}, own={}).values_for_estimation() == {"k": 2e6}


@pytest.mark.parametrize(
    ("document", "fault"),
    [
        (None, "not a model file of version 1"),
        ([1], "not a model file of version 1"),
        ({**MODEL, "version": 2}, "not a model file of version 1"),
        ({**MODEL, "effects": "pretwist"}, "'effects' must be a list of effect names"),
        ({**MODEL, "effects": ["magic"]}, "unknown effect 'magic'"),
        ({**MODEL, "tyre": None}, "'tyre' must be a table of numbers"),
        ({**MODEL, "tyre": {"k": 2.4e6}}, "'tyre' lacks carcass_torsion.k_t [N m/rad]"),
        ({**MODEL, "recordings": 3}, "'recordings' must hold one table per recording"),
        ({**MODEL, "units": "SI"}, "'units' must be a table of units"),
        ({**MODEL, "units": {"mass": "kg"}}, "units holds an unknown 'mass'; the model has mu, k,"),
        (changed(MODEL, "tyre", k="2"), "tyre.k must be a number, got '2'"),
        (changed(MODEL, "tyre", k=2.4), "tyre.k must lie in [1000.0, 1000000000.0] N/m^2, got 2.4"),
        (changed(MODEL, "tyre", k=float("nan")), "tyre.k must lie in"),
        (changed(MODEL, "recordings", b={"mu": 99}), "recordings.b.mu must lie in"),
    ],
)
def test_faults_of_a_model(document: Any, fault: str) -> None:
    assert refused(model_from_tables, document).startswith(fault)


@pytest.mark.parametrize("effect", EFFECTS)
def test_another_unit_is_refused(effect: str) -> None:
    model = Model(effects=effects_named([effect]))
    values = {parameter_name(e, p): p.start for e, p in model.parameters}
    document = {"version": MODEL_VERSION, "effects": [effect], "tyre": values}
    units = units_of(model)

    assert list(units) == list(values)
    assert model_from_tables({**document, "units": units}).tyre == values
    for name, unit in units.items():
        message = refused(model_from_tables, {**document, "units": {**units, name: "furlong"}})
        assert message == f"{name} has the unit 'furlong', expected '{unit}'; convert the value"


def test_tables_of_text() -> None:
    assert toml_of(b"\xef\xbb\xbf[rig]\na = 0.04\n") == tomllib.loads("[rig]\na = 0.04\n")
    assert json_of(b"\xef\xbb\xbf" + json.dumps(MODEL).encode()) == MODEL
    assert text_of("ψ\r\n".encode()) == "ψ\r\n"


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b" \n", "is empty"),
        (b"a = 1\nb = \xe9\n", "row 2: is not text, byte 0xe9 is not UTF-8"),
        (b"a = 1\n\0", "row 2: is not text, it holds a zero byte"),
        (b"a = ", "is not valid TOML: "),
        (b"a = 1\na = 2\n", "is not valid TOML: "),
        (b"a = " + b"[" * 10_000, "row 1: is not valid TOML for a rig: 20 tables within each other"),
        (b"a = 1\n" + b"a." * 20 + b"a = 1", "row 2: is not valid TOML for a rig: 20 tables"),
        (b"a = " + b"9" * 5000, "is not valid TOML: "),
        (b"#" * 16_385, "holds 16385 bytes; allowed: up to 16384"),
    ],
    ids=["empty", "latin", "zero", "no value", "twice", "deep", "dotted", "digits", "large"],
)
def test_no_toml(content: bytes, fault: str) -> None:
    assert refused(toml_of, content).startswith(fault)


def test_a_number_that_is_too_long_to_show() -> None:
    with pytest.raises(InvalidInputError, match="J_A must be a number, got a number of more digits"):
        rig_from_tables({"rig": {"a": 0.04, "e": 0.0, "J_A": [16**4000]}, "tyre": {"k": 1e6}})


def test_a_key_that_stands_twice() -> None:
    assert json_of(b'{"a": {"k": 1}, "b": {"k": 2}}') == {"a": {"k": 1}, "b": {"k": 2}}
    with pytest.raises(InvalidInputError, match="'k' is given twice in one object; allowed: once"):
        json_of(b'{"shared": {"k": 1, "mu": 2, "k": 3}}')


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe\x00", b"[" * 100_000])
def test_no_json(content: bytes) -> None:
    with pytest.raises(InvalidInputError, match="not a JSON file: "):
        json_of(content)


def test_naming_puts_the_source_before() -> None:
    with pytest.raises(InvalidInputError) as caught, naming("rig.toml"):
        raise InvalidInputError("is empty")
    assert str(caught.value) == "rig.toml: is empty"
    with pytest.raises(ZeroDivisionError), naming("rig.toml"):
        raise ZeroDivisionError


def test_excerpts_are_short_and_on_one_line() -> None:
    assert excerpt("a\nb") == r"'a\nb'"
    assert len(excerpt("x" * 500)) < 50
