"""The struck wheel against the steered one, its steps, its sensor, and its files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reference_rig import CONTACT_HALF_LENGTHS as LENGTHS
from reference_rig import (
    FOURTEEN_BIT_STEP,
    IMPACT_PULSE,
    Wheel,
    inertia,
    load_at,
    make_impact,
    make_impacts,
    simulate_impact,
    simulate_steering,
    write_impacts,
)
from reference_rig import IMPACT_STEP as STEP
from reference_rig import THESIS_TYRE as TYRE

WHEEL = Wheel(J_A=inertia(TYRE.e), b_t=1.04)


def test_inertia_is_the_authors() -> None:
    assert inertia(0.009) == pytest.approx(0.151764, rel=1e-5)


def test_step_is_short_enough() -> None:
    _, coarse = simulate_impact(TYRE, WHEEL, 0.05, load=400.0)
    _, fine = simulate_impact(TYRE, WHEEL, 0.05, load=400.0, step=STEP / 4)

    np.testing.assert_allclose(coarse, fine[::4], rtol=0, atol=2e-4 * np.ptp(fine))


def test_patch_is_the_steered_wheels() -> None:
    t, psi = simulate_impact(TYRE, WHEEL, 0.05, load=400.0, at=0.0, duration=0.6)
    shape = np.where(t < IMPACT_PULSE, np.sin(np.pi * t / IMPACT_PULSE), 0.0)
    command, n = 0.05 * shape / (STEP * shape.sum()), len(t)

    load, mu, rig = np.full(n, 400.0), np.full(n, TYRE.mu), {"tyre": TYRE, "wheel": WHEEL}
    steered = simulate_steering(command, load, mu, step=STEP, bristles=5000, **rig)

    # The steered wheel's bristles stand evenly, where few of them slide.
    np.testing.assert_allclose(psi, steered.psi, rtol=0, atol=5e-5 * np.ptp(psi))


def test_sensor() -> None:
    made, other = make_impact(3), make_impact(4)

    assert np.max(np.abs(made.psi - made.psi_true - made.zero)) <= FOURTEEN_BIT_STEP / 2 * (1 + 1e-9)
    np.testing.assert_allclose(np.diff(made.t), 0.001, rtol=1e-9)
    np.testing.assert_array_equal(make_impact(3).psi, made.psi)
    assert not np.array_equal(other.psi, made.psi)
    assert 0.003 < np.abs(made.psi_true).max() < 0.01


def test_campaign_and_its_files(tmp_path: Path) -> None:
    made = make_impacts(1, impacts=1, duration=0.3)
    paths = write_impacts(tmp_path, made)

    assert [recording.tyre for recording in made] == [replace(TYRE, a=a) for a in LENGTHS]
    assert [recording.F_N for recording in made] == [load_at(a) for a in LENGTHS]
    assert len({recording.name for recording in made}) == len(LENGTHS)
    first = paths[0].read_text()
    assert first.startswith("# a = 0.03\nt,psi\n0,")
    psi = np.loadtxt(paths[0], delimiter=",", skiprows=2)[:, 1]
    np.testing.assert_allclose(psi, made[0].psi, atol=1e-9)
