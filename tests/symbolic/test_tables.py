"""Rig, tyre and model from tables; text and tables from bytes. Files are read, and named, elsewhere."""

import json
import tomllib

import pytest

from symbolic import (
    EFFECTS,
    InvalidInputError,
    Model,
    effects_named,
    model_from_tables,
    parameter_name,
    rig_from_tables,
    units_of,
)
from symbolic.tables.found_model_from_tables import MODEL_VERSION
from symbolic.tables.toml_and_json_parsing import (
    decode_text,
    excerpt,
    parse_json,
    parse_toml,
    prefix_errors,
)
from tests.refusal import refused


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


def test_tables_of_text_have_each_key_once() -> None:
    assert parse_toml(b"\xef\xbb\xbf[rig]\na = 0.04\n") == tomllib.loads("[rig]\na = 0.04\n")
    assert parse_json(b"\xef\xbb\xbf" + json.dumps({"version": 1}).encode()) == {"version": 1}
    assert decode_text("ψ\r\n".encode()) == "ψ\r\n"
    assert parse_json(b'{"a": {"k": 1}, "b": {"k": 2}}') == {"a": {"k": 1}, "b": {"k": 2}}
    with pytest.raises(InvalidInputError, match="'k' is given twice in one object; allowed: once"):
        parse_json(b'{"shared": {"k": 1, "mu": 2, "k": 3}}')


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
    assert refused(parse_toml, content).startswith(fault)


def test_a_number_that_is_too_long_to_show() -> None:
    with pytest.raises(InvalidInputError, match="J_A must be a number, got a number of more digits"):
        rig_from_tables({"rig": {"a": 0.04, "e": 0.0, "J_A": [16**4000]}, "tyre": {"k": 1e6}})


def test_naming_puts_the_source_before() -> None:
    with pytest.raises(InvalidInputError) as caught, prefix_errors("rig.toml"):
        raise InvalidInputError("is empty")
    assert str(caught.value) == "rig.toml: is empty"
    with pytest.raises(ZeroDivisionError), prefix_errors("rig.toml"):
        raise ZeroDivisionError


def test_excerpts_are_short_and_on_one_line() -> None:
    assert excerpt("a\nb") == r"'a\nb'"
    assert len(excerpt("x" * 500)) < 50
