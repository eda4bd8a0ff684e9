"""A steering torque that is missing where it is large, against a wheel on fine bristles."""

import numpy as np
import pytest

from benchmarks.ice import RIG, STEERING_RATE, K
from observers import Ekf, SteeringTorque, run
from reference_rig import RigTyre, constant_friction, make_steering_recording
from symbolic import Model

EKF = Ekf(model=Model(), values={"k": K}, rig=RIG, measurement_model=SteeringTorque())


@pytest.mark.parametrize("mu", [0.8, pytest.param(0.3, marks=pytest.mark.long)])
def test_turns_without_a_torque_count(mu: float) -> None:
    # The wheel turns on and back where the torque is beyond its limit.
    wrong = usable = 0
    for seed in range(580_000, 580_003):
        made = make_steering_recording(
            seed, constant_friction(mu), tyre=RigTyre(a=RIG.a, e=RIG.e, k=K, mu=mu), load=400.0,
            duration=14.0, rate=STEERING_RATE,
        )  # fmt: skip
        seen = np.where(np.abs(made.M) < 0.48 * np.abs(made.M).max(), made.M, np.nan)
        estimates = run(EKF, made.t, made.psi, made.F_N, M=seen)
        off = np.abs(estimates.mu_eff - mu) > 3 * estimates.mu_eff_std
        wrong += bool(np.mean(estimates.usable & off) > 0.01)
        usable += bool(estimates.usable.any())

    assert wrong == 0
    assert usable > 0
