"""Friction from the aligning torque on the rig: found, not made up, not mistaken for something else."""

from math import inf
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Mhe, run
from reference_rig import RigRecording, make_recording
from symbolic import InvalidInputError, Model, effects_named, simulate
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import CLEAN_RIG, columns_of, first_full_slide, found_model

pytestmark = pytest.mark.usefixtures("interpreted")
KINDS = [pytest.param(Ekf, {}, id="ekf"), pytest.param(Mhe, {}, id="mhe")]
NOISES = [pytest.param({}, id="as it stands"), pytest.param(CLEAN_RIG, id="clean rig")]


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("tuning", NOISES)
@pytest.mark.parametrize("turn", [0.0, 5e-4], ids=["at rest", "full stick"])
def test_a_wheel_hardly_turned_says_nothing(kind: Any, settings: Any, tuning: Any, turn: float) -> None:
    t = np.arange(800) / 100
    psi, F_N = 0.2 + turn * np.sin(2 * np.pi * 0.4 * t), np.full(t.size, 400.0)
    signals = np.vstack([psi, np.gradient(psi, t), F_N, np.full(t.size, 0.01)])
    M_z = simulate(Model(), signals, np.array([2.5, K]), np.array([RIG.a, RIG.e])).M_z
    M_z = M_z + 0.02 * np.random.default_rng(6).standard_normal(t.size)
    estimates = run(make(kind, **tuning, **settings), t, psi, F_N, M_z)

    assert not estimates.informed.any()
    assert np.abs(estimates.mu - 1).max() < (0.5 if turn else 1e-12)
    assert turn or (estimates.mu_std >= 0.5 - 1e-12).all()


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("tuning", NOISES)
def test_a_full_slide_informs(recording: RigRecording, kind: Any, settings: Any, tuning: Any) -> None:
    estimates = run(make(kind, **tuning, **settings), **columns_of(recording))

    assert not estimates.informed[:40].any(), "the wheel has not been turned yet"
    # Default noise takes a second of sliding, clean noise a sample.
    wait = 0 if tuning else 100
    assert estimates.informed[first_full_slide(recording) + wait :].all()


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_a_torque_zero_does_not_pass_for_friction(
    recording: RigRecording, kind: Any, settings: Any
) -> None:
    columns = columns_of(recording)
    estimates = run(make(kind, **CLEAN_RIG, **settings), **{**columns, "M_z": columns["M_z"] + 0.3})

    assert estimates.mu[-1] == pytest.approx(1.4, abs=0.03)


def test_a_drift_of_the_zero_is_the_observers_own() -> None:
    model = Model(effects=effects_named(["zero_drift"]))
    make(Ekf, model=model, values={"k": K, "zero_drift.rate": 0.0})

    with pytest.raises(InvalidInputError, match=r"zero_drift\.rate must be 0, .* leave zero_drift out"):
        make(Ekf, model=model, values={"k": K, "zero_drift.rate": 0.1})


@pytest.mark.parametrize(("kind", "settings"), [(Ekf, {}), (Mhe, {"window": 20})])
def test_effects_of_a_found_model_are_used(kind: Any, settings: Any) -> None:
    planted = {"carcass_torsion": {"k_t": 400.0}, "rate_friction": {"c": 0.04}}
    made = make_recording(32, planted, mu=1.3, k=K, bristles=1000, duration=8.0)
    tuning = {"noise": 0.02, "error": inf, "gate": inf, **settings}
    found = found_model({"carcass_torsion.k_t": 400.0, "rate_friction.c": 0.04})
    with_effects, without = (run(make(kind, **tuning, **own), **columns_of(made)) for own in (found, {}))

    late = slice(400, None)
    assert np.abs(with_effects.mu[late] - 1.3).max() < 0.08
    assert with_effects.mu[-1] == pytest.approx(1.3, abs=0.03)
    off = [(e.M_z_predicted - made.M_z_true)[late] for e in (with_effects, without)]
    errors = [np.sqrt(np.mean(each**2)) for each in off]
    assert errors[0] < 0.5 * errors[1]
