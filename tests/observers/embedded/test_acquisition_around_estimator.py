"""Acquisition in C is that of Python: the same friction, flags and samples left out."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.faulty_inputs import relaxed
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
    needs_compiler,
    observer_named,
    python_estimates,
    rows_of,
)

pytestmark = needs_compiler
USABLE, STATUS = ESTIMATE.index("usable"), ESTIMATE.index("status")
CASES = cases(
    "ekf declared aligning; ekf declared steering; mhe declared aligning; ekf few aligning",
    "mhe declared steering; mhe few aligning; ekf relaxing aligning,k",
)


def on_ice(measurement_model: Any, scale: float = 1.0) -> Any:
    """Samples of ice, on which friction is acquired within 0.1 rad."""
    if measurement_model.channels[-1] == "M":
        drive = {"tyre": RigTyre(k=K, mu=0.3), "duration": 3.0, "rate": 200.0}
        made: Any = make_steering_recording(5, constant_friction(0.3), **drive)
    else:
        made = make_recording(21, mu=0.05, k=K, bristles=500, duration=6.0)
    return rows_of(made) * [1, 1, scale, 1, 1]


def compared(
    generated: Generate, observer: Any, rows: Any, rtol: float = 1e-9, atol: float = 0.0
) -> tuple[Any, Any]:
    """Estimates of Python, and their status; those of C are the same, flags to the last."""
    expected, estimates = python_estimates(observer, rows), generated(observer, DOUBLE).run(rows)
    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=rtol, atol=atol)
    np.testing.assert_array_equal(estimates[:, [3, USABLE, STATUS]], expected[:, [3, USABLE, STATUS]])
    return expected, expected[:, STATUS].astype(int)


@pytest.mark.parametrize("name", CASES)
def test_double_is_the_same(generated: Generate, name: str) -> None:
    observer = observer_named(name)
    expected, status = compared(generated, observer, on_ice(observer.measurement_model))
    acquiring = status & Status.ACQUIRING != 0
    assert acquiring[0]
    assert not acquiring[-1]
    if "declared" in name:
        assert expected[:, USABLE].any()


@pytest.mark.long
@pytest.mark.parametrize(
    "name", cases("ekf spring aligning; ekf spring steering", "mhe spring aligning; mhe spring steering")
)
def test_what_effects_add_to_the_torque_is_taken_off_in_c_too(generated: Generate, name: str) -> None:
    observer = observer_named(name)
    rows = on_ice(observer.measurement_model)
    psi, side = rows[:, 0], 1 if observer.channel == "M_z" else -1
    rate = np.gradient(psi) / rows[:, 4]
    rows[:, 2] -= side * (6.0 * psi + 0.1 * np.tanh(rate / 0.01))
    rows[100, 0] = np.nan
    expected, _ = compared(generated, observer, rows, 1e-8, 1e-10)

    torque = generated(observer, DOUBLE).run(rows)[:, 2]
    np.testing.assert_allclose(torque, expected[:, 2], rtol=1e-8, atol=1e-10)
    assert expected[:, USABLE].any()


@pytest.mark.parametrize("scale", [0.1, 14.8, -1.0])
def test_a_wrong_torque_is_suspect_in_c_too(generated: Generate, scale: float) -> None:
    observer = observer_named("ekf declared aligning")
    expected, status = compared(generated, observer, on_ice(AligningTorque(), scale), 1e-7)

    assert status[-1] & Status.SUSPECT
    assert not expected[:, USABLE].any()


@pytest.mark.parametrize("name", cases("ekf declared aligning", "mhe declared aligning"))
@pytest.mark.parametrize(("mu", "seed", "time"), [(0.3, 540_000, 0.3), (0.05, 540_007, 1.0)])
def test_a_model_that_explains_nothing_is_doubted_in_c_too(
    generated: Generate, mu: float, seed: int, time: float, name: str
) -> None:
    """A wheel that rolls: its torque relaxes within this time [s]."""
    made = make_recording(seed, mu=mu, k=K, load=400.0, bristles=500, duration=5.0)
    rows = rows_of(made)
    rows[:, 2] = relaxed(made.M_z, time)

    assert (compared(generated, observer_named(name), rows, 1e-6)[1] & Status.INCONSISTENT).any()


@pytest.mark.parametrize(("before", "after"), [(1.0, 0.05), (0.05, 1.0)])
def test_a_new_ground_is_acquired_anew(generated: Generate, before: float, after: float) -> None:
    made = make_ground_recording(7, friction_step(5.0, before, after), tyre=RigTyre(k=K), duration=10.0)
    expected, status = compared(generated, observer_named("ekf declared aligning"), rows_of(made), 1e-7)

    assert (status[500:] & Status.RESET).any()
    assert abs(expected[-1, 0] - after) < 3 * expected[-1, 1]


def test_single_precision_acquires_the_same_friction(generated: Generate) -> None:
    observer = observer_named("ekf declared aligning")
    rows = SINGLE.round(on_ice(AligningTorque()))
    expected, estimates = python_estimates(observer, rows), generated(observer, SINGLE).run(rows)
    both = (expected[:, USABLE] * estimates[:, USABLE]).astype(bool)

    assert np.mean(expected[:, USABLE] != estimates[:, USABLE]) < 0.01
    assert np.abs(estimates[both, 0] / expected[both, 0] - 1).max() < 0.01


@pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared steering", "mhe declared aligning; ekf declared aligning; mhe declared steering"
    ),
)
def test_implausible_samples_are_those_of_python(generated: Generate, name: str) -> None:
    observer = observer_named(name, acquire=False)
    rng, count = np.random.default_rng(5), 400
    t = np.arange(count) / 100
    psi = 0.3 * np.sin(3 * t)
    torque = -8 * np.tanh(20 * np.sin(3 * t)) + 0.1 * rng.standard_normal(count)
    if observer.channel == "M":
        torque = -torque
    silent, load = np.full(count, np.nan), np.full(count, 400.0)
    rows = np.column_stack([psi, silent, torque, load, np.diff(t, prepend=-0.01)])
    rows[:3, 0], rows[[3, 60, 90], 0] = [50.0, np.nan, 0.2], [0.9, -0.5, 1e6]
    rows[120:127, 0] += 0.4
    rows[160:, 0] -= 1.7
    rows[200:204, 0] = rng.uniform(-6, 6, 4)
    rows[[230, 231], 3], rows[[240, 241], 2], rows[250, 1] = [1e5, 3e8], [1e4, -2e5], 9.0
    rows[260:270, 0], rows[300:330:3, 0] = np.nan, rng.uniform(-6, 6, 10)
    rows[280, 0] += 0.13  # The next angle could follow this one, and is nearer to the one before it.
    rows[281, 0] += 0.05
    # Each of these may follow the last one; the rate of all of them is beyond the limit.
    rows[340:390, 0], rows[340:390, 4] = rows[339, 0] + 0.045 * np.arange(1, 51), 0.005
    # On the steering torque a window keeps the corners of a sample as a line in mu, which jumps leave.
    linear = name == "mhe declared steering"
    _, status = compared(generated, observer, rows, 0.0, 5e-4 if linear else 1e-10)
    seen = np.flatnonzero(status & Status.IMPLAUSIBLE)
    assert {0, 60, 90, 120, 126, 160, 169, 230, 231, 240, 241, 250, 280} <= set(seen.tolist())
    assert not {1, 61, 127, 171, 232, 242, 251, 281} & set(seen.tolist())


@pytest.mark.parametrize("name", ["ekf declared aligning", "ekf declared steering"])
def test_a_torque_beyond_the_sensors_range_is_left_out_in_c(generated: Generate, name: str) -> None:
    usual = observer_named(name)
    rows = on_ice(usual.measurement_model)
    most = float(0.7 * np.abs(rows[:, 2]).max())
    observer = replace(usual, rig=replace(usual.rig, range=most))
    seen = compared(generated, observer, rows)[1] & Status.IMPLAUSIBLE != 0
    np.testing.assert_array_equal(seen, np.abs(rows[:, 2]) >= 0.95 * most)
    assert seen.any()
