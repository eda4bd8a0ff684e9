"""filterpy's filter with our model, against a filter of one number written out here."""

import math

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter

from observers import Sample, Tuning
from observers.interfaces.filterpy_filter import FilterpyEkf
from symbolic import InvalidInputError, Model, Rig, effects_named, simulate

RIG, K, MU = Rig(a=0.045, e=0.009), 2.4e6, 0.8
TUNING = Tuning(mu_walk=0.005, noise=0.02)


@pytest.fixture(scope="module")
def signals() -> np.ndarray:
    t = np.arange(120) * 0.02
    load, step = np.full(t.size, 400.0), np.full(t.size, 0.02)
    return np.vstack([0.3 * np.sin(2 * t), 0.6 * np.cos(2 * t), load, step])


def torque(signals: np.ndarray, mu: float) -> np.ndarray:
    return np.asarray(simulate(Model(), signals, np.array([mu, K]), np.array([RIG.a, RIG.e])).M_z)


def test_it_is_the_filter_of_the_textbook(signals: np.ndarray) -> None:
    measured = torque(signals, MU)
    ours = FilterpyEkf(model=Model(), values={"k": K}, rig=RIG, tuning=TUNING)
    x, P, R = 0.0, TUNING.prior_log_mu_std**2, (TUNING.noise * 3 / 8 * 400 * RIG.a) ** 2
    h = 1e-6
    for i, (column, M_z) in enumerate(zip(signals.T, measured, strict=True)):
        psi, psi_dot, F_N, dt = column
        M_z = math.nan if i == 50 else float(M_z)
        ours.step(Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, M_z=M_z))
        P += TUNING.mu_walk**2 * dt
        if i % 10 == 0:  # The whole history by central differences, and not at every sample.
            low, mid, high = (torque(signals[:, : i + 1], math.exp(x + d))[-1] for d in (-h, 0, h))
            H = (high - low) / (2 * h)
            gain = P * H / (H * P * H + R)
            expected = x + gain * (M_z - mid), (1 - gain * H) * P
            if i != 50:
                assert ours.x[0, 0] == pytest.approx(expected[0], abs=1e-6)
                assert ours.P[0, 0] == pytest.approx(expected[1], rel=1e-4, abs=1e-12)
        x, P = ours.x[0, 0], ours.P[0, 0]

    assert isinstance(ours, ExtendedKalmanFilter)
    assert ours.mu == pytest.approx(MU, rel=1e-3)
    assert 0 < ours.mu_std < 0.05


def test_what_it_cannot_follow_or_is_missing_is_refused() -> None:
    named = effects_named(["viscoelastic_relaxation"])
    model = Model(effects=named)
    values = {"k": K} | {f"{e.name}.{p.name}": p.start for e in named for p in e.parameters}
    with pytest.raises(InvalidInputError, match=r"take observers\.Ekf"):
        FilterpyEkf(model=model, values=values, rig=RIG)
    ours = FilterpyEkf(model=Model(), values={"k": K}, rig=RIG)
    with pytest.raises(InvalidInputError, match="hold what is missing"):
        ours.step(Sample(psi=math.nan, psi_dot=0.0, F_N=400.0, dt=0.01, M_z=0.0))
