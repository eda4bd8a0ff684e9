"""Acquisition in C is that of Python: the same friction, the same flags on the same samples."""

from typing import Any

import numpy as np
import pytest

from observers import ESTIMATE, AligningTorque, Status
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
from tests.observers.embedded.generated_code import (
    cases,
    observer_named,
    python_estimates,
    rows_of,
)

USABLE, STATUS = ESTIMATE.index("usable"), ESTIMATE.index("status")
CASES = cases(
    "ekf declared aligning; ekf declared steering; mhe declared aligning; ekf few aligning",
    "mhe declared steering; mhe few aligning",
)


def on_ice(measurement_model: Any, scale: float = 1.0) -> Any:
    """Samples of ice, on which friction is acquired within 0.1 rad."""
    if measurement_model.channels[-1] == "M":
        made: Any = make_steering_recording(
            5, constant_friction(0.3), tyre=RigTyre(k=K, mu=0.3), duration=3.0, rate=200.0
        )
    else:
        made = make_recording(21, mu=0.05, k=K, bristles=500, duration=6.0)
    return rows_of(made) * [1, 1, scale, 1, 1]


@pytest.mark.parametrize("name", CASES)
def test_double_is_the_same(generated: Generate, name: str) -> None:
    observer = observer_named(name)
    rows = on_ice(observer.measurement_model)
    expected = python_estimates(observer, rows)
    estimates = generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=1e-9)
    np.testing.assert_array_equal(estimates[:, [3, USABLE, STATUS]], expected[:, [3, USABLE, STATUS]])
    acquiring = expected[:, STATUS].astype(int) & Status.ACQUIRING != 0
    assert acquiring[0]
    assert not acquiring[-1]
    if "declared" in name:
        assert expected[:, USABLE].any()


@pytest.mark.parametrize("scale", [0.1, 14.8, -1.0])
def test_a_wrong_torque_is_suspect_in_c_too(generated: Generate, scale: float) -> None:
    observer = observer_named("ekf declared aligning")
    rows = on_ice(AligningTorque(), scale)
    expected, estimates = python_estimates(observer, rows), generated(observer, DOUBLE).run(rows)

    np.testing.assert_array_equal(estimates[:, STATUS], expected[:, STATUS])
    assert int(estimates[-1, STATUS]) & Status.SUSPECT
    assert not estimates[:, USABLE].any()


@pytest.mark.parametrize(("before", "after"), [(1.0, 0.05), (0.05, 1.0)])
def test_a_new_ground_is_acquired_anew(generated: Generate, before: float, after: float) -> None:
    made = make_ground_recording(7, friction_step(5.0, before, after), tyre=RigTyre(k=K), duration=10.0)
    rows = rows_of(made)
    observer = observer_named("ekf declared aligning")
    expected, estimates = python_estimates(observer, rows), generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=1e-7)
    np.testing.assert_array_equal(estimates[:, [USABLE, STATUS]], expected[:, [USABLE, STATUS]])
    assert (expected[500:, STATUS].astype(int) & Status.RESET).any()
    assert abs(estimates[-1, 0] - after) < 3 * estimates[-1, 1]


def test_single_precision_acquires_the_same_friction(generated: Generate) -> None:
    observer = observer_named("ekf declared aligning")
    rows = SINGLE.round(on_ice(AligningTorque()))
    expected, estimates = python_estimates(observer, rows), generated(observer, SINGLE).run(rows)
    both = (expected[:, USABLE] * estimates[:, USABLE]).astype(bool)

    assert np.mean(expected[:, USABLE] != estimates[:, USABLE]) < 0.01
    assert np.abs(estimates[both, 0] / expected[both, 0] - 1).max() < 0.01
