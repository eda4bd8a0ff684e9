"""Recordings made for observers, and where in them friction shows."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from observers import Observer, Sample, causal_rate, run
from tests.observers.conftest import K
from tests.rig.patch import RigTyre, simulate
from tests.rig.path import hand_path
from tests.rig.record import RigRecording

Array = NDArray[np.float64]


def first_full_slide(made: RigRecording) -> int:
    """First sample after the torque has been at 90 % of its full-slide level, never quite reached."""
    x = np.linspace(-made.tyre.a, made.tyre.a, 4001)
    share = np.mean((1 - (x / made.tyre.a) ** 2) * np.abs(x - made.tyre.e)) * 1.5
    level = made.tyre.mu * made.F_N_true * share
    return int(np.flatnonzero(np.abs(made.M_z_true) > 0.9 * level)[0]) + 1


def change_of_ground() -> tuple[Array, Array, Array, Array]:
    """t, psi, F_N and M_z while mu is 1.5 for 7 s and then 1.1, as if the wheel were lifted over."""
    path = hand_path(31, 14.0, load=400.0, rate=100.0)
    mu = np.where(path.t < 7, 1.5, 1.1)
    M_z = simulate(replace(path, F_N=path.F_N * mu), RigTyre(k=K, mu=1.0), bristles=1000).M_z
    M_z = M_z + 0.004 * np.ptp(M_z) * np.random.default_rng(31).standard_normal(M_z.size)
    return path.t, path.psi, path.F_N, M_z


def assert_steps_are_the_run(observer: Observer, recording: RigRecording, count: int) -> None:
    """Sample by sample, an observer says what it says of the whole recording."""
    t, psi, F_N, M_z = (a[:count] for a in (recording.t, recording.psi, recording.F_N, recording.M_z))
    rate, dt = causal_rate(t, psi), np.diff(t, prepend=2 * t[0] - t[1])
    estimates = run(observer, t, psi, F_N, M_z)
    state = None
    for i in range(count):
        sample = Sample(psi=psi[i], psi_dot=rate[i], F_N=F_N[i], dt=dt[i], M_z=M_z[i])
        state = observer.step(observer.init(sample) if state is None else state, sample)
        now = observer.estimate(state)
        for name in ("mu", "mu_std", "M_z_predicted"):
            assert getattr(estimates, name)[i] == pytest.approx(getattr(now, name), abs=1e-12)
        assert bool(estimates.informed[i]) is now.informed
