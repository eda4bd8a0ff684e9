"""Acquisition in C is that of Python: the same friction, the same flags on the same samples."""

from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Ekf, Mhe, Status, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from reference_rig import (
    RigTyre,
    constant_friction,
    friction_step,
    make_ground_recording,
    make_recording,
    make_steering_recording,
)
from tests.observers.conftest import K
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import DECLARED, FEW_BRISTLES, observer_of, python_estimates
from tests.observers.factories import columns_of, samples_of

USABLE, STATUS = ESTIMATE.index("usable"), ESTIMATE.index("status")
CASES = [
    pytest.param(Ekf, DECLARED, AligningTorque(), id="ekf"),
    pytest.param(Ekf, DECLARED, SteeringTorque(), id="ekf-steering"),
    pytest.param(Mhe, DECLARED, AligningTorque(), id="mhe"),
    pytest.param(Mhe, DECLARED, SteeringTorque(), id="mhe-steering", marks=pytest.mark.long),
    pytest.param(Ekf, FEW_BRISTLES, AligningTorque(), id="ekf-bristles"),
    pytest.param(Mhe, FEW_BRISTLES, AligningTorque(), id="mhe-bristles", marks=pytest.mark.long),
]


def rows_of(measurement_model: Any, scale: float = 1.0) -> Any:
    """Samples of ice, on which friction is acquired within 0.1 rad."""
    if measurement_model.channels[-1] == "M":
        made: Any = make_steering_recording(
            5, constant_friction(0.3), tyre=RigTyre(k=K, mu=0.3), duration=3.0, rate=200.0
        )
    else:
        made = make_recording(21, mu=0.05, k=K, bristles=500, duration=6.0)
    columns = columns_of(made)
    torque = measurement_model.channels[-1]
    columns[torque] = scale * columns[torque]
    return np.array([(s.psi, s.psi_dot, getattr(s, torque), s.F_N, s.dt) for s in samples_of(columns)])


@pytest.mark.parametrize(("kind", "model", "measurement_model"), CASES)
def test_double_is_the_same(generated: Generate, kind: Any, model: Any, measurement_model: Any) -> None:
    observer = observer_of(kind, model, measurement_model)
    rows = rows_of(measurement_model)
    expected = python_estimates(observer, rows)
    estimates = generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=1e-9)
    np.testing.assert_array_equal(estimates[:, [3, USABLE, STATUS]], expected[:, [3, USABLE, STATUS]])
    acquiring = expected[:, STATUS].astype(int) & Status.ACQUIRING != 0
    assert acquiring[0]
    assert not acquiring[-1]
    if model is DECLARED:
        assert expected[:, USABLE].any()


@pytest.mark.parametrize("scale", [0.1, 14.8, -1.0])
def test_a_wrong_torque_is_suspect_in_c_too(generated: Generate, scale: float) -> None:
    observer = observer_of(Ekf, DECLARED, AligningTorque())
    rows = rows_of(AligningTorque(), scale)
    expected, estimates = python_estimates(observer, rows), generated(observer, DOUBLE).run(rows)

    np.testing.assert_array_equal(estimates[:, STATUS], expected[:, STATUS])
    assert int(estimates[-1, STATUS]) & Status.SUSPECT
    assert not estimates[:, USABLE].any()


@pytest.mark.parametrize(("before", "after"), [(1.0, 0.05), (0.05, 1.0)])
def test_a_new_ground_is_acquired_anew(generated: Generate, before: float, after: float) -> None:
    made = make_ground_recording(7, friction_step(5.0, before, after), tyre=RigTyre(k=K), duration=10.0)
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples_of(columns_of(made))])
    observer = observer_of(Ekf, DECLARED, AligningTorque())
    expected, estimates = python_estimates(observer, rows), generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=1e-7)
    np.testing.assert_array_equal(estimates[:, [USABLE, STATUS]], expected[:, [USABLE, STATUS]])
    assert (expected[500:, STATUS].astype(int) & Status.RESET).any()
    assert abs(estimates[-1, 0] - after) < 3 * estimates[-1, 1]


def test_single_precision_acquires_the_same_friction(generated: Generate) -> None:
    observer = observer_of(Ekf, DECLARED, AligningTorque())
    rows = SINGLE.round(rows_of(AligningTorque()))
    expected, estimates = python_estimates(observer, rows), generated(observer, SINGLE).run(rows)
    both = (expected[:, USABLE] * estimates[:, USABLE]).astype(bool)

    assert np.mean(expected[:, USABLE] != estimates[:, USABLE]) < 0.01
    assert np.abs(estimates[both, 0] / expected[both, 0] - 1).max() < 0.01
