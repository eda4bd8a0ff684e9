"""A sensor that jumps, or gives what no wheel has, costs its samples and no more."""

from dataclasses import replace
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identification import read_recording
from observers import Ekf, Loop, Mhe, Sample, Status, Tuning, run, smooth
from reference_rig import RigRecording, make_recording
from tests.observers.conftest import EXACT_RIG, RIG, make
from tests.observers.factories import acquiring_ekf, columns_of, samples_of, wrong_and_usable

AT = 700
REZERO = 10
"""Samples that `Tuning.rezero_time` lasts."""


def faulty(samples: list[Sample], at: slice, **faults: Any) -> list[Sample]:
    """Samples of which some have faults: functions of what a field would be."""
    places = range(len(samples))[at]
    return [
        replace(s, **{n: fault(getattr(s, n)) for n, fault in faults.items()}) if i in places else s
        for i, s in enumerate(samples)
    ]


def along(observer: Any, samples: list[Sample]) -> tuple[Any, list[Status]]:
    loop = Loop(observer)
    estimates = [loop(replace(sample, psi_dot=nan)) for sample in samples]
    return np.array([e.mu for e in estimates]), [e.status for e in estimates]


@pytest.fixture(scope="module")
def samples(recording: RigRecording) -> list[Sample]:
    return samples_of(columns_of(recording, slice(900)))


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_a_spike_of_the_angle_is_left_out(kind: Any, samples: list[Sample]) -> None:
    expected, _ = along(make(kind), samples)
    spike = faulty(samples, slice(AT, AT + 1), psi=lambda psi: psi - 0.32)
    mu, status = along(make(kind), spike)

    assert status[AT] == Status.IMPLAUSIBLE | Status.MISSING | Status.HELD
    assert status[AT + 1] == Status.USED
    assert np.abs(mu - expected).max() < 2e-3
    unlimited, silent = along(make(kind, psi_rate_limit=inf), spike)
    assert np.abs(unlimited - expected).max() > 0.05, "a spike that does no harm shows nothing"
    assert Status.IMPLAUSIBLE not in silent[AT]


@pytest.mark.parametrize("size", [6.3, -1e6, 9e8])
def test_an_angle_that_no_wheel_has_does_not_move_friction(size: float, samples: list[Sample]) -> None:
    mu, status = along(make(Ekf), faulty(samples, slice(AT, None), psi=lambda _: size))

    assert np.abs(mu[AT:] - mu[AT - 1]).max() < 1e-7
    assert all(Status.IMPLAUSIBLE in each for each in status[AT:])
    assert not any(Status.BOUND in each for each in status[AT:])


@pytest.mark.parametrize("jump", [-0.4, 2.0])
def test_a_new_zero_of_a_sensor_is_taken_off_after_its_time(jump: float, samples: list[Sample]) -> None:
    expected, _ = along(make(Ekf), samples)
    mu, status = along(make(Ekf), faulty(samples, slice(AT, None), psi=lambda psi: psi + jump))

    assert all(Status.IMPLAUSIBLE in each for each in status[AT : AT + REZERO])
    assert not any(status[AT + REZERO :])
    assert np.abs(mu - expected)[AT + REZERO :].max() < 0.01


@pytest.mark.parametrize(
    ("field", "value", "also"),
    [("F_N", 1e5, Status.HELD), ("M_z", -1e4, Status.MISSING), ("psi_dot", 8.0, Status.USED)],
)
def test_each_channel_has_a_limit(field: str, value: float, also: Status, samples: list[Sample]) -> None:
    observer = make(Ekf)
    state = observer.init(samples[0])
    for sample in samples[:5]:
        state = observer.step(state, sample)
    seen = {
        at: observer.estimate(observer.step(state, replace(samples[5], **{field: at}))).status
        for at in (value, value * (1 - 1e-9))
    }

    assert seen[value] == Status.IMPLAUSIBLE | also
    assert Status.IMPLAUSIBLE not in seen[value * (1 - 1e-9)]


def test_after_a_pause_the_wheel_may_stand_elsewhere(samples: list[Sample]) -> None:
    silent = faulty(samples, slice(AT, AT + 5), psi=lambda _: nan)
    turned = faulty(silent, slice(AT + 5, None), psi=lambda psi: psi + 0.4)
    _, status = along(make(Ekf), turned)

    assert not any(Status.IMPLAUSIBLE in each for each in status)


def test_a_whole_recording_is_screened_as_its_samples_are(recording: RigRecording) -> None:
    columns = columns_of(recording, slice(900))
    columns["psi"] = columns["psi"].copy()
    columns["psi"][[0, 300, AT]] += [40.0, 0.4, -0.3]
    columns["psi"][800:] += 3.0
    observer = make(Ekf)
    whole, single = run(observer, **columns), run(observer, **columns, one_by_one=True)
    mu, status = along(observer, samples_of(columns))

    np.testing.assert_allclose(whole.mu, single.mu, rtol=1e-14)
    np.testing.assert_allclose(whole.mu, mu, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(whole.status, status)
    assert np.flatnonzero(whole.status & Status.IMPLAUSIBLE).tolist() == [0, 300, AT, *range(800, 810)]
    assert np.abs(smooth(observer, **columns).mu[-1] - whole.mu[-1]) < 1e-12


@pytest.mark.measured
@pytest.mark.parametrize("name", ["fem1", "fem3", "fem4_ident", "fem5", "piros1", "piros4", "piros7"])
def test_no_measured_recording_is_implausible(name: str, measured_dir: Path) -> None:
    made = read_recording(measured_dir / f"{name}.mat")
    rig, observer = made.rig, make(Ekf)
    assert rig is not None
    estimates = run(observer, made.t, made.psi, made.F_N, made.M_z)

    assert not (estimates.status & Status.IMPLAUSIBLE).any()


def test_a_torque_near_the_declared_range_is_left_out(samples: list[Sample]) -> None:
    observer, other = (make(Ekf, rig=replace(EXACT_RIG, range=most)) for most in (10.0, 20.0))
    start = observer.init(samples[0])
    tested = [replace(samples[1], M_z=M_z) for M_z in (9.4, -9.4, 9.6, -9.6)]
    seen = [observer.estimate(observer.step(start, sample)).status for sample in tested]

    assert [Status.IMPLAUSIBLE in status for status in seen] == [False, False, True, True]
    assert observer.screened_step is other.screened_step
    assert make(Ekf, rig=EXACT_RIG).sample_limits == Tuning().sensor_limits
    lower = make(Ekf, rig=replace(EXACT_RIG, range=10.0), torque_limit=3.0)
    assert lower.sample_limits[3] == 3.0


def test_a_sensor_that_ends_is_never_taken_for_full_slide() -> None:
    made = make_recording(590_003, mu=0.8, duration=8.0, bristles=500)
    columns, most = columns_of(made, slice(None)), 0.7 * float(np.abs(made.M_z).max())
    noise = 0.03 * np.random.default_rng(1).standard_normal(made.t.size)
    columns["M_z"] = np.clip(made.M_z, -most, most) + noise
    silent, declared, ample = (
        run(replace(acquiring_ekf(), rig=replace(RIG, range=end)), **columns)
        for end in (None, most, 1.2 * most)
    )

    # Without the range, friction is that at which the sensor ends, and usable.
    assert wrong_and_usable(silent, 0.8).mean() > 0.02
    assert not wrong_and_usable(declared, 0.8).any()
    assert declared.usable.any()
    np.testing.assert_array_equal(silent.mu, ample.mu)
