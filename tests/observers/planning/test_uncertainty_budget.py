"""The uncertainty budget against what `run` states with other tolerances."""

from dataclasses import replace
from math import hypot

import numpy as np
import pytest

from observers import Ekf, Estimates, Tuning, run, uncertainty_budget
from observers.planning.steering_limits_and_paths import SteeringPath, fastest_path
from observers.planning.uncertainty_budget import REST, SLOPE
from observers.tuning import OF_LENGTHS, OF_LOAD
from symbolic import InvalidInputError, Tolerances
from symbolic.float_array_type import Array
from tests.observers.planning.conftest import LOAD, observe_on_rig

MU = 0.8


@pytest.fixture(scope="module")
def path() -> SteeringPath:
    return fastest_path([0.0, 0.25, -0.25, 0.25], 0.3, 10.0, 0.01, 10.0)


@pytest.fixture(scope="module")
def torque(acquiring: Ekf, path: SteeringPath) -> Array:
    return np.asarray(observe_on_rig(acquiring, path, MU)[1])


def estimated(observer: Ekf, path: SteeringPath, torque: Array) -> tuple[Estimates, dict[str, float]]:
    """Estimates over a path, and the budget at its end."""
    t = 0.01 * np.arange(path.psi.size)
    channels = {"psi": path.psi, "F_N": np.full(t.size, LOAD), "M_z": torque, "psi_dot": path.psi_dot}
    return run(observer, t, **channels), uncertainty_budget(observer, t.size - 1, t, **channels)


def test_the_parts_are_those_of_the_stated_deviation(
    acquiring: Ekf, path: SteeringPath, torque: Array
) -> None:
    within = Tolerances(a=0.001, e=0.001, load=0.05, k=0.2 * acquiring.values["k"])
    observer = replace(acquiring, rig=replace(acquiring.rig, tolerances=within))
    estimates, budget = estimated(observer, path, torque)
    stated = estimates.mu_std[-1] / estimates.mu[-1]

    assert estimates.usable[-1]
    assert hypot(*budget.values()) == pytest.approx(stated, rel=1e-9)
    # Uniform within the tolerance: full slide is proportional to the load.
    assert budget[OF_LOAD] == pytest.approx(0.05 / 3**0.5, rel=1e-9)
    exact = replace(acquiring, rig=replace(acquiring.rig, tolerances=replace(within, load=0.0)))
    without, _ = estimated(exact, path, torque)
    left = (without.mu_std[-1] / without.mu[-1]) ** 2
    assert stated**2 - left == pytest.approx(budget[OF_LOAD] ** 2, rel=1e-6)
    # The slope is as declared, and known to so much.
    assert 0 < budget[SLOPE] < budget[OF_LOAD] / 1.5
    assert max(budget, key=lambda cause: budget[cause]) == OF_LOAD
    assert budget[OF_LENGTHS] > budget[REST] / 10 > 0


def test_a_torque_of_another_scale_is_the_largest_part(
    acquiring: Ekf, path: SteeringPath, torque: Array
) -> None:
    observer = replace(acquiring, tuning=Tuning())
    estimates, budget = estimated(observer, path, 0.85 * torque)

    assert estimates.usable[-1]
    assert max(budget, key=lambda cause: budget[cause]) == SLOPE
    assert hypot(*budget.values()) == pytest.approx(estimates.mu_std[-1] / estimates.mu[-1], rel=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.05])
@pytest.mark.parametrize("length", [0.0, 5e-4])
def test_a_closer_tolerance_does_not_keep_friction_from_being_usable(
    acquiring: Ekf, path: SteeringPath, torque: Array, share: float, length: float
) -> None:
    within = Tolerances(a=length, e=length, load=0.01, k=share * acquiring.values["k"])
    closer, _ = estimated(
        replace(acquiring, rig=replace(acquiring.rig, tolerances=within)), path, torque
    )
    usual, _ = estimated(acquiring, path, torque)

    assert closer.usable.sum() >= 0.75 * usual.usable.sum() > 0
    assert closer.mu_std[-1] <= usual.mu_std[-1]
    assert closer.mu[-1] == pytest.approx(MU, rel=0.03)


def test_there_is_none_beyond_the_samples(acquiring: Ekf, path: SteeringPath, torque: Array) -> None:
    t = 0.01 * np.arange(path.psi.size)
    with pytest.raises(InvalidInputError, match="at must be from 0 to "):
        uncertainty_budget(acquiring, t.size, t, path.psi, np.full(t.size, LOAD), torque)
