"""Sensors: their errors on every kind of recording; faults strike what is stated, and nothing else."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reference_rig import (
    Array,
    add_outliers,
    constant_friction,
    delay_samples,
    drop_samples,
    jitter_instants,
    make_ground_recording,
    make_recording,
    make_steering_recording,
)

T = np.arange(1001) / 100
SIGNAL = 3.0 * np.sin(T)
SEEDED: dict[str, Callable[[int], Array]] = {
    "outliers": lambda seed: add_outliers(seed, SIGNAL),
    "dropped": lambda seed: drop_samples(seed, SIGNAL),
    "jittered": lambda seed: jitter_instants(seed, T, spread=0.03),
}


RECORDINGS: dict[str, tuple[Callable[[int], Any], str, float]] = {
    "rig": (lambda seed: make_recording(seed, duration=3.0), "M_z", 4.2e-5),
    "ground": (lambda seed: make_ground_recording(seed, constant_friction(1.0)), "M_z", 4.2e-5),
    "steering": (lambda seed: make_steering_recording(seed, duration=3.0), "M", 2 * np.pi / 2**14),
}
"""Recordings by seed, with the name of their torque and the step of their encoder [rad]."""


@pytest.mark.parametrize("kind", RECORDINGS)
def test_channels_of_a_recording(kind: str) -> None:
    make, torque, step = RECORDINGS[kind]
    made, same, other = (make(seed) for seed in (3, 3, 4))
    shown, true = getattr(made, torque), getattr(made, f"{torque}_true")

    assert np.std(shown - true) == pytest.approx(0.004 * np.ptp(true), rel=0.1)
    assert np.max(np.abs(made.psi - made.psi_true)) <= 0.5 * step * (1 + 1e-9)
    np.testing.assert_allclose(made.psi / step, np.round(made.psi / step), atol=1e-8)
    assert np.std(made.F_N - made.F_N_true) == pytest.approx(4e-4 * 400, rel=0.1)
    np.testing.assert_allclose(np.diff(made.t), 0.001 if torque == "M" else 0.01, rtol=1e-9)
    np.testing.assert_array_equal(shown, getattr(same, torque))
    assert not np.array_equal(shown, getattr(other, torque))


@pytest.mark.parametrize("fault", SEEDED)
def test_seed_decides(fault: str) -> None:
    make = SEEDED[fault]

    np.testing.assert_array_equal(make(1), make(1))
    assert not np.array_equal(make(1), make(2), equal_nan=True)


def test_outliers_are_one_range_off() -> None:
    faulty = add_outliers(3, SIGNAL)
    off = faulty - SIGNAL
    struck = off != 0

    assert np.count_nonzero(struck) == 10
    np.testing.assert_allclose(np.abs(off[struck]), np.ptp(SIGNAL), rtol=1e-12)
    assert {-1.0, 1.0} == set(np.sign(off[struck]))


def test_outliers_strike_finite_samples_only() -> None:
    signal = drop_samples(1, SIGNAL, share=0.5)

    faulty = add_outliers(2, signal, share=0.1, size=100.0)

    np.testing.assert_array_equal(np.isnan(faulty), np.isnan(signal))
    assert np.count_nonzero(np.abs(faulty) > 90) == 50


def test_dropped_samples() -> None:
    faulty = drop_samples(3, SIGNAL)
    lost = np.isnan(faulty)

    assert np.count_nonzero(lost) == 200
    assert not lost[0]
    np.testing.assert_array_equal(faulty[~lost], SIGNAL[~lost])
    assert np.count_nonzero(np.isnan(drop_samples(3, SIGNAL, share=1.0))) == 1000


def test_late_samples() -> None:
    np.testing.assert_array_equal(delay_samples(SIGNAL, 3), np.append([np.nan] * 3, SIGNAL[:-3]))
    np.testing.assert_array_equal(delay_samples(SIGNAL, 0), SIGNAL)


@pytest.mark.parametrize("spread", [0.0, 0.005, 0.03, 0.5])
def test_jitter_keeps_increasing_within_the_time(spread: float) -> None:
    moved = jitter_instants(3, T, spread=spread)

    assert len(moved) == len(T)
    assert np.all(np.diff(moved) > 0.99e-4)
    assert moved[0] >= 0
    assert moved[-1] <= 10.0
    assert np.max(np.abs(moved - T)) <= 0.5 * spread + 0.002


def test_jitter_below_the_interval_is_uniform() -> None:
    moved = jitter_instants(3, T, spread=0.008)[1:-1] - T[1:-1]

    assert np.std(moved) == pytest.approx(0.008 / np.sqrt(12), rel=0.05)


def test_long_jitter_makes_uneven_intervals() -> None:
    intervals = np.diff(jitter_instants(3, T, spread=0.03))

    assert intervals.min() < 0.002
    assert intervals.max() > 0.025
    assert np.mean(intervals) == pytest.approx(0.01, rel=0.01)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        *(
            (lambda s=s: drop_samples(1, SIGNAL, share=s), "between 0 and 1")
            for s in (-0.1, 1.1, np.nan)
        ),
        (lambda: delay_samples(SIGNAL, -1), "late by 0 to 1001"),
        (lambda: jitter_instants(1, T, spread=0.01, least=0.01), "do not fit"),
    ],
)
def test_bad_input(fault: Callable[[], Array], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fault()
