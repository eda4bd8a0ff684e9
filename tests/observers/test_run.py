"""Whole recordings: sample by sample and at once, causal, with gaps, informed or not, right."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from observers import Ekf, Estimates, Tuning, run
from symbolic import InvalidInputError, Model, effects_named, simulate
from tests.observers.conftest import RIG, K
from tests.observers.made import assert_steps_are_the_run, change_of_ground, first_full_slide
from tests.rig.record import RigRecording, make_recording

Array = NDArray[np.float64]
Make = Callable[..., Ekf]
FIELDS = ("mu", "mu_std", "M_z_predicted", "informed")
RIG_NOISE = 0.01
"""Tuning for the rig: 0.4 % of range is about 1 % of the full-slide torque at mu = 1."""


def run_on(observer: Ekf, made: RigRecording, M_z: Array | None = None) -> Estimates:
    return run(observer, made.t, made.psi, made.F_N, made.M_z if M_z is None else M_z)


@pytest.mark.parametrize("discretised", [False, True], ids=["exact", "bristles"])
@pytest.mark.parametrize("count", [150, 300])
def test_sample_by_sample_is_the_same(recording: RigRecording, discretised: bool, count: int) -> None:
    observer = Ekf(model=Model(discretised=discretised), values={"k": K}, rig=RIG)
    assert_steps_are_the_run(observer, recording, count)


@pytest.mark.parametrize("count", [2, 199, 200, 777])
def test_no_row_depends_on_later_samples(recording: RigRecording, ekf: Make, count: int) -> None:
    whole = run_on(ekf(), recording)
    columns = (recording.t, recording.psi, recording.F_N, recording.M_z)
    part = run(ekf(), *(column[:count] for column in columns))

    np.testing.assert_array_equal(part.t, recording.t[:count])
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[:count])


@pytest.mark.parametrize("missing", ["none", "a fifth"])
@pytest.mark.parametrize(("seed", "mu"), [(21, 1.4), (22, 0.7), (23, 1.9), (24, 1.1)])
def test_converges_to_the_true_friction(ekf: Make, seed: int, mu: float, missing: str) -> None:
    made = make_recording(seed, mu=mu, k=K, bristles=1000)
    M_z = made.M_z.copy()
    if missing == "a fifth":
        M_z[np.random.default_rng(seed).random(M_z.size) < 0.2] = np.nan
    estimates = run_on(ekf(noise=RIG_NOISE), made, M_z)
    slid = first_full_slide(made)

    assert all(np.isfinite(getattr(estimates, name)).all() for name in FIELDS)
    assert estimates.informed[slid:].all()
    error = np.abs(estimates.mu - mu)[slid:]
    assert error.max() < 0.03
    assert error[-1] < 3 * estimates.mu_std[-1]
    assert np.mean(error < 3 * estimates.mu_std[slid:]) > 0.95


def test_a_gap_is_bridged_by_prediction(recording: RigRecording, ekf: Make) -> None:
    M_z = recording.M_z.copy()
    M_z[600:800] = np.nan
    estimates, whole = (run_on(ekf(noise=RIG_NOISE), recording, torque) for torque in (M_z, None))

    assert all(np.isfinite(getattr(estimates, name)).all() for name in FIELDS)
    assert (estimates.mu[600:800] == estimates.mu[599]).all()
    assert (np.diff(estimates.mu_std[599:800]) > 0).all()
    assert estimates.mu_std[800] < estimates.mu_std[799]
    in_gap = estimates.M_z_predicted[600:800] - recording.M_z_true[600:800]
    assert np.sqrt(np.mean(in_gap**2)) < 0.02 * np.ptp(recording.M_z)
    assert estimates.mu[-1] == pytest.approx(whole.mu[-1], abs=0.01)


def test_without_any_torque_the_spread_follows_the_clock_alone(
    recording: RigRecording, ekf: Make
) -> None:
    observer, rng = ekf(), np.random.default_rng(1)
    chosen = np.sort(rng.choice(recording.t.size, 300, replace=False))
    t, psi, F_N = recording.t[chosen], recording.psi[chosen], recording.F_N[chosen]
    estimates = run(observer, t, psi, F_N, np.full(300, np.nan))
    elapsed = t - t[0] + (t[1] - t[0])

    assert (estimates.mu == observer.tuning.mu).all()
    variance = observer.tuning.mu_std**2 + observer.tuning.mu_walk**2 * elapsed
    np.testing.assert_allclose(estimates.mu_std**2, variance, rtol=1e-12)
    assert not estimates.informed.any()


def test_irregular_sampling_changes_little(recording: RigRecording, ekf: Make) -> None:
    chosen = np.sort(np.random.default_rng(2).choice(recording.t.size, 700, replace=False))
    columns = (recording.t, recording.psi, recording.F_N, recording.M_z)
    estimates = run(ekf(noise=RIG_NOISE), *(column[chosen] for column in columns))

    assert estimates.mu[-1] == pytest.approx(1.4, abs=0.02)
    assert abs(estimates.mu[-1] - 1.4) < 3 * estimates.mu_std[-1]


@pytest.mark.parametrize("noise", [0.3, RIG_NOISE])
def test_a_wheel_never_turned_says_nothing(ekf: Make, noise: float) -> None:
    t = np.arange(1500) / 100
    M_z = 0.05 * np.random.default_rng(5).standard_normal(t.size)
    estimates = run(ekf(noise=noise), t, np.full(t.size, 0.2), np.full(t.size, 400.0), M_z)

    assert not estimates.informed.any()
    assert (estimates.mu == 1.0).all()
    assert (estimates.mu_std >= 0.5).all()


@pytest.mark.parametrize("noise", [0.3, RIG_NOISE])
def test_full_stick_says_nothing(ekf: Make, noise: float) -> None:
    t = np.arange(1500) / 100
    psi = 5e-4 * np.sin(2 * np.pi * 0.4 * t)
    F_N = np.full(t.size, 400.0)
    signals = np.vstack([psi, np.gradient(psi, t), F_N, np.full(t.size, 0.01)])
    M_z = simulate(Model(), signals, np.array([2.5, K]), np.array([RIG.a, RIG.e])).M_z
    M_z = M_z + 0.02 * np.random.default_rng(6).standard_normal(t.size)
    estimates = run(ekf(noise=noise), t, psi, F_N, M_z)

    assert not estimates.informed.any()
    assert np.abs(estimates.mu - 1).max() < 0.5


@pytest.mark.parametrize("noise", [0.3, RIG_NOISE])
def test_a_full_slide_informs(recording: RigRecording, ekf: Make, noise: float) -> None:
    estimates = run_on(ekf(noise=noise), recording)

    assert not estimates.informed[:40].any(), "the wheel has not been turned yet"
    assert estimates.informed[first_full_slide(recording) :].all()


def test_a_torque_zero_does_not_pass_for_friction(recording: RigRecording, ekf: Make) -> None:
    shifted = run_on(ekf(noise=RIG_NOISE), recording, recording.M_z + 0.3)

    assert shifted.mu[-1] == pytest.approx(1.4, abs=0.03)


def test_follows_a_change_of_ground(ekf: Make) -> None:
    estimates = run(ekf(noise=0.05, mu_walk=0.1), *change_of_ground())

    assert estimates.mu[690] == pytest.approx(1.5, abs=0.05)
    assert estimates.mu[-1] == pytest.approx(1.1, abs=0.05)


def test_effects_of_a_found_model_are_used() -> None:
    planted = {"carcass_torsion": {"k_t": 400.0}, "rate_friction": {"c": 0.04}}
    made = make_recording(32, planted, mu=1.3, k=K, bristles=1000)
    tuning = Tuning(noise=0.02)
    effects = Model(effects=effects_named(planted))
    values = {"k": K, "carcass_torsion.k_t": 400.0, "rate_friction.c": 0.04}
    with_effects = run_on(Ekf(model=effects, values=values, rig=RIG, tuning=tuning), made)
    without = run_on(Ekf(model=Model(), values={"k": K}, rig=RIG, tuning=tuning), made)

    late = slice(400, None)
    assert np.abs(with_effects.mu[late] - 1.3).max() < 0.08
    assert with_effects.mu[-1] == pytest.approx(1.3, abs=0.03)
    errors = [
        np.sqrt(np.mean((e.M_z_predicted - made.M_z_true)[late] ** 2)) for e in (with_effects, without)
    ]
    assert errors[0] < 0.5 * errors[1]


def test_faults_of_a_recording(recording: RigRecording, ekf: Make) -> None:
    columns = {"t": recording.t, "psi": recording.psi, "F_N": recording.F_N, "M_z": recording.M_z}
    nan_at_3 = np.where(np.arange(recording.t.size) == 3, np.nan, 1.0)
    faults = [
        ({"M_z": recording.M_z[1:]}, "M_z must have the shape of t"),
        ({name: column[:1] for name, column in columns.items()}, "n >= 2"),
        ({"t": recording.t[::-1]}, "t must increase"),
        ({"t": recording.t * nan_at_3}, "t must increase"),
        ({"psi": recording.psi * nan_at_3}, "psi must be finite"),
        ({"F_N": recording.F_N * nan_at_3}, "F_N finite and greater than 0"),
        ({"F_N": -recording.F_N}, "F_N finite and greater than 0"),
    ]
    for change, word in faults:
        with pytest.raises(InvalidInputError, match=word) as caught:
            run(ekf(), **{**columns, **change})
        assert "\n" not in str(caught.value)
