"""When an effect is worth adding: errors made up such that each figure is known beforehand."""

from dataclasses import replace

import numpy as np
import pytest

from identification.selection.criteria import (
    DEFAULT_CRITERIA,
    SelectionCriteria,
    addition_justified,
    delta_bic,
    distinguishable,
    exchange_justified,
    family_already_present,
    has_redundant_zero_effects,
    recordings_allow,
)
from symbolic import InvalidInputError, effects_named
from tests.identification.factories import recording
from tests.identification.selection.compared import SECONDS, Pair, compared_by, judgement, trials

BLOCK, LONG_BLOCK = DEFAULT_CRITERIA.block, DEFAULT_CRITERIA.long_block
RESOLUTION = DEFAULT_CRITERIA.resolution


@pytest.mark.parametrize(
    ("bic", "error", "block", "earned"),
    [
        (-1.0, 1.5, BLOCK, True),
        (-1.0, 0.5, BLOCK, False),
        (-1.0, 0.995, BLOCK, False),
        (-1.0, 1.005, BLOCK, True),
        (1.0, 1.5, LONG_BLOCK, False),
        (1.0, 2.5, LONG_BLOCK, True),
        (5.5, 2.5, LONG_BLOCK, True),
        (6.5, 2.5, LONG_BLOCK, False),
    ],
)
def test_what_was_held_out_outweighs_a_weak_objection(
    pair: Pair, bic: float, error: float, block: float, earned: bool
) -> None:
    after, before = trials(pair, bic, error, block)

    assert delta_bic(after.fitted, before.fitted, pair[1][:1]) == pytest.approx(bic, abs=1e-6)
    assert addition_justified(after, before, compared_by(pair, SelectionCriteria(strong=6.0))) == earned


def test_the_criterion_has_to_agree_unless_it_is_told_otherwise(pair: Pair) -> None:
    for bic in (-0.5, 0.5):
        after, before = trials(pair, bic, 9.0, LONG_BLOCK)
        assert addition_justified(after, before, compared_by(pair)) == (bic < 0)


def test_an_objection_stands_where_nothing_held_out_foresees_the_gain(pair: Pair) -> None:
    after, before = trials(pair, 1.0, 2.5, LONG_BLOCK)
    labels = (*before.fitted.labels, (pair[1][0].name, "more"))
    fitted_to_each = replace(after, fitted=replace(after.fitted, labels=labels))
    for richer in (fitted_to_each, replace(after, held_out=None)):
        assert not addition_justified(richer, before, compared_by(pair, SelectionCriteria(strong=6.0)))


@pytest.mark.parametrize(
    ("names", "twice"),
    [
        (("tared_pretwist", "torque_offset"), True),
        (("pretwist", "rate_friction", "tared_pretwist"), True),
        (("tared_pretwist", "zero_drift"), False),
        (("torque_offset", "zero_drift"), False),
    ],
)
def test_a_tared_torque_has_no_other_zero_at_its_start(names: tuple[str, ...], twice: bool) -> None:
    assert has_redundant_zero_effects(effects_named(names)) == twice


@pytest.mark.parametrize(
    ("names", "present"),
    [
        (("patch_width", "carcass_torsion"), True),
        (("patch_width", "contact_length"), False),
        (("load_dependent_friction", "contact_length"), False),
        (("steering_return", "zero_drift"), False),
    ],
)
def test_effects_of_one_mechanism(names: tuple[str, ...], present: bool) -> None:
    assert family_already_present(effects_named(names)) == present


def test_a_length_follows_only_a_load_that_changes() -> None:
    plain = recording()
    still, heavier = (replace(plain, F_N=np.full(plain.t.size, load)) for load in (400.0, 410.0))
    (length,) = effects_named(["contact_length"])

    assert not recordings_allow(length, (), [still, still])
    assert recordings_allow(length, (), [still, heavier])


def test_an_exchange_pays_for_its_parameters(pair: Pair) -> None:
    dearer, before = trials(pair, 1.0, 2.5)

    assert not exchange_justified(dearer, before, compared_by(pair))
    assert exchange_justified(replace(dearer, fitted=before.fitted), before, compared_by(pair))


@pytest.mark.parametrize(("error", "apart"), [(1.5, False), (2.5, True)])
def test_told_apart_by_two_standard_errors(pair: Pair, error: float, apart: bool) -> None:
    assert distinguishable(*trials(pair, 0.0, error), DEFAULT_CRITERIA) == apart


def test_too_little_for_the_discretised_patch_is_nothing(pair: Pair) -> None:
    """The error falls by a tenth, from the least that bristles can show."""
    after, before = trials(pair, -100.0, 2.5)
    small = [
        replace(trial, judgement=judgement(np.full(SECONDS, size)))
        for trial, size in ((after, 0.9 * RESOLUTION), (before, RESOLUTION))
    ]

    assert not addition_justified(*small, compared_by(pair))


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"least_gain": -0.1}, "criteria: least_gain must be at least 0, got -0.1"),
        ({"strong": np.nan}, "criteria: strong must be at least 0, got nan"),
        ({"block": 0.0}, "criteria: block must be greater than 0, got 0.0"),
        ({"idle_steps": 0}, "criteria: idle_steps must be greater than 0, got 0"),
    ],
)
def test_thresholds_have_a_range(fault: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidInputError, match=f"^{message}$"):
        SelectionCriteria(**fault)  # type: ignore[arg-type]
