"""A torque sensor that ends is told from a patch that slides, and a patch that slides from it."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording
from identification.reading.sensor_end import sensor_end
from reference_rig import RigRecording, free_path, make_recording, simulate_bristles
from tests.identification.factories import as_read, with_torque


def made(mu: float, seed: int = 590_021, duration: float = 14.0) -> RigRecording:
    return make_recording(seed, mu=mu, duration=duration, bristles=500)


def seen(one: RigRecording, M_z: np.ndarray) -> Recording:
    return with_torque(as_read(one, one.tyre), M_z)


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
    told = sensor_end(seen(one, end * np.tanh(one.M_z / end)))

    assert told is not None
    assert "noise is 0." in told.sign
    assert 0.75 * end < told.torque < 1.01 * end


@pytest.mark.parametrize("share", [0.5, 0.7])
def test_a_sensor_that_ends_does_not_follow_the_load(share: float) -> None:
    one = made(0.8)
    told = sensor_end(clipped(one, share))

    assert told is not None
    assert "while the load changes by" in told.sign
    assert told.torque == pytest.approx(share * float(np.abs(one.M_z_true).max()), rel=0.01)


def test_nothing_is_told_where_the_range_is_declared_or_the_load_does_not_change() -> None:
    ended = clipped(made(0.8), 0.6)

    assert sensor_end(replace(ended, rig=replace(ended.rig, range=3.0))) is None
    assert sensor_end(replace(ended, F_N=np.full(ended.t.size, 400.0))) is None


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
        assert sensor_end(plain) is None


def test_noise_that_hides_the_torque_of_ice_is_no_end_of_the_sensor() -> None:
    one = make_recording(
        720_000, mu=0.02, duration=5.0, bristles=300, load=300.0, noise=0.0, name="ice"
    )

    assert sensor_end(seen(one, noise(one, 0.1) + one.M_z_true)) is None


def test_an_angle_that_trembles_makes_no_noise_where_the_patch_slides() -> None:
    one = made(0.8)
    drive = free_path(one.t, one.psi, load=400.0, rate=100.0)
    torque = simulate_bristles(drive, one.tyre, bristles=500).M_z[: one.t.size]
    trembling = torque + 0.3 * (one.psi - one.psi_true) * 2.4e6 * 0.045**3

    assert sensor_end(seen(one, trembling)) is None
