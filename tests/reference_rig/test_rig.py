"""The rig's patch, path, recordings and sensors against facts that are known without it."""

import runpy
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference_rig import (
    Array,
    RigRecording,
    add_outliers,
    constant_friction,
    delay_samples,
    drop_samples,
    hand_path,
    jitter_instants,
    make_campaign,
    make_ground_recording,
    make_recording,
    make_steering_recording,
    plant_effect,
)


@pytest.mark.parametrize("seed", range(8))
def test_hand_turns_like_a_hand(seed: int) -> None:
    path = hand_path(seed)
    speed = np.abs(path.psi_dot)
    reversals = np.flatnonzero(np.diff(np.sign(path.psi_dot[path.psi_dot != 0])))

    assert not np.any(path.psi[path.t < 0.49])
    assert 0.15 < np.max(np.abs(path.psi)) < 0.6
    assert len(reversals) >= 3
    assert speed.max() < 0.45
    assert np.mean((speed > 0.03) & (speed < 0.35)) > 0.6
    assert np.all(np.abs(path.F_N / 400 - 1) < 0.07)
    steps = 0.5 * (path.psi_dot[1:] + path.psi_dot[:-1]) / 400
    np.testing.assert_allclose(np.diff(path.psi), steps, atol=1e-15)


def test_silent_recording_is_the_truth() -> None:
    made = make_recording(3, noise=0.0, encoder_step=0.0)

    assert np.array_equal(made.M_z, made.M_z_true)
    assert np.array_equal(made.psi, made.psi_true)
    assert np.array_equal(made.F_N, made.F_N_true)


def _share(made: RigRecording) -> float:
    tyre = made.tyre
    without = make_recording(12, **vars(tyre), noise=0.0, duration=5.0).M_z
    return float(np.sqrt(np.mean((made.M_z_true - without) ** 2)) / np.ptp(without))


@pytest.mark.parametrize(
    "name", [pytest.param("carcass_torsion", marks=pytest.mark.long), "friction_drift", "gust"]
)
def test_planted_effect_is_as_strong_as_asked(name: str) -> None:
    assert _share(plant_effect(name, 12, share=0.06, duration=5.0)) == pytest.approx(0.06, rel=0.03)


def test_campaign_shares_the_tyre_and_its_effect_and_not_the_day() -> None:
    made = make_campaign("torque_offset", 4, duration=3.0)
    tyres = [recording.tyre for recording in made.recordings]

    assert len({tyre.k for tyre in tyres}) == len({tyre.a for tyre in tyres}) == 1
    assert len({tyre.mu for tyre in tyres}) == 3
    assert len({recording.effects["torque_offset"]["M_0"] for recording in made.recordings}) == 3
    assert made.nominal.a == tyres[0].a
    assert 0.8 <= made.nominal.k / tyres[0].k <= 1.2
    made = make_campaign("bearing_friction", 4, 2, duration=3.0, also={"torque_offset": {"M_0": 0.2}})
    assert made.recordings[0].effects == made.recordings[1].effects
    assert set(made.recordings[0].effects) == {"bearing_friction", "torque_offset"}


@pytest.mark.long
def test_embedded_recordings_are_made_by_the_rig(repository_root: Path) -> None:
    folder = repository_root / "examples" / "recordings"
    made = runpy.run_path(str(folder.parent / "make_recordings.py"))["files"]()

    assert {path.name for path in folder.iterdir()} == set(made)
    for name, text in made.items():
        assert (folder / name).read_text(encoding="utf-8") == text, name


def test_a_campaign_elsewhere_differs_in_lengths_and_friction_alone() -> None:
    there, usual = (
        make_campaign(None, 4, 4, duration=2.0, off=off, grounds=grounds)
        for off, grounds in ((0.0025, ("steel", "emery")), (0.0, ()))
    )

    assert [r.ground for r in there.recordings] == ["steel", "emery"] * 2
    assert [r.ground for r in usual.recordings] == [None] * 4
    assert there.nominal == usual.nominal
    offs = [r.tyre.a - there.nominal.a for r in there.recordings]
    assert max(map(abs, offs)) <= 0.0025
    assert len(set(offs)) == 4
    both = zip(there.recordings, usual.recordings, strict=True)
    ratios = [one.tyre.mu / two.tyre.mu for one, two in both]
    assert ratios[0] == pytest.approx(ratios[2])
    assert ratios[1] == pytest.approx(ratios[3])
    assert abs(ratios[0] - ratios[1]) > 0.01
    for one, two in zip(there.recordings, usual.recordings, strict=True):
        np.testing.assert_allclose(one.psi, two.psi)
        np.testing.assert_allclose(one.F_N, two.F_N, rtol=0.02)


T = np.arange(1001) / 100
SIGNAL = 3.0 * np.sin(T)
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


@pytest.mark.parametrize("fault", [add_outliers, drop_samples, partial(jitter_instants, spread=0.03)])
def test_seed_decides(fault: Callable[[int, Array], Array]) -> None:
    np.testing.assert_array_equal(fault(1, T), fault(1, T))
    assert not np.array_equal(fault(1, T), fault(2, T), equal_nan=True)


def test_outliers_are_one_range_off_and_strike_finite_samples_only() -> None:
    faulty = add_outliers(3, SIGNAL)
    off = faulty - SIGNAL
    struck = off != 0

    assert np.count_nonzero(struck) == 10
    np.testing.assert_allclose(np.abs(off[struck]), np.ptp(SIGNAL), rtol=1e-12)
    assert {-1.0, 1.0} == set(np.sign(off[struck]))
    signal = drop_samples(1, SIGNAL, share=0.5)
    faulty = add_outliers(2, signal, share=0.1, size=100.0)
    np.testing.assert_array_equal(np.isnan(faulty), np.isnan(signal))
    assert np.count_nonzero(np.abs(faulty) > 90) == 50


def test_dropped_and_late_samples() -> None:
    faulty = drop_samples(3, SIGNAL)
    lost = np.isnan(faulty)

    assert np.count_nonzero(lost) == 200
    assert not lost[0]
    np.testing.assert_array_equal(faulty[~lost], SIGNAL[~lost])
    assert np.count_nonzero(np.isnan(drop_samples(3, SIGNAL, share=1.0))) == 1000
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
