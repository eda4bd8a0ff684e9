"""Faulty sensors and a change of ground, on the independent rig; `benchmarks/robustness.py` has more."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Mhe, Status
from tests.observers.monte_carlo import errors, estimated, turned_by_hand
from tests.observers.sensor_faults import (
    CLEAN_WITH_FAULTS,
    FAULTS,
    STEERED_FAULTS,
    RecordingFactory,
    rmse,
    steered,
    without_torque,
)
from tests.observers.surface_changes import HIGH, LOW, crossing, turn_until_known

pytestmark = pytest.mark.usefixtures("optimised")
KINDS = [pytest.param(Ekf, id="ekf"), pytest.param(Mhe, id="mhe", marks=pytest.mark.long)]
"""The window takes ten times as long as the filter."""
STEERED_RUNS = range(3)
PLACES = (pytest.param(0.15, marks=pytest.mark.long), 0.25, pytest.param(0.35, marks=pytest.mark.long))
NOISES = range(3)


@cache
def clean(kind: Any, made: RecordingFactory, seeds: range, **settings: Any) -> float:
    """The error without a fault."""
    return rmse(kind, made, seeds, **settings)


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize(
    ("kind", "count"),
    [(Ekf, 8), *(pytest.param(*case, marks=pytest.mark.long) for case in ((Ekf, 20), (Mhe, 10)))],
)
def test_faults_cost_no_more_than_a_factor_of_two(kind: Any, count: int, fault: str) -> None:
    seeds = range(count)
    without = clean(kind, turned_by_hand, seeds)

    assert without < 0.002
    assert rmse(kind, FAULTS[fault], seeds) < 2 * without


@pytest.mark.parametrize("fault", ["outliers", "all of these"])
@pytest.mark.parametrize(("count", "least"), [(8, 10), pytest.param(20, 50, marks=pytest.mark.long)])
def test_no_fault_is_taken_for_another_ground(count: int, least: int, fault: str) -> None:
    rejected = 0
    for seed in range(count):
        made = FAULTS[fault](seed)
        estimates = estimated(Ekf, made, **CLEAN_WITH_FAULTS)
        late = slice(errors(made, estimates).slid, None)
        status, torque = estimates.status[late], made.M_z[late]
        measured = np.isfinite(torque) & (status & Status.MISSING == 0)
        struck = np.abs(torque - made.M_z_true[late]) > np.ptp(made.M_z_true) / 2

        assert not (status & Status.RESET).any()
        assert (status[struck & measured] & Status.REJECTED).all()
        rejected += np.count_nonzero(struck & measured)
    assert rejected > least


@pytest.mark.parametrize("fault", STEERED_FAULTS)
@pytest.mark.parametrize("kind", KINDS)
def test_steering_torque_bears_faults_of_the_angle(kind: Any, fault: str) -> None:
    settings = {"window": 10} if kind is Mhe else {}
    without = clean(kind, steered, STEERED_RUNS, **settings)

    assert without < 0.003
    assert rmse(kind, STEERED_FAULTS[fault], STEERED_RUNS, **settings) < 2 * without


def test_a_lost_steering_torque_costs_more_but_not_the_truth() -> None:
    # It is what drives the wheel, and one that is missing counts as unknown up to full slide.
    for seed in STEERED_RUNS:
        made = without_torque(seed)
        run = errors(made, estimated(Ekf, made, **CLEAN_WITH_FAULTS))

        assert run.late_rmse < 0.02
        assert np.mean(run.normal[run.slid :] ** 2) < 1


@pytest.mark.long
@pytest.mark.parametrize("place", PLACES)
def test_a_ground_that_falls_is_known_within_a_tenth_of_a_radian(place: float) -> None:
    for seed in NOISES:
        made = crossing(seed, place, HIGH, LOW)
        by_filter, by_window = (turn_until_known(kind, made) for kind in (Ekf, Mhe))

        assert 0 < by_window <= by_filter < 0.06


@pytest.mark.long
@pytest.mark.parametrize("place", PLACES)
def test_a_ground_that_rises_takes_more_iterations(place: float) -> None:
    # The torque does not jump but grows with the turn, and one linearisation overshoots.
    for seed in NOISES:
        made = crossing(seed, place, LOW, HIGH)
        by_filter, by_window = (turn_until_known(kind, made, iterations=3) for kind in (Ekf, Mhe))

        assert 0 < by_window < 0.1
        assert 0 < by_filter < 0.12
