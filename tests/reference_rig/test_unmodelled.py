"""The rig's effects that no library has, each against its own law worked out by hand."""

import numpy as np
import pytest

from reference_rig import (
    RENEWAL,
    RigDrive,
    RigTyre,
    build_effects,
    contact_age,
    hand_path,
    make_campaign,
    simulate_bristles,
)

TYRE = RigTyre(e=0.009)
LOAD = 400.0
Array = np.ndarray[tuple[int], np.dtype[np.float64]]


def drive(psi: Array, dt: float = 0.01) -> RigDrive:
    """Angles at an even clock under a constant load."""
    rate = np.gradient(psi, dt)
    t = np.arange(psi.size) * dt
    return RigDrive(t=t, psi=psi, psi_dot=rate, F_N=np.full(psi.size, LOAD), psi_virgin=float(psi[0]))


def torque(path: RigDrive, **planted: dict[str, float]) -> Array:
    return simulate_bristles(path, TYRE, build_effects(planted), bristles=200).M_z


def test_a_free_branch_relaxes_and_outgrows_friction() -> None:
    stiffness, time = 300.0, 0.4
    turned = np.concatenate([np.linspace(0, 0.5, 101), np.full(80, 0.5)])

    path = drive(turned)
    added = torque(path) - torque(path, free_branch={"stiffness": stiffness, "time": time})

    # psi' = 0.5 rad/s: twist = psi' tau (1 - exp(-t / tau)), then it decays.
    steady = 0.5 * time * (1 - np.exp(-1.0 / time))
    assert added[100] == pytest.approx(stiffness * steady, rel=1e-9)
    assert added[180] == pytest.approx(stiffness * steady * np.exp(-0.8 / time), rel=1e-9)
    assert added[100] > 2 * np.abs(torque(path)).max()


def test_an_eccentric_encoder_errs_by_a_sine() -> None:
    path = drive(0.4 * np.sin(np.linspace(0, 9, 300)))
    law = {"amplitude": 0.004, "cycles": 8.0, "phase": 0.7}

    wheel = drive(path.psi + 0.004 * np.sin(8.0 * path.psi + 0.7))

    np.testing.assert_allclose(torque(path, encoder_eccentricity=law), torque(wheel), atol=1e-12)
    (effect,) = build_effects({"encoder_eccentricity": law})
    np.testing.assert_allclose(effect.drive(path).psi_dot, wheel.psi_dot, rtol=0, atol=2e-3)


def test_a_torque_sensor_lags_by_its_height() -> None:
    path = hand_path(2, 8.0, rate=100.0)
    bare, height = torque(path), 0.5

    shown = torque(path, sensor_hysteresis={"height": height})

    behind = bare - shown
    rising, falling = np.diff(bare) > 0, np.diff(bare) < 0
    moved = np.diff(shown) != 0
    assert np.abs(behind).max() <= height + 1e-12
    np.testing.assert_allclose(behind[1:][moved & rising], height, atol=1e-9)
    np.testing.assert_allclose(behind[1:][moved & falling], -height, atol=1e-9)


def test_a_contact_ages_at_rest_and_is_renewed_by_turning() -> None:
    dt = 0.01
    psi = np.concatenate([np.zeros(200), np.linspace(0, 3, 501)[1:], np.full(100, 3.0)])

    age = contact_age(psi, np.full(psi.size, dt))

    assert age[199] == pytest.approx(199 * dt)
    # Steady: renewal over rate; then rest adds to it.
    assert age[699] == pytest.approx(RENEWAL / 0.6, rel=1e-6)
    assert age[799] == pytest.approx(RENEWAL / 0.6 + 100 * dt, rel=1e-6)


def test_a_rested_contact_holds_more() -> None:
    path = drive(np.concatenate([np.zeros(5000), np.linspace(0, 2.0, 4000)]))

    rested, bare = torque(path, contact_ageing={"gain": 0.2}), torque(path)

    assert np.abs(rested).max() > 1.03 * np.abs(rested[-1])
    age = RENEWAL / 0.05
    assert rested[-1] / bare[-1] == pytest.approx(1 + 0.2 * np.log1p(age), rel=1e-2)


def test_a_weak_effect_is_as_weak_as_asked() -> None:
    weak = make_campaign("bearing_friction", 3, 1, duration=5.0, shares=(0.01, 0.03))

    assert 0.009 < weak.share < 0.031
