"""Raw channels of the reference rig at 4 kHz, with offset, noise and mains hum, against its truth."""

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from identification import (
    Channel,
    LowPass,
    OffsetRemoved,
    Pipeline,
    Recording,
    Resampler,
    Scaled,
    default_pipeline,
    recording_from_raw,
)
from reference_rig import Array, Hand, RigTyre, hand_path, simulate_bristles
from symbolic import Rig, Tyre
from tests.refusal import refused

RATE, EVERY = 4000.0, 40
LOAD = 400.0
VOLTS = {"psi": 0.3, "M_z": -5.0, "F_N": 250.0}
"""Units a volt; the torque's amplifier counts the other way."""
OFFSETS = {"psi": 0.7, "M_z": -0.4, "F_N": 0.9}
HUM, NOISE = 0.05, 0.02
"""Of every channel [V]."""
QUIET = (0.0, 0.4)


class RawChannels(NamedTuple):
    """What the amplifiers gave, and the truth at 100 Hz."""

    raw: dict[str, Channel]
    truth: dict[str, Array]


@cache
def raw_and_truth() -> RawChannels:
    drive = hand_path(5, 5.0, hand=Hand(quiet=0.5), load=LOAD, rate=RATE)
    M_z = simulate_bristles(drive, RigTyre(), bristles=400).M_z
    rng = np.random.default_rng(5)
    raw, truth = {}, {"psi": drive.psi, "M_z": M_z, "F_N": drive.F_N}
    for name, values in truth.items():
        hum = HUM * np.sin(2 * np.pi * 50 * drive.t + rng.uniform(0, 2 * np.pi))
        noise = NOISE * rng.standard_normal(values.size)
        raw[name] = Channel(values=values / VOLTS[name] + OFFSETS[name] + hum + noise, rate=RATE)
    return RawChannels(raw, {name: values[::EVERY] for name, values in truth.items()})


def usual() -> dict[str, Pipeline]:
    levels = {"F_N": float(raw_and_truth().truth["F_N"][:40].mean())}
    return {
        name: default_pipeline(volts, QUIET, level=levels.get(name, 0.0))
        for name, volts in VOLTS.items()
    }


def recording(**changed: Any) -> Recording:
    given: dict[str, Any] = {"raw": raw_and_truth().raw, "pipelines": usual(), **changed}
    return recording_from_raw("raw", rig=Rig(a=0.045, e=0.009), tyre=Tyre(k=2.4e6), **given)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def every_fortieth(name: str) -> Array:
    """As in [Györök 2022]: offset off, then under-sampled."""
    values = VOLTS[name] * raw_and_truth().raw[name].values
    return (values - values[: round(QUIET[1] * RATE)].mean())[::EVERY]


@pytest.mark.parametrize("name", ["psi", "M_z"])
def test_the_truth_comes_back_and_hum_leaks_in_at_the_ends_by_less_than_half(name: str) -> None:
    truth = raw_and_truth().truth[name]
    error, naive = getattr(recording(), name) - truth, rms(every_fortieth(name) - truth)

    assert rms(error) < 4e-3 * np.ptp(truth)
    assert rms(error) < 0.2 * naive
    assert np.abs(error[[*range(5), *range(-5, 0)]]).max() < 0.4 * HUM * abs(VOLTS[name])


def test_the_load_keeps_its_level() -> None:
    error = recording().F_N - raw_and_truth().truth["F_N"]

    assert abs(error.mean()) < 0.5
    assert rms(error) < 0.005 * LOAD


def test_hum_is_down_by_what_the_filter_says() -> None:
    hum = np.sin(2 * np.pi * 50 * np.arange(8000) / RATE)
    after = LowPass(cutoff=20, order=4)(Channel(values=hum, rate=RATE)).values[1000:-1000]

    # Twice Butterworth: 1 / (1 + (f / f_c)^(2 n)), as good as unwarped at 4 kHz.
    assert np.abs(after).max() == pytest.approx(1 / (1 + 2.5**8), rel=0.02)


def test_scaled_and_offset_by_hand() -> None:
    volts = Channel(values=np.r_[np.full(20, 1.5), 2.5], rate=10.0)
    scaled = Scaled(factor=-2.0)(volts)

    assert OffsetRemoved(start=0, stop=2)(scaled).values.tolist() == [0.0] * 20 + [-2.0]
    assert OffsetRemoved(start=0, stop=2, level=7)(scaled).values[0] == 7


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (lambda: Scaled(factor=0), "factor"),
        (lambda: OffsetRemoved(start=1, stop=1), "0 <= start < stop"),
        (lambda: OffsetRemoved(start=0, stop=1, level=np.nan), "level"),
        (lambda: LowPass(cutoff=np.nan), "cutoff"),
        (lambda: LowPass(cutoff=20, order=0), "order"),
        (lambda: Resampler(rate=0), "rate"),
        (lambda: Channel(values=np.zeros(9), rate=-1), "rate"),
        (lambda: Channel(values=np.zeros((3, 3)), rate=1), "shape"),
        (lambda: Channel(values=np.array([0, 1, np.nan]), rate=1), "sample 2 is not finite"),
    ],
)
def test_nonsense_is_refused(step: Any, message: str) -> None:
    assert message in refused(step)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"psi": Pipeline((OffsetRemoved(start=0, stop=99),))}, "psi: the quiet stretch"),
        ({"M_z": Pipeline((LowPass(cutoff=2000),))}, "M_z: cutoff must be less than half the rate"),
        ({"M_z": Pipeline((Resampler(rate=99.999),))}, "M_z: 99.999 Hz from 4000.0 Hz is no ratio"),
        ({"M_z": Pipeline((Resampler(rate=200.0),))}, "must end alike"),
    ],
)
def test_an_impossible_step_names_its_channel(changes: Mapping[str, Pipeline], message: str) -> None:
    assert message in refused(recording, pipelines=usual() | changes)


def test_a_missing_channel_is_named() -> None:
    raw = {name: raw_and_truth().raw[name] for name in ("psi", "M_z")}
    assert "F_N needs a raw channel" in refused(recording, raw=raw)
