"""When an effect earns its place: errors made up such that each figure is known beforehand."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording
from identification.selecting.rules import earns_its_place, is_better, tells_apart
from identification.selecting.scoring import (
    BLOCK,
    LONG_BLOCK,
    RESOLUTION,
    Judgement,
    delta_bic,
    effective_samples,
)
from identification.selecting.trials import Task, Trial, attempt
from tests.identification.made import read_campaign

SECONDS, PER_SECOND = 80, 50


@pytest.fixture(scope="module")
def pair() -> tuple[Trial, list[Recording]]:
    recordings = read_campaign(None, 1)[1][:2]
    return attempt(Task((), recordings[:1], recordings[1:])), recordings


def judgement(sizes: np.ndarray) -> Judgement:
    """A held-out error of that size in each second, range 1."""
    t = np.arange(SECONDS * PER_SECOND) / PER_SECOND
    alternating = np.where(np.arange(t.size) % 2, 1.0, -1.0)
    return Judgement(
        residuals={"a": alternating * np.repeat(sizes, PER_SECOND)}, ranges={"a": 1.0}, times={"a": t}
    )


def trials(
    pair: tuple[Trial, list[Recording]], bic: float, error: float, block: float = BLOCK
) -> tuple[Trial, Trial]:
    """A model with one more parameter, and one without.

    With it the information criterion rises by `bic`, and the held-out mean square falls by `error` times
    its standard error, from blocks of so many seconds.
    """
    trial, (training, _) = pair
    white = np.random.default_rng(3).standard_normal(training.t.size)
    n = effective_samples({training.name: white})
    ratio = np.exp((np.log(n) - bic) / (2 * n))
    fits = {
        "before": replace(trial.fitted, residuals={training.name: ratio * white}),
        "after": replace(
            trial.fitted,
            residuals={training.name: white},
            labels=(*trial.fitted.labels, (None, "more")),
        ),
    }
    blocks = SECONDS // int(block)
    gains = np.repeat(np.where(np.arange(blocks) % 2, 1.0, -1.0), int(block))
    gains = 0.2 * (1 + gains * np.sqrt(blocks - 1) / error)
    held = {"before": np.ones(SECONDS) * 4, "after": 4 - gains}
    after, before = (
        replace(trial, fitted=fits[name], judgement=judgement(0.05 * np.sqrt(held[name])))
        for name in ("after", "before")
    )
    return after, before


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
