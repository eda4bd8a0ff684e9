"""The steered wheel: hand, ground, samples; for its motion see `test_wheel_motion_under_torque`."""

import numpy as np
import pytest

from reference_rig import (
    Grip,
    Hand,
    RigTyre,
    SteeringRecording,
    friction_step,
    full_slide_moment,
    hand_path,
    jitter_instants,
    make_steering_recording,
)

TYRE = RigTyre()


def clean(seed: int = 3, **settings: object) -> SteeringRecording:
    return make_steering_recording(seed, noise=0.0, encoder_step=0.0, **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 6))])
def test_hand_slides_fully_and_reverses(seed: int) -> None:
    made = clean(seed)
    used = made.M_z_true / full_slide_moment(TYRE, 1.0) / (TYRE.mu * made.F_N)
    rate = made.psi_dot_true[np.abs(made.psi_dot_true) > 0.01]

    assert used.min() < -0.95
    assert used.max() > 0.95
    assert np.count_nonzero(np.diff(np.sign(rate))) >= 3
    assert np.max(np.abs(rate)) < 1.0
    assert np.max(np.abs(made.psi_true)) < 0.7


def test_hand_pulls_towards_its_path() -> None:
    made = clean(4, grip=Grip(stiffness=150.0, damping=5.0), hand=Hand(), duration=6.0)
    path = hand_path(4, 12.0)

    # The path is run through at double tempo.
    psi = np.interp(2 * made.t, path.t, path.psi)
    psi_dot = 2 * np.interp(2 * made.t, path.t, path.psi_dot)
    pull = 150.0 * (psi - made.psi_true) + 5.0 * (psi_dot - made.psi_dot_true)
    np.testing.assert_allclose(made.M_true, pull, rtol=0, atol=1e-9)


def test_recorded_torque_repeats_the_motion() -> None:
    made = clean(duration=3.0)

    again = clean(torque=made.M_true, duration=3.0)

    np.testing.assert_allclose(again.M_true, made.M_true, atol=1e-12)
    np.testing.assert_allclose(again.psi_true, made.psi_true, atol=2e-6)
    np.testing.assert_allclose(again.M_z_true, made.M_z_true, atol=1e-4)


def test_torque_needs_a_value_a_sample() -> None:
    with pytest.raises(ValueError, match="needs 10001 samples"):
        clean(torque=np.zeros(10))


def test_friction_may_fall_while_turning() -> None:
    made = clean(friction=friction_step(3.0, 1.2, 0.5), duration=6.0)
    limit = full_slide_moment(TYRE, 1.0) * made.mu_true * made.F_N

    assert set(made.mu_true) == {0.5, 1.2}
    assert made.tyre.mu == 1.2
    assert np.all(np.abs(made.M_z_true) <= limit * (1 + 1e-4))
    assert np.max(np.abs(made.M_z_true[made.t < 3])) > 1.5 * limit[-1]


def test_uneven_samples_lie_on_the_same_motion() -> None:
    even = clean(duration=3.0)
    times = jitter_instants(1, np.arange(301) / 100, spread=0.03)

    made = clean(duration=3.0, times=times)

    np.testing.assert_array_equal(made.t, times)
    np.testing.assert_allclose(made.psi_true, np.interp(times, even.t, even.psi_true), atol=1e-5)
