"""The wheel with its inertia, steering torque and angle measured: what is found on the rig."""

from math import inf
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Estimates, Mhe, SteeringTorque, run
from reference_rig import RigTyre, SteeringRecording, make_steering_recording
from symbolic import InvalidInputError, Model, effects_named
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import CLEAN_RIG, columns_of, slide

pytestmark = pytest.mark.usefixtures("interpreted")

KINDS = [pytest.param(Ekf, {}, id="ekf"), pytest.param(Mhe, {"window": 20}, id="mhe")]
MEASUREMENT_MODELS = [
    SteeringTorque(),
    SteeringTorque(zero=False, stiffness=True),
    pytest.param(SteeringTorque(zero=False), marks=pytest.mark.long),
]
MADE = [(6, 0.7), *(pytest.param(seed, marks=pytest.mark.long) for seed in ((5, 1.3), (8, 1.6)))]


@pytest.fixture(scope="module", params=MADE, ids=str)
def made(request: pytest.FixtureRequest) -> SteeringRecording:
    seed, mu = request.param
    return make_steering_recording(seed, tyre=RigTyre(mu=mu), duration=4.0, rate=500.0)


def slid(made: SteeringRecording) -> slice:
    """From the first sample at 90 % of full slide on."""
    full = 0.9 * 1.07 * made.mu_true[0] * slide()
    return slice(int(np.flatnonzero(np.abs(made.M_z_true) > full)[0]) + 1, None)


def estimated(kind: Any, made: SteeringRecording, **settings: Any) -> Estimates:
    return run(make(kind, **settings), **columns_of(made))


@pytest.mark.parametrize("measurement_model", MEASUREMENT_MODELS, ids=repr)
@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_friction_is_found(
    made: SteeringRecording, kind: Any, settings: Any, measurement_model: SteeringTorque
) -> None:
    settings = {"measurement_model": measurement_model, **CLEAN_RIG, **settings}
    estimates, late = estimated(kind, made, **settings), slid(made)
    error = np.abs(estimates.mu - made.mu_true)[late]

    assert estimates.informed[late].all()
    assert error.max() < 0.03
    assert np.mean(error < 3 * estimates.mu_std[late]) > 0.95
    assert not estimates.informed[:100].any(), "the wheel has hardly moved"


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_friction_is_found_as_tuning_stands(made: SteeringRecording, kind: Any, settings: Any) -> None:
    estimates, late = estimated(kind, made, measurement_model=SteeringTorque(), **settings), slid(made)

    assert np.abs(estimates.mu - made.mu_true)[late].max() < 0.1
    np.testing.assert_array_equal(estimates.status & ~np.int64(32), 0)


def test_the_clock_may_be_uneven() -> None:
    times = np.sort(np.random.default_rng(3).uniform(0.0, 4.0, 1500))
    uneven = make_steering_recording(5, duration=4.0, times=times)
    estimates = estimated(Ekf, uneven, measurement_model=SteeringTorque(), **CLEAN_RIG)

    assert np.abs(estimates.mu - 1.3)[slid(uneven)].max() < 0.03
    assert estimates.mu[-1] == pytest.approx(1.3, abs=3 * estimates.mu_std[-1])


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("rate", [1000.0, 100.0])
def test_a_torque_lost_for_long_counts_alike_at_any_rate(kind: Any, settings: Any, rate: float) -> None:
    # What is held errs to one side; ten times as many samples of it say no more.
    made = make_steering_recording(11, duration=4.0, rate=rate)
    M = np.where((made.t > 2.0) & (made.t < 3.0), np.nan, made.M)
    noisy = {"measurement_model": SteeringTorque(), "noise": 0.03, "error": inf, "gate": inf}
    observer = make(kind, **noisy, **settings)
    said = run(observer, made.t, made.psi, made.F_N, M=M)
    off = np.abs(said.mu - made.mu_true) / said.mu_std

    assert off[made.t > 2.0].max() < 5


def test_a_sensor_of_the_other_torque_is_refused() -> None:
    model = Model(effects=effects_named(["sensor_delay"]))
    values = {"k": K, "sensor_delay.delay": 0.01}
    with pytest.raises(InvalidInputError, match="sensor_delay"):
        Ekf(model=model, values=values, rig=RIG, measurement_model=SteeringTorque())
