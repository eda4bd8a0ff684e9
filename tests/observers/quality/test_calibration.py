"""A standard deviation is worth what it says: seeded runs; more in `benchmarks/calibration.py`."""

from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from observers import Ekf, Mhe
from symbolic import Model
from tests.observers.grid_posterior import posterior
from tests.observers.monte_carlo import (
    ALLOWANCE,
    Figures,
    errors,
    estimated,
    figures,
    steered_by_hand,
    turned_by_hand,
)

pytestmark = pytest.mark.usefixtures("optimised")
FEWER = range(40)
RUNS = [
    pytest.param((Ekf, FEWER), id="ekf"),
    pytest.param((Ekf, range(200)), id="ekf-200", marks=pytest.mark.long),
    pytest.param((Mhe, FEWER), id="mhe", marks=pytest.mark.long),
]
WRONG = 1.5
"""Factor on standard deviations that has to be noticed."""
BRISTLES = Model(discretised=True)


def constant(kind: Any, seeds: range, **settings: Any) -> Figures:
    """The figures of runs on ground that stays."""
    return figures([errors(r, estimated(kind, r, **settings)) for r in map(turned_by_hand, seeds)])


def walking(walk: float, **settings: Any) -> Figures:
    """The figures of the filter on ground that walks as it believes."""
    made = [turned_by_hand(seed, walk) for seed in FEWER]
    return figures([errors(r, estimated(Ekf, r, mu_walk=walk, **settings)) for r in made])


def likely(found: Figures) -> bool:
    """The mean of so many chi-squares lies where it lies with a probability of 95 %."""
    low, high = chi2.ppf([0.025, 0.975], found.runs) / found.runs
    return bool(low < found.nees < high)


@pytest.fixture(scope="module", params=RUNS)
def found(request: pytest.FixtureRequest) -> Figures:
    return constant(*request.param)


def test_errors_are_as_large_as_their_standard_deviations(found: Figures) -> None:
    assert 0.93 < found.coverage < 0.97
    assert likely(found)


def test_hardly_a_run_goes_far_astray_and_friction_is_known_after_full_slide(found: Figures) -> None:
    assert found.rmse < 0.001
    assert found.worst < 0.003
    # Of 600 runs Bayes' rule itself has five with a sample beyond four standard deviations.
    assert found.beyond <= 2
    assert found.farthest < 5


@pytest.mark.parametrize(
    ("kind", "scale"),
    [(Ekf, WRONG), (Ekf, 1 / WRONG), pytest.param(Mhe, 1 / WRONG, marks=pytest.mark.long)],
)
def test_wrong_standard_deviations_would_be_noticed(kind: Any, scale: float) -> None:
    off = constant(kind, FEWER, scale=scale * ALLOWANCE)

    assert not 0.93 < off.coverage < 0.97
    assert not likely(off)


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize("seed", [17, *(pytest.param(n, marks=pytest.mark.long) for n in (0, 14))])
def test_little_is_lost_against_bayes_rule(kind: Any, seed: int) -> None:
    made = turned_by_hand(seed)
    estimates = estimated(kind, made)
    count = errors(made, estimates).slid
    exact, informed = posterior(made, count), estimates.informed[:count]
    std = (estimates.mu_std / estimates.mu)[:count]

    assert count < 500, "the comparison is of the time before full slide"
    assert np.abs((np.log(estimates.mu[:count]) - exact.mean) / exact.std)[informed].max() < 0.5
    np.testing.assert_allclose(std[informed], exact.std[informed], rtol=0.25)
    assert np.median((std / exact.std)[informed]) == pytest.approx(1, abs=0.05)


@pytest.mark.long
def test_ground_that_hardly_walks() -> None:
    found = walking(0.001)

    assert likely(found)
    assert 0.93 < found.coverage < 0.97


@pytest.mark.long
def test_ground_that_walks_needs_bristles() -> None:
    # The exact patch reads all of the past at the present mu.
    exact, bristles = walking(0.01), walking(0.01, model=BRISTLES)

    assert 0.93 < bristles.coverage < 0.97
    assert 0.8 < bristles.nees < 1.2
    assert exact.nees > 1.8
    assert bristles.rmse < 0.7 * exact.rmse


@pytest.mark.long
def test_steering_torque() -> None:
    # An encoder at rest errs by a constant, so a whole step is believed of it, not 0.29 steps.
    made = [steered_by_hand(seed, 6.0) for seed in range(8)]
    found = figures([errors(r, estimated(Ekf, r)) for r in made])

    assert found.nees < 1.5
    assert found.coverage > 0.9
    assert found.worst < 0.005
    assert found.beyond <= 1
