"""A torque sensor that ends is told from a patch that slides, and a patch that slides from it."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Channel, LowPass, Recording
from identification.reading.trimming_and_thinning import recording_at_samples
from identification.reading.undeclared_sensor_limit import SensorSaturation, detect_saturation
from reference_rig import RigRecording, free_path, make_recording, simulate_bristles
from tests.identification.factories import as_read, with_torque


def made(mu: float, seed: int = 590_021, duration: float = 14.0) -> RigRecording:
    return make_recording(seed, mu=mu, duration=duration, bristles=500)


def seen(one: RigRecording, M_z: np.ndarray) -> Recording:
    return with_torque(as_read(one, one.tyre), M_z)


def ending(recording: Recording) -> SensorSaturation | None:
    return detect_saturation(recording.aligning_or_steering_torque, recording.psi, recording.F_N)


def noise(one: RigRecording, std: float) -> np.ndarray:
    return std * np.random.default_rng(7).standard_normal(one.t.size)


def clipped(one: RigRecording, share: float) -> Recording:
    end = share * float(np.abs(one.M_z_true).max())
    return seen(one, np.clip(one.M_z_true, -end, end) + noise(one, 0.01 * end))


@pytest.mark.parametrize("mu", [0.1, 0.8])
@pytest.mark.parametrize("share", [0.5, 0.8])
def test_a_sensor_that_gives_way_flattens_its_noise(mu: float, share: float) -> None:
    one = made(mu)
    end = share * float(np.abs(one.M_z).max())
    told = ending(seen(one, end * np.tanh(one.M_z / end)))

    assert told is not None
    assert "noise is 0." in told.sign
    assert 0.75 * end < told.torque < 1.01 * end


def turned(psi: np.ndarray, load: np.ndarray | float, mu: float, share: float) -> Recording:
    """Of bristles that turn at 100 Hz; noise of the torque as a share of its greatest."""
    t, one = np.arange(psi.size) * 0.01, made(mu)
    drive = free_path(t, psi, load=load, rate=100.0)
    torque = simulate_bristles(drive, one.tyre, bristles=500).M_z[: t.size]
    std, rng = share * float(np.abs(torque).max()), np.random.default_rng(8)
    return replace(
        seen(one, one.M_z), t=t, psi=psi, psi_dot=np.gradient(psi, t),
        M_z=torque + std * rng.standard_normal(t.size),
        F_N=np.broadcast_to(load, t.size),
    )  # fmt: skip


def uneven(load: np.ndarray, share: float) -> np.ndarray:
    return load * (1 + share * np.random.default_rng(9).standard_normal(load.size))


@pytest.mark.parametrize("load_noise", [0.0, 0.01])
@pytest.mark.parametrize("share", [0.5, 0.7])
def test_a_sensor_that_ends_does_not_follow_the_load(share: float, load_noise: float) -> None:
    one = made(0.8)
    ended = clipped(one, share)
    told = ending(replace(ended, F_N=uneven(ended.F_N, load_noise)))

    assert told is not None
    assert "while the load changes by" in told.sign
    assert told.torque == pytest.approx(share * float(np.abs(one.M_z_true).max()), rel=0.01)


def test_nothing_is_told_where_the_load_hardly_changes() -> None:
    ended = clipped(made(0.8), 0.6)

    assert ending(replace(ended, F_N=np.full(ended.t.size, 400.0))) is None
    mean = float(ended.F_N.mean())
    assert ending(ended) is not None
    assert ending(replace(ended, F_N=mean + 0.4 * (ended.F_N - mean))) is None


@pytest.mark.parametrize("std", [0.003, 0.02, 0.1])
@pytest.mark.parametrize("mu", [0.02, 0.1, 0.3, 0.8, 2.0])
def test_a_patch_that_slides_is_none(mu: float, std: float) -> None:
    one = made(mu)
    M_z = one.M_z_true + noise(one, std)
    load = one.F_N_true * (1 + noise(one, 0.01))

    for plain in (
        seen(one, M_z),
        replace(seen(one, M_z), F_N=load),
        seen(one, 0.05 * np.round(M_z / 0.05)),
    ):
        assert ending(plain) is None


def test_a_load_that_hardly_counts_beside_the_noise_is_no_evidence() -> None:
    one = make_recording(750_000, mu=0.02, duration=25.0, load=580.0, e=0.0, bristles=300)

    for seed in range(8):
        rough = 0.02 * np.random.default_rng(seed).standard_normal(one.t.size)
        assert ending(seen(one, one.M_z_true + rough)) is None


@pytest.mark.parametrize("load_noise", [0.01, 0.04])
@pytest.mark.parametrize("wander", [0.0, 0.03])
def test_a_wheel_that_slides_for_seconds_is_none(wander: float, load_noise: float) -> None:
    t = np.arange(0.0, 14.0, 0.01)
    psi = 0.5 * (2 / np.pi) * np.arcsin(np.sin(0.9 * t))
    swept = turned(psi, 400 * (1 + wander * np.sin(0.4 * t)), 0.8, 0.005)

    assert ending(replace(swept, F_N=uneven(swept.F_N, load_noise))) is None


@pytest.mark.parametrize("load_noise", [0.0, 0.005, 0.04])
@pytest.mark.parametrize("noise_share", [0.0005, 0.001])
@pytest.mark.parametrize("mu", [0.3, 0.8])
def test_a_fast_wheel_that_slides_is_none(mu: float, noise_share: float, load_noise: float) -> None:
    # Of a torque next to noiseless the differences are those of its curve.
    swept = turned(0.3 * np.sin(2 * np.pi * np.arange(0.0, 40.0, 0.01)), 400.0, mu, noise_share)
    psi = swept.psi + 1e-5 * np.random.default_rng(10).standard_normal(swept.psi.size)

    assert ending(replace(swept, psi=psi, F_N=uneven(swept.F_N, load_noise))) is None


@pytest.mark.parametrize("cutoff", [5.0, 8.0, 20.0])
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.8])
def test_a_low_pass_is_no_end_of_the_sensor(mu: float, cutoff: float) -> None:
    one = made(mu)
    rough = Channel(values=one.M_z_true + noise(one, 0.02), rate=100.0)

    assert ending(seen(one, LowPass(cutoff=cutoff)(rough).values)) is None


@pytest.mark.parametrize("seed", range(590_030, 590_036))
def test_noise_that_hides_the_torque_of_ice_is_no_end_of_the_sensor(seed: int) -> None:
    one = made(0.05, seed)

    assert ending(seen(one, one.M_z_true + noise(one, 0.15))) is None


@pytest.mark.parametrize("mu", [0.05, 0.8])
def test_an_angle_that_trembles_makes_no_noise_where_the_patch_slides(mu: float) -> None:
    one = made(mu)
    drive = free_path(one.t, one.psi, load=400.0, rate=100.0)
    torque = simulate_bristles(drive, one.tyre, bristles=500).M_z[: one.t.size]

    assert ending(seen(one, torque)) is None


def test_too_few_samples_tell_nothing() -> None:
    one = made(0.8, duration=5.0)
    short = recording_at_samples(seen(one, one.M_z), np.arange(4))

    assert ending(short) is None
    assert ending(replace(short, M_z=np.full(4, np.nan), M=np.full(4, np.nan))) is None
