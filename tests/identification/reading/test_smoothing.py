import numpy as np
import pytest
from scipy.signal import savgol_filter

from identification.reading.yaw_rate import smoothed_rate


def test_is_savitzky_golay_where_sampling_is_uniform() -> None:
    t = np.arange(300) * 0.01
    psi = np.random.default_rng(0).normal(size=300)

    expected = savgol_filter(psi, 11, 2, deriv=1, delta=0.01)
    np.testing.assert_allclose(smoothed_rate(t, psi), expected, atol=1e-9)


@pytest.mark.parametrize("n", [3, 5, 10, 500])
def test_a_parabola_is_exact_on_any_grid(n: int) -> None:
    t = np.cumsum(np.random.default_rng(n).uniform(0.002, 0.03, n))
    psi = 0.3 - 2 * t + 5 * t**2

    np.testing.assert_allclose(smoothed_rate(t, psi), -2 + 10 * t, atol=1e-8)


def test_steps_of_the_encoder_are_smoothed() -> None:
    t = np.arange(2000) * 0.01
    step = 4.2e-5
    psi = np.round(0.3 * np.sin(t) / step) * step
    error = smoothed_rate(t, psi) - 0.3 * np.cos(t)

    assert np.abs(error).max() < 8e-4
    assert np.std(error) < 2e-4  # a difference of neighbours has 1.7e-3


def test_a_pause_of_the_clock_does_not_leak() -> None:
    t = np.concatenate([np.arange(100) * 0.01, 60 + np.arange(100) * 0.01])
    psi = np.where(t < 30, 0.2 * t, 5.0 - 0.1 * (t - 60))
    rate = smoothed_rate(t, psi)

    np.testing.assert_allclose(rate[:90], 0.2, atol=1e-6)
    np.testing.assert_allclose(rate[110:], -0.1, atol=1e-6)
    np.testing.assert_allclose(rate[90:100], 0.2, atol=0.01)
    np.testing.assert_allclose(rate[100:110], -0.1, atol=0.01)


def test_long_recordings_are_worked_through_in_blocks() -> None:
    t = np.arange(60_000) * 1e-3
    psi = np.sin(t)

    np.testing.assert_allclose(smoothed_rate(t, psi), np.cos(t), atol=5e-3)
