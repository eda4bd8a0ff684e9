"""Changing ground against the steady rig, and against what a falling limit does to a bristle."""

import numpy as np
import pytest

from reference_rig import (
    Friction,
    RigTyre,
    constant_friction,
    constant_turn,
    free_path,
    friction_between,
    friction_step,
    full_slide_moment,
    jitter_instants,
    make_ground_recording,
    make_recording,
    simulate_ground,
)

LOAD = 400.0
TYRE = RigTyre()
CHANGES: dict[str, Friction] = {
    "fall": friction_step(5.0, 1.2, 0.5),
    "rise": friction_step(5.0, 0.5, 1.2),
    "ramp": friction_between(np.array([0.0, 10.0]), np.array([1.3, 0.4])),
}


def stopped(turned: float, limits: list[float]) -> float:
    """Torque of bristles that turn from rest and are then cut to one limit mu after the other."""
    x = TYRE.a * ((2 * np.arange(400) + 1) / 400 - 1)
    q = -(x - TYRE.e) * turned
    for mu in limits:
        q_cr = 3 * LOAD * mu / (4 * TYRE.a**3 * TYRE.k) * (TYRE.a**2 - x**2)
        q = np.clip(q, -q_cr, q_cr)
    return float(TYRE.k * np.sum(q * (x - TYRE.e)) * 2 * TYRE.a / 400)


def test_recording_on_constant_ground_is_the_rigs() -> None:
    usual = make_recording(5, duration=6.0, bristles=400)

    made = make_ground_recording(5, constant_friction(1.3), duration=6.0)

    for channel in ("t", "psi", "M_z", "psi_true", "psi_dot_true", "M_z_true", "F_N_true"):
        own, other = getattr(made, channel), getattr(usual, channel)
        np.testing.assert_allclose(own, other, rtol=0, atol=1e-11, err_msg=channel)


@pytest.mark.parametrize("change", CHANGES)
def test_four_hundred_bristles_are_enough(change: str) -> None:
    coarse, fine = (
        make_ground_recording(6, CHANGES[change], noise=0.0, bristles=n).M_z for n in (400, 4000)
    )

    assert np.max(np.abs(coarse - fine)) < 5e-5 * np.ptp(fine)


def test_full_slide_follows_the_friction() -> None:
    drive = constant_turn(50.0, 10.0, load=LOAD)
    made = make_ground_recording(1, friction_step(5.0, 1.2, 0.5), drive=drive, noise=0.0)

    expected = np.where(made.t < 5.0, 1.2, 0.5) * -full_slide_moment(TYRE, LOAD)
    settled = made.t > 0.2
    np.testing.assert_allclose(made.M_z[settled], expected[settled], rtol=1e-4)
    np.testing.assert_array_equal(made.mu_true, np.where(made.t < 5.0, 1.2, 0.5))


def test_falling_friction_cuts_the_deformation_and_rising_friction_leaves_it() -> None:
    t = np.arange(5) * 0.01
    drive = free_path(t, np.array([0.0, 0.08, 0.08, 0.08, 0.08]), load=LOAD, rate=100.0)

    M_z = simulate_ground(drive, np.array([1.2, 1.2, 1.6, 0.5, 1.2]), TYRE)

    expected = [stopped(0.08, limits) for limits in ([1.2], [1.2], [1.2, 0.5], [1.2, 0.5])]
    np.testing.assert_allclose(M_z[1:], expected, rtol=0, atol=1e-11)
    assert M_z[3] > 0.6 * M_z[1]


def test_rise_has_to_be_turned_into() -> None:
    drive = constant_turn(0.2, 10.0)
    made = make_ground_recording(1, friction_step(5.0, 0.5, 1.2), drive=drive, noise=0.0)

    at = np.searchsorted(made.t, 5.0)

    stiffness = 2 * TYRE.a * TYRE.k * (TYRE.e**2 + TYRE.a**2 / 3)
    jump = np.diff(made.M_z_true)[at - 1]
    assert -0.002 * stiffness <= jump < 0
    assert made.M_z[-1] == pytest.approx(-1.2 * full_slide_moment(TYRE, LOAD), rel=0.01)


def test_path_may_be_free() -> None:
    t = np.linspace(0.0, 4.0, 81)
    psi = 0.1 + 0.2 * np.sin(2 * t)

    exact = {"drive": free_path(t, psi), "noise": 0.0, "encoder_step": 0.0}
    made = make_ground_recording(1, constant_friction(1.0), **exact)

    np.testing.assert_allclose(made.psi[::5], psi, atol=1e-12)
    np.testing.assert_allclose(made.psi_dot_true, 0.4 * np.cos(2 * made.t), atol=0.03)
    assert made.M_z[0] == 0.0


def test_uneven_samples_lie_on_the_even_recordings_path() -> None:
    fading = friction_between(np.array([0.0, 10.0]), np.array([1.3, 0.8]))
    even = make_ground_recording(2, fading, noise=0.0, encoder_step=0.0, rate=400.0)
    times = jitter_instants(1, np.arange(1001) / 100, spread=0.03)

    made = make_ground_recording(2, fading, times=times, noise=0.0, encoder_step=0.0)

    np.testing.assert_array_equal(made.t, times)
    np.testing.assert_allclose(made.psi, np.interp(times, even.t, even.psi), atol=1e-12)
    between = np.interp(times, even.t, even.M_z)
    np.testing.assert_allclose(made.M_z, between, atol=1e-4 * np.ptp(even.M_z))


def test_instants_have_to_lie_within_the_drive() -> None:
    with pytest.raises(ValueError, match="instants must increase"):
        make_ground_recording(2, constant_friction(1.0), duration=2.0, times=np.array([0.0, 2.5]))
