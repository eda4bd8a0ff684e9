"""When an effect earns its place: errors made up such that each figure is known beforehand."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording
from identification.selecting.rules import (
    FINEST_RESOLUTION,
    earns_its_place,
    is_better,
    is_evident,
    tells_apart,
    the_only_promising,
)
from identification.selecting.scoring import BLOCK, LONG_BLOCK, RESOLUTION, delta_bic
from identification.selecting.scoring import rmse_of as rms
from identification.selecting.trials import Trial
from tests.identification.selecting.compared import SECONDS, judgement, trials


@pytest.mark.parametrize(
    ("bic", "error", "block", "earned"),
    [
        (-1.0, 1.5, BLOCK, True),
        (-1.0, 0.5, BLOCK, False),
        (1.0, 1.5, LONG_BLOCK, False),
        (1.0, 2.5, LONG_BLOCK, True),
        (5.5, 2.5, LONG_BLOCK, True),
        (6.5, 2.5, LONG_BLOCK, False),
    ],
)
def test_what_was_held_out_outweighs_a_weak_objection(
    pair: tuple[Trial, list[Recording]], bic: float, error: float, block: float, earned: bool
) -> None:
    after, before = trials(pair, bic, error, block)
    training = pair[1][:1]

    assert delta_bic(after.fitted, before.fitted, training) == pytest.approx(bic, abs=1e-6)
    assert earns_its_place(after, before, training) == earned


def test_without_held_out_recordings_an_objection_stands(pair: tuple[Trial, list[Recording]]) -> None:
    after, before = (replace(t, held_out=None) for t in trials(pair, 1.0, 2.5, LONG_BLOCK))

    assert not earns_its_place(after, before, pair[1][:1])


def test_what_is_fitted_to_each_recording_is_not_foreseen(pair: tuple[Trial, list[Recording]]) -> None:
    after, before = trials(pair, 1.0, 2.5, LONG_BLOCK)
    labels = (*before.fitted.labels, (pair[1][0].name, "more"))
    after = replace(after, fitted=replace(after.fitted, labels=labels))

    assert not earns_its_place(after, before, pair[1][:1])


def test_an_exchange_pays_for_its_parameters(pair: tuple[Trial, list[Recording]]) -> None:
    training = pair[1][:1]
    dearer, before = trials(pair, 1.0, 2.5)

    assert not is_better(dearer, before, training)
    assert is_better(replace(dearer, fitted=before.fitted), before, training)


@pytest.mark.parametrize(("error", "apart"), [(1.5, False), (2.5, True)])
def test_told_apart_by_two_standard_errors(
    pair: tuple[Trial, list[Recording]], error: float, apart: bool
) -> None:
    assert tells_apart(*trials(pair, 0.0, error)) == apart


def test_too_little_for_the_discretised_patch_is_nothing(pair: tuple[Trial, list[Recording]]) -> None:
    """The error falls by a tenth, from the least that bristles can show."""
    after, before = trials(pair, -100.0, 2.5)
    small = [
        replace(trial, judgement=judgement(np.full(SECONDS, size)))
        for trial, size in ((after, 0.9 * RESOLUTION), (before, RESOLUTION))
    ]

    assert not earns_its_place(*small, pair[1][:1])


@pytest.mark.parametrize(
    ("bic", "error", "evident"), [(-10.5, 2.5, True), (-9.5, 2.5, False), (-20.0, 1.5, False)]
)
def test_a_small_effect_needs_very_strong_evidence(
    pair: tuple[Trial, list[Recording]], bic: float, error: float, evident: bool
) -> None:
    assert is_evident(*trials(pair, bic, error), pair[1][:1]) == evident


def test_too_little_for_the_finest_patch_is_nothing(pair: tuple[Trial, list[Recording]]) -> None:
    after, before = trials(pair, -100.0, 2.5)
    small = [
        replace(trial, judgement=judgement(np.full(SECONDS, size)))
        for trial, size in ((after, 0.5 * FINEST_RESOLUTION), (before, FINEST_RESOLUTION))
    ]

    assert not is_evident(*small, pair[1][:1])


@pytest.mark.parametrize(
    ("bics", "chosen"),
    [([-0.5], 0), ([0.5], None), ([-1.0, -4.5], 1), ([-4.5, -2.0], None), ([], None)],
    ids=["alone", "unwanted", "by far", "one of two", "none"],
)
def test_promising_is_what_no_other_comes_near(
    pair: tuple[Trial, list[Recording]], bics: list[float], chosen: int | None
) -> None:
    # All against the first one's model before; the noise that they leave is the same.
    made = [trials(pair, bic, 2.5) for bic in bics]
    before = made[0][1] if made else pair[0]
    name = pair[1][0].name
    scale = [(rms(m[1].fitted.residuals[name]) / rms(before.fitted.residuals[name])) ** -1 for m in made]
    tried = [
        replace(after, fitted=replace(after.fitted, residuals={name: s * after.fitted.residuals[name]}))
        for (after, _), s in zip(made, scale, strict=True)
    ]

    for trial, bic in zip(tried, bics, strict=True):
        assert delta_bic(trial.fitted, before.fitted, pair[1][:1]) == pytest.approx(bic, abs=1e-6)
    expected = [] if chosen is None else [tried[chosen]]
    assert the_only_promising(tried, before, pair[1][:1]) == expected


def test_nothing_is_promising_where_structure_is_left(pair: tuple[Trial, list[Recording]]) -> None:
    training = pair[1][:1]
    after, before = trials(pair, -100.0, 2.5)
    slow = {training[0].name: np.sin(training[0].t)}
    after = replace(after, fitted=replace(after.fitted, residuals=slow))
    before = replace(
        before, fitted=replace(before.fitted, residuals={n: 9 * r for n, r in slow.items()})
    )

    assert delta_bic(after.fitted, before.fitted, training) < 0
    assert the_only_promising([after], before, training) == []
