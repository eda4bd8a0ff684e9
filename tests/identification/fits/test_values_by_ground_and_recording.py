"""Values of tyre, grounds and recordings, and what becomes of them where effects move their scope."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Values
from identification.fits.values_by_ground_and_recording import (
    UNNAMED_GROUND,
    complete_values,
    grounds_of,
    replaced_rig,
)
from symbolic import InvalidInputError, Model, Tolerances, effects_named
from tests.identification.factories import recording

TOGETHER = Model(effects=effects_named(["frictional_creep"]))
APART = Model(effects=effects_named(["frictional_creep", "stiffness_by_ground", "friction_by_ground"]))


ONE, TWO, OTHER = recording("one", "steel"), recording("two", "emery"), recording("other", "ice")
SAME = Values(tyre={"k": 2e6, "frictional_creep.c": 0.1}, own={"one": {"mu": 1.0}, "two": {"mu": 1.2}})


def test_every_ground_begins_with_the_value_of_the_tyre() -> None:
    values = complete_values(APART, SAME, [ONE, TWO])

    assert values.tyre == {}
    own = {"k": 2e6, "frictional_creep.c": 0.1}
    assert values.grounds == {"steel": own, "emery": own}
    assert values.of(TWO) == {"mu": 1.2, "k": 2e6, "frictional_creep.c": 0.1}


def test_a_ground_that_nothing_is_known_of_has_the_geometric_mean() -> None:
    grounds = {
        "steel": {"k": 5.4e6, "frictional_creep.c": 0.2},
        "emery": {"k": 4.0e6, "frictional_creep.c": 0.05},
    }
    own = {"other": {"mu": 1.0}}
    values = complete_values(APART, Values(tyre={}, own=own, grounds=grounds), [OTHER])

    assert values.grounds.keys() == {"ice"}
    assert values.of(OTHER)["k"] == pytest.approx(np.sqrt(5.4e6 * 4.0e6))
    assert values.of(OTHER)["frictional_creep.c"] == pytest.approx(0.1)


def test_values_of_two_signs_have_the_arithmetic_mean() -> None:
    model = Model(effects=effects_named(["rate_friction", "friction_by_ground"]))
    grounds = {"steel": {"rate_friction.c": 0.1}, "emery": {"rate_friction.c": -0.04}}
    start = Values(tyre={"k": 2e6}, own={"other": {"mu": 1.0}}, grounds=grounds)
    values = complete_values(model, start, [OTHER])

    assert values.of(OTHER)["rate_friction.c"] == pytest.approx(0.03)
    same_sign = {"steel": {"rate_friction.c": -0.09}, "emery": {"rate_friction.c": -0.04}}
    values = complete_values(model, replace(start, grounds=same_sign), [OTHER])
    assert values.of(OTHER)["rate_friction.c"] == pytest.approx(-0.06)


def test_the_tyre_has_the_mean_where_nothing_belongs_to_grounds_any_more() -> None:
    grounds = {
        "steel": {"k": 4e6, "frictional_creep.c": 0.2},
        "emery": {"k": 1e6, "frictional_creep.c": 0.2},
    }
    values = complete_values(TOGETHER, Values(tyre={}, own=SAME.own, grounds=grounds), [ONE, TWO])

    assert values.grounds == {}
    assert values.tyre == pytest.approx({"k": 2e6, "frictional_creep.c": 0.2})


def test_recordings_without_a_ground_stand_on_one_of_their_own() -> None:
    assert grounds_of([ONE, recording("none", None), TWO]) == ("steel", UNNAMED_GROUND, "emery")
    said = r"ground 'two' has the name .* give the ground another name \(--ground"
    with pytest.raises(InvalidInputError, match=said):
        grounds_of([recording("one", "two"), TWO])


def test_the_owner_of_a_value() -> None:
    exact = replace(SAME, grounds={"steel": {"k": 3e6}}, rig={"one": {"a": 0.046, "load": 1.01}})
    labels = [(None, "k"), ("steel", "k"), ("one", "mu"), ("one", "a")]
    changed = exact.having(dict.fromkeys(labels, 7.0))

    assert [exact.at(label) for label in labels] == [2e6, 3e6, 1.0, 0.046]
    assert [changed.at(label) for label in labels] == [7.0] * 4
    assert changed.at(("two", "mu")) == 1.2


def test_what_is_declared_with_a_tolerance_begins_as_declared() -> None:
    tolerated = recording("one", None, a=0.002, zero=0.1)
    values = complete_values(Model(), replace(SAME, rig={"one": {"a": 0.06}}), [tolerated, TWO])

    assert values.rig == {"one": {"a": pytest.approx(0.047), "zero": 0.0}}, "within its tolerance"
    found = replaced_rig(tolerated, replace(SAME, rig={"one": {"a": 0.044, "load": 1.02}}))
    assert found.rig.a == 0.044
    assert found.rig.tolerances == Tolerances()
    np.testing.assert_allclose(found.F_N, 306.0)
    assert replaced_rig(TWO, values) is TWO


def test_scopes() -> None:
    scopes = {p.name: p.scope for _, p in APART.parameters}

    assert scopes == {"mu": "recording", "k": "ground", "c": "ground"}
    assert {p.name: p.scope for _, p in TOGETHER.parameters}["k"] == "tyre"
    fixed = Model(effects=effects_named(["contact_length", "friction_by_ground"]))
    assert {p.scope for effect, p in fixed.parameters if effect} == {"tyre"}
