"""The estimator against a Kalman filter, IPOPT and dense equations, on the rig, and at its limits."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from observers import Ekf, Estimates, Mhe, MheState, Sample, Tuning, causal_rate, run
from symbolic import InvalidInputError, Model, effects_named, simulate
from tests.observers.conftest import RIG, K
from tests.observers.made import assert_steps_are_the_run, change_of_ground, first_full_slide
from tests.observers.oracles import WindowOracle
from tests.rig.record import RigRecording, make_recording

Array = NDArray[np.float64]
Make = Callable[..., Mhe]
FIELDS = ("mu", "mu_std", "M_z_predicted", "informed")
GEOMETRY = np.array([RIG.a, RIG.e])
RIG_NOISE = 0.01
"""Tuning for the rig: 0.4 % of range is about 1 % of the full-slide torque at mu = 1."""


def run_on(observer: Mhe | Ekf, made: RigRecording, M_z: Array | None = None) -> Estimates:
    return run(observer, made.t, made.psi, made.F_N, made.M_z if M_z is None else M_z)


def samples_of(made: RigRecording, start: int, stop: int, every: int = 1) -> list[Sample]:
    """Samples of a recording, each sixth without its torque."""
    part = slice(start, stop, every)
    t, psi, F_N, M_z = (a[part].copy() for a in (made.t, made.psi, made.F_N, made.M_z))
    M_z[::6] = np.nan
    rows = zip(psi, causal_rate(t, psi), F_N, np.diff(t, prepend=2 * t[0] - t[1]), M_z, strict=True)
    return [Sample(psi=p, psi_dot=v, F_N=F, dt=dt, M_z=M) for p, v, F, dt, M in rows]


def last_state(observer: Mhe, samples: list[Sample]) -> MheState:
    state = observer.init(samples[0])
    for sample in samples:
        state = observer.step(state, sample)
    return state


@pytest.mark.parametrize(("window", "iterations"), [(1, 1), (2, 1), (50, 1), (200, 1), (17, 3)])
def test_wheel_at_rest_leaves_the_kalman_filter(
    ekf: Callable[..., Ekf], mhe: Make, window: int, iterations: int
) -> None:
    # Nothing but the torque zero is seen: a linear problem, in which every window is the filter.
    t, rng = np.arange(150) / 100, np.random.default_rng(3)
    M_z = 0.3 + 0.1 * rng.standard_normal(t.size)
    M_z[rng.random(t.size) < 0.2] = np.nan
    columns = (t, np.zeros(t.size), np.full(t.size, 400.0), M_z)
    believed = {"noise": 0.02, "zero_walk": 0.05}
    filtered = run(ekf(**believed), *columns)
    estimated = run(mhe(window=window, iterations=iterations, **believed), *columns)

    for name in FIELDS:
        np.testing.assert_allclose(getattr(estimated, name), getattr(filtered, name), rtol=0, atol=1e-9)
    assert filtered.M_z_predicted[-1] == pytest.approx(0.3, abs=0.1)


def test_converged_window_is_the_optimum_that_ipopt_finds(recording: RigRecording) -> None:
    model, tuning = Model(corners=16), Tuning(noise=RIG_NOISE)
    samples = samples_of(recording, 20, 220, every=5)
    mhe = Mhe(model=model, values={"k": K}, rig=RIG, tuning=tuning, window=40, iterations=10)
    state = last_state(mhe, samples)

    np.testing.assert_allclose(state.x, optimum(model, tuning, samples), rtol=0, atol=1e-8)
    assert np.abs(np.diff(state.x[0])).max() > 1e-3, "nothing walked"


def optimum(model: Model, tuning: Tuning, samples: list[Sample]) -> Array:
    """The cost as a nonlinear programme in all x at once; shape (2, n)."""
    theta = np.array([1.0, K])
    signals = [np.array([s.psi, s.psi_dot, s.F_N, s.dt]) for s in samples]
    memory = model.start(signals[0], theta, GEOMETRY)
    x, cost = ca.MX.sym("x", 2, len(samples)), 0
    for i, (sample, row) in enumerate(zip(samples, signals, strict=True)):
        slide = 0.375 * sample.F_N * RIG.a
        walk = sample.dt * np.array([tuning.mu_walk, tuning.zero_walk * slide]) ** 2
        prior = np.array([tuning.mu_std, tuning.zero_std * slide]) ** 2
        before = x[:, i - 1] if i else np.array([tuning.mu, 0.0])
        cost += ca.sum1((x[:, i] - before) ** 2 / (walk if i else walk + prior))
        if np.isfinite(sample.M_z):
            M_z = model.step(memory, row, ca.vertcat(x[0, i], K), GEOMETRY)[1] + x[1, i]
            cost += sample.dt / 0.01 * ((sample.M_z - M_z) / (tuning.noise * slide)) ** 2
        memory = model.step(memory, row, theta, GEOMETRY)[0]
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-11}
    solver = ca.nlpsol("optimum", "ipopt", {"x": ca.vec(x), "f": cost}, quiet)
    n = len(samples)
    lower, upper = np.tile([tuning.least, -np.inf], n), np.tile([tuning.greatest, np.inf], n)
    found = solver(x0=np.tile([1.0, 0.0], n), lbx=lower, ubx=upper)
    assert solver.stats()["success"]
    return np.asarray(found["x"]).reshape(n, 2).T


@pytest.mark.parametrize(("window", "iterations"), [(7, 1), (20, 2)])
def test_moving_window_equals_dense_equations_by_the_book(
    recording: RigRecording, mhe: Make, window: int, iterations: int
) -> None:
    observer = mhe(noise=RIG_NOISE, window=window, iterations=iterations)
    samples = samples_of(recording, 40, 340, every=5)
    state = observer.init(samples[0])
    oracle = WindowOracle(observer, samples)
    for sample, (x, P) in zip(samples, oracle.run(), strict=True):
        state = observer.step(state, sample)
        np.testing.assert_allclose(state.x[:, -x.shape[1] :], x, rtol=0, atol=1e-9)
        np.testing.assert_allclose(state.P_newest, P, rtol=1e-8, atol=1e-12)
    assert abs(state.x[0, -1] - 1) > 0.1, "the comparison saw no correction"


@pytest.mark.parametrize("discretised", [False, True], ids=["exact", "bristles"])
@pytest.mark.parametrize("count", [40, 250])
def test_sample_by_sample_is_the_same(recording: RigRecording, discretised: bool, count: int) -> None:
    observer = Mhe(model=Model(discretised=discretised), values={"k": K}, rig=RIG)
    assert_steps_are_the_run(observer, recording, count)


@pytest.mark.parametrize("count", [2, 49, 50, 51, 777])
def test_no_row_depends_on_later_samples(recording: RigRecording, mhe: Make, count: int) -> None:
    whole = run_on(mhe(), recording)
    columns = (recording.t, recording.psi, recording.F_N, recording.M_z)
    part = run(mhe(), *(column[:count] for column in columns))

    for name in FIELDS:
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[:count])


def test_prediction_is_the_whole_history_at_the_present_mu(recording: RigRecording, mhe: Make) -> None:
    observer, samples = mhe(noise=RIG_NOISE), samples_of(recording, 0, 500)
    signals = np.array([[s.psi, s.psi_dot, s.F_N, s.dt] for s in samples]).T
    state = observer.init(samples[0])
    for number, sample in enumerate(samples, start=1):
        x = state.x[:, -1]
        state = observer.step(state, sample)
        if number % 100 == 0:
            again = simulate(observer.model, signals[:, :number], np.array([x[0], K]), GEOMETRY)
            assert state.M_z_predicted == pytest.approx(again.M_z[-1] + x[1], abs=1e-9)


def test_bristles_forget_the_first_guess_of_mu(recording: RigRecording) -> None:
    # Their memory depends on mu: without its derivative the first guess would stay in it.
    model = Model(discretised=True)
    observer = Mhe(model=model, values={"k": K}, rig=RIG, tuning=Tuning(noise=RIG_NOISE))
    samples = samples_of(recording, 0, 600)
    before = last_state(observer, samples[:-1])
    signals = np.array([[s.psi, s.psi_dot, s.F_N, s.dt] for s in samples]).T
    again = simulate(model, signals, np.array([before.x[0, -1], K]), GEOMETRY).M_z[-1]
    last = observer.step(before, samples[-1])

    expected = again + before.x[1, -1]
    assert last.M_z_predicted == pytest.approx(expected, abs=5e-3 * np.ptp(recording.M_z))


@pytest.mark.parametrize("missing", ["none", "a fifth"])
@pytest.mark.parametrize(("seed", "mu"), [(21, 1.4), (22, 0.7), (23, 1.9), (24, 1.1)])
def test_converges_to_the_true_friction(mhe: Make, seed: int, mu: float, missing: str) -> None:
    made = make_recording(seed, mu=mu, k=K, bristles=1000)
    M_z = made.M_z.copy()
    if missing == "a fifth":
        M_z[np.random.default_rng(seed).random(M_z.size) < 0.2] = np.nan
    estimates = run_on(mhe(noise=RIG_NOISE), made, M_z)
    slid = first_full_slide(made)

    assert all(np.isfinite(getattr(estimates, name)).all() for name in FIELDS)
    assert estimates.informed[slid:].all()
    error = np.abs(estimates.mu - mu)[slid:]
    assert error.max() < 0.03
    assert np.mean(error < 3 * estimates.mu_std[slid:]) > 0.95


@pytest.mark.parametrize("noise", [0.3, RIG_NOISE])
def test_full_stick_says_nothing(mhe: Make, noise: float) -> None:
    t = np.arange(800) / 100
    psi = 5e-4 * np.sin(2 * np.pi * 0.4 * t)
    F_N = np.full(t.size, 400.0)
    signals = np.vstack([psi, np.gradient(psi, t), F_N, np.full(t.size, 0.01)])
    M_z = simulate(Model(), signals, np.array([2.5, K]), GEOMETRY).M_z
    M_z = M_z + 0.02 * np.random.default_rng(6).standard_normal(t.size)
    estimates = run(mhe(noise=noise), t, psi, F_N, M_z)

    assert not estimates.informed.any()
    assert np.abs(estimates.mu - 1).max() < 0.5


@pytest.mark.parametrize(("noise", "mu_walk"), [(0.05, 0.1), (RIG_NOISE, 0.02), (0.3, 0.02)])
def test_follows_a_change_of_ground_no_slower_than_the_filter(
    ekf: Callable[..., Ekf], mhe: Make, noise: float, mu_walk: float
) -> None:
    columns, believed = change_of_ground(), {"noise": noise, "mu_walk": mu_walk}
    settled = []
    for observer in (mhe(**believed), ekf(**believed)):
        estimates = run(observer, *columns)
        assert estimates.mu[690] == pytest.approx(1.5, abs=0.05)
        settled.append(np.flatnonzero(np.abs(estimates.mu - 1.1) > 0.05)[-1])

    assert settled[0] <= settled[1] < len(estimates.mu) - 1


def test_huber_bears_outliers(recording: RigRecording, mhe: Make) -> None:
    rng = np.random.default_rng(8)
    M_z = recording.M_z + 5.0 * (rng.random(recording.t.size) < 0.05)
    late = slice(first_full_slide(recording), None)
    plain, robust, untouched = (
        np.abs(run_on(mhe(noise=RIG_NOISE, huber=huber), recording, torque).mu[late] - 1.4).max()
        for huber, torque in ((None, M_z), (2.0, M_z), (1e6, recording.M_z))
    )

    assert robust < 0.5 * plain
    assert untouched < 0.03


@pytest.mark.parametrize(("factor", "bound"), [(30.0, 4.0), (-5.0, 0.02)])
def test_mu_is_held_between_its_bounds(
    recording: RigRecording, mhe: Make, factor: float, bound: float
) -> None:
    estimates = run_on(mhe(noise=0.01, zero_std=1e-3), recording, factor * recording.M_z)

    assert 0.02 <= estimates.mu.min() <= estimates.mu.max() <= 4.0
    assert bound in estimates.mu


def test_effects_of_a_found_model_are_used() -> None:
    planted = {"carcass_torsion": {"k_t": 400.0}, "rate_friction": {"c": 0.04}}
    made = make_recording(32, planted, mu=1.3, k=K, bristles=1000)
    values = {"k": K, "carcass_torsion.k_t": 400.0, "rate_friction.c": 0.04}
    model = Model(effects=effects_named(planted))
    observer = Mhe(model=model, values=values, rig=RIG, tuning=Tuning(noise=0.02), window=20)
    estimates = run_on(observer, made)

    assert np.abs(estimates.mu[400:] - 1.3).max() < 0.08
    assert estimates.mu[-1] == pytest.approx(1.3, abs=0.03)


def test_step_leaves_the_state_that_it_was_given(recording: RigRecording, mhe: Make) -> None:
    samples = samples_of(recording, 200, 270)
    observer = mhe()
    state = last_state(observer, samples[:-1])
    arrays = [field.name for field in fields(MheState) if field.name != "M_z_predicted"]
    kept = {name: np.array(getattr(state, name)) for name in arrays}
    once, twice = observer.step(state, samples[-1]), observer.step(state, samples[-1])

    np.testing.assert_array_equal(once.x, twice.x)
    for name, copy in kept.items():
        np.testing.assert_array_equal(getattr(state, name), copy)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"window": 0}, "window"),
        ({"window": 2.5}, "window"),
        ({"iterations": 0}, "iterations"),
        ({"huber": 0.0}, "huber"),
        ({"huber": float("nan")}, "huber"),
    ],
    ids=str,
)
def test_settings_are_checked(mhe: Make, change: dict[str, Any], word: str) -> None:
    with pytest.raises(InvalidInputError, match=f"{word} must be "):
        replace(mhe(), **change)
