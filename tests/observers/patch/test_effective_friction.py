"""Effective friction in the output of every observer: its value, its deviation, and what compares."""

from math import isnan, nan
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Loop, Mhe, RootObserver, Sample, SteeringTorque, run
from reference_rig import RigRecording, make_recording
from symbolic import Rig
from tests.observers.conftest import RIG, K
from tests.observers.factories import DECLARED, columns_of, found_model, samples_of, states_of

pytestmark = pytest.mark.usefixtures("interpreted")

X = np.linspace(-RIG.a, RIG.a, 100001)
ARM = 0.75 / RIG.a**3 * np.trapezoid((RIG.a**2 - X**2) * np.abs(X - RIG.e), X)
"""Torque of the declared patch in full slide over load, mu = 1 [m]."""
EFFECTS = found_model(
    {
        "rate_friction.c": 0.05, "friction_drift.gain": 0.3, "friction_drift.scale": 0.6,
        "asymmetric_friction.ratio": 1.2, "contact_damping.c": 2.0,
    }, bristles=8,
)  # fmt: skip
FEW, VALUES = EFFECTS.values()
KINDS = [
    pytest.param(Ekf, {}, id="ekf"),
    pytest.param(Mhe, {"window": 5}, id="mhe"),
    pytest.param(Ekf, {"measurement_model": SteeringTorque()}, id="ekf, M"),
    pytest.param(Mhe, {"window": 5, "measurement_model": SteeringTorque()}, id="mhe, M"),
]


@pytest.fixture(scope="module")
def samples() -> list[Sample]:
    columns = columns_of(make_recording(5, mu=1.4, k=K, duration=4.0, bristles=400), slice(40, 240))
    return samples_of(columns | {"M": -columns["M_z"]})


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_on_the_declared_model_it_is_mu(kind: Any, settings: Any, samples: list[Sample]) -> None:
    observer = kind(**DECLARED, rig=RIG, acquire=False, **settings)
    for state, sample in zip(states_of(observer, samples), samples, strict=True):
        now = observer.estimate(state)
        assert (now.mu_eff, now.mu_eff_std) == pytest.approx((now.mu, now.mu_std), rel=1e-14)
        assert now.M_slide == pytest.approx(now.mu * sample.F_N * ARM, rel=1e-6)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("rate", [0.1, 0.4])
def test_with_effects_it_is_the_full_slide_at_mu(
    kind: Any, settings: Any, rate: float, samples: list[Sample]
) -> None:
    rig = Rig(a=RIG.a, e=RIG.e, J_A=RIG.J_A, b_t=RIG.b_t, slide_rate=rate)
    observer = kind(**EFFECTS, rig=rig, acquire=False, **settings)
    *_, state = states_of(observer, samples)
    now = observer.estimate(state)
    turned = float(np.abs(np.diff([sample.psi for sample in samples])).sum())

    def M_slide(mu: float) -> float:
        theta = FEW.theta({**VALUES, "mu": mu})
        memory = np.zeros(FEW.memory_size)
        memory[-1] = travel
        return float(FEW.full_slide(memory, samples[-1].F_N, theta, [rig.a, rig.e], rate)[1])

    # The wheel's estimated angle jitters where the angle is a state, so that it travels further.
    travel = turned if "psi" not in observer.states else float(state["memory"].ravel(order="F")[-1])
    declared = samples[-1].F_N * ARM
    slope = (M_slide(1.01 * now.mu) - M_slide(0.99 * now.mu)) / (0.02 * now.mu) / declared
    assert now.M_slide == pytest.approx(M_slide(now.mu), rel=1e-9)
    assert now.mu_eff == pytest.approx(now.M_slide / declared, rel=1e-6)
    assert now.mu_eff_std == pytest.approx(slope * now.mu_std, rel=1e-6)
    assert abs(now.mu_eff / now.mu - 1) > 0.1


def test_models_whose_mu_differ_by_two_fifths_come_close_in_it() -> None:
    planted = {"patch_width": {"half_width": 0.03}, "contact_damping": {"c": 1.5}}
    made = make_recording(9, planted, mu=1.1, k=K, noise=0.002)
    found = found_model({"patch_width.half_width": 0.03, "contact_damping.c": 1.5})
    right, declared = (
        run(Ekf(**model, rig=RIG, acquire=False), **columns_of(made)) for model in (found, DECLARED)
    )
    mu, mu_eff = (abs(getattr(right, n)[-1] / getattr(declared, n)[-1] - 1) for n in ("mu", "mu_eff"))

    assert mu > 0.35
    assert mu_eff < 0.2


def test_nothing_is_stated_before_the_first_sample(recording: RigRecording) -> None:
    observer = Ekf(**DECLARED, rig=RIG)
    waiting = Loop(observer)(Sample(psi=nan, psi_dot=nan, F_N=nan, dt=0.01))
    columns = columns_of(recording, slice(0, 30))
    columns["psi"] = np.where(np.arange(30) < 4, nan, columns["psi"])
    estimates = run(observer, **columns)

    for name in ("mu_eff", "mu_eff_std", "M_slide", "nis"):
        assert isnan(getattr(waiting, name))
        assert np.isnan(getattr(estimates, name)[:4]).all()
        assert np.isfinite(getattr(estimates, name)[4:]).all()


def test_the_method_of_the_thesis_states_it_too(recording: RigRecording) -> None:
    estimates = run(RootObserver(rig=RIG, k=K), **columns_of(recording))

    np.testing.assert_array_equal(estimates.mu_eff, estimates.mu)
    np.testing.assert_allclose(estimates.M_slide, estimates.mu * recording.F_N * ARM, rtol=1e-6)
    assert np.isnan([estimates.mu_eff_std, estimates.nis]).all()
