import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from identification import Recording
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import Huber
from identification.residuals.partial_correlations import signatures
from identification.residuals.residual_structure import (
    Unexplained,
    find_residual_structure,
    white_noise_std,
)
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from tests.identification.factories import with_torque

COLUMNS = ("t", "psi", "psi_dot", "M_z", "F_N")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return as_read(make_recording(41, bristles=500), RigTyre())


def noise_of(recording: Recording, seed: int = 1) -> np.ndarray:
    level = 0.004 * torque_range(recording)
    return level * np.random.default_rng(seed).standard_normal(recording.t.size)


def rest(recording: Recording, residual: np.ndarray) -> Unexplained:
    """What is said of a residual left by a model that was right but for it."""
    return said_of(with_torque(recording, recording.M_z - residual + noise_of(recording)), residual)


def said_of(shown: Recording, residual: np.ndarray, *loss: Huber) -> Unexplained:
    residuals = {shown.name: residual}
    return find_residual_structure(residuals, [shown], signatures(residuals, [shown]), *loss)


@pytest.mark.parametrize("level", [0.01, 0.2])
def test_white_noise_on_a_smooth_torque(level: float) -> None:
    t = np.arange(200_000) / 100
    torque = 5 * np.sin(t) + level * np.random.default_rng(1).standard_normal(t.size)

    assert white_noise_std(torque) == pytest.approx(level, rel=0.02)
    torque[::50] = np.nan
    assert white_noise_std(torque) == pytest.approx(level, rel=0.02)


def test_no_noise_at_all() -> None:
    assert white_noise_std(np.linspace(0, 1, 50)) == pytest.approx(0, abs=1e-12)
    assert white_noise_std(np.full(50, np.nan)) == 0


def test_neither_noise_nor_structure_finer_than_the_model_is_reported(recording: Recording) -> None:
    said = rest(recording, noise_of(recording))

    assert not said.present
    assert "structured" not in said.evidence, "which the same line denies"
    little = "; 0.05% beyond it, independent from sample to sample: too little for an effect"
    assert said.evidence.endswith(little)
    wave = 1e-3 * torque_range(recording) * np.sin(2 * np.pi * 0.7 * recording.t)
    assert not rest(recording, wave).present


@pytest.mark.parametrize(
    ("planted", "word"),
    [
        (lambda r: r.t - r.t.mean(), "time"),
        (lambda r: r.psi, "the angle"),
        (lambda r: np.tanh(r.psi_dot / 0.01), "the direction of turning"),
        (lambda r: r.F_N - r.F_N.mean(), "the load"),
    ],
    ids=["time", "angle", "direction", "load"],
)
def test_structure_is_reported_with_what_it_follows(recording: Recording, planted, word: str) -> None:
    shape = planted(recording)
    slow = 0.01 * torque_range(recording) * shape / np.std(shape)
    said = rest(recording, slow + noise_of(recording))

    assert said.present
    assert said.structured == pytest.approx(0.01, rel=0.15)
    assert f"{word} (correlation +" in said.evidence
    assert re.search(r"correlated over \d+ samples\. ", said.evidence)
    assert "\n" not in said.evidence


@pytest.mark.parametrize(("ratio", "present"), [(1.08, False), (1.22, True)])
def test_structure_has_to_stand_above_noise(recording: Recording, ratio: float, present: bool) -> None:
    """An error 8 % above that of the noise is noise, one 22 % above it is not."""
    t, noise = recording.t, noise_of(recording)
    floor = white_noise_std((shown := with_torque(recording, recording.M_z + noise)).M_z)
    wave = np.sin(2 * np.pi * 0.3 * t)
    residual = floor * np.random.default_rng(2).standard_normal(t.size)
    level = np.sqrt(max(0.0, (ratio * floor) ** 2 - np.mean(residual**2)) / np.mean(wave**2))
    residual = residual + level * wave
    residual *= ratio * floor / np.sqrt(np.mean(residual**2))

    assert said_of(shown, residual).present is present


@pytest.mark.parametrize("frequency", [23.0, 25.0, 49.7, 50.0])
@pytest.mark.parametrize("slow", [0.0, 0.006])
def test_a_fast_oscillation_is_no_noise(recording: Recording, frequency: float, slow: float) -> None:
    """Mains hum has larger second differences than its size, and no slow correlation."""
    t, span = recording.t, torque_range(recording)
    hum = 0.015 * span * np.sin(2 * np.pi * frequency * t + 1)
    said = rest(recording, hum + slow * span * np.sin(2 * np.pi * 0.3 * t) + noise_of(recording))

    assert said.present
    assert "predictable from the samples before" in said.evidence
    assert said.structured == pytest.approx(np.hypot(np.std(hum) / span, slow / np.sqrt(2)), rel=0.1)


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_of_short_recordings_is_never_structure(recording: Recording, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for size in (100, 400, recording.t.size):
        short = replace(recording, **{n: getattr(recording, n)[:size] for n in COLUMNS})
        noise = 0.01 * torque_range(short) * rng.standard_normal(size)
        assert not said_of(with_torque(short, short.M_z + noise), noise).present


@pytest.mark.parametrize(("order", "cut"), [(2, 0.6), (2, 0.8), (4, 0.8), (4, 0.9)])
def test_noise_behind_a_filter_is_no_structure(recording: Recording, order: int, cut: float) -> None:
    """A logger's anti-aliasing filter leaves samples correlated, in no line of the spectrum."""
    rng, b_a = np.random.default_rng(order), butter(order, cut)
    noise = 0.01 * torque_range(recording) * lfilter(*b_a, rng.standard_normal(recording.t.size))

    assert not said_of(with_torque(recording, recording.M_z + noise), noise).present


def test_missing_samples(recording: Recording) -> None:
    gone = np.arange(recording.t.size) % 5 == 0
    holed = with_torque(recording, np.where(gone, np.nan, recording.M_z))
    slow = 0.01 * torque_range(recording) * np.sin(2 * np.pi * 0.3 * recording.t)
    noise = noise_of(recording)
    for residual, present in ((noise, False), (slow + noise, True)):
        assert rest(holed, np.where(gone, np.nan, residual)).present is present


def test_the_noise_of_a_torque_that_comes_more_slowly_than_the_angle(recording: Recording) -> None:
    rare = np.arange(recording.t.size) % 5 > 0
    noise = np.where(rare, np.nan, noise_of(recording))
    said = said_of(with_torque(recording, recording.M_z + noise), noise)

    assert "white noise of the torque channel about 0.4" in said.evidence
    assert said.structured < 1.5e-3


def test_outliers_hide_no_structure_from_a_robust_loss(recording: Recording) -> None:
    slow = 0.02 * torque_range(recording) * np.sin(2 * np.pi * 0.3 * recording.t)
    spiked = slow + noise_of(recording)
    spiked[::100] += torque_range(recording)
    shown = with_torque(recording, recording.M_z - spiked + noise_of(recording))

    assert said_of(shown, spiked, Huber(threshold=0.01)).present
    quiet = noise_of(recording)
    quiet[::100] += torque_range(recording)
    assert not said_of(recording, quiet, Huber(threshold=1e-3)).present
