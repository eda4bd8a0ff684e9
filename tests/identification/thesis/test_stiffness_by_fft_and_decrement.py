"""The thesis's method on free vibrations of the independent rig: its errors, and what it lacks."""

import tracemalloc

import numpy as np
import pytest

from identification import Decay
from identification.thesis.stiffness_by_fft_and_decrement import estimate_by_decrement
from reference_rig import CONTACT_HALF_LENGTHS as LENGTHS
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import make_impacts
from rig_recordings import as_decay


def test_is_off_by_sliding() -> None:
    estimate = estimate_by_decrement([as_decay(impact) for impact in make_impacts(3, impacts=1)])

    assert 0.0005 < abs(estimate.k / TYRE.k - 1) < 0.02
    assert 0.04 < estimate.b_t / B_T - 1 < 0.15
    # (5.8) as printed lacks J_A; all recordings have the same.
    assert estimate.b_t_printed == pytest.approx(estimate.b_t / 0.151764, rel=1e-4)
    assert [vibration.a for vibration in estimate.vibrations] == sorted(LENGTHS)


def test_fast_samples_take_no_memory() -> None:
    t = 1e-6 * np.arange(200)
    psi = 0.02 * np.exp(-4e3 * t) * np.cos(2 * np.pi * 2e4 * t)
    impact = as_decay(make_impacts(3, impacts=1)[0])
    tracemalloc.start()
    fast = Decay(name="fast", t=t, psi=psi, rig=impact.rig, tyre=impact.tyre)
    estimate = estimate_by_decrement([fast])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert peak < 3e8
    assert estimate.vibrations[0].omega_n == pytest.approx(2 * np.pi * 2e4, rel=0.05)
