"""Acquisition of friction, against least squares, fine bristles and integrals by hand."""

import re
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks import ice
from benchmarks.faulty_inputs import relaxed
from observers import Ekf, Loop, Mhe, Sample, Status, SteeringTorque, covariance_of, run
from observers.quality.acquisition import build_hypothesis_search_step
from observers.quality.hysteresis_branches import (
    PATHS,
    POINTS,
    TRACK,
    build_all_branches_update,
    build_branch_torque,
)
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.quality.mu_over_k_hypotheses import (
    SETTINGS,
    build_hypothesis_search_start,
    build_one_hypothesis_update,
    hypothesis_fields,
    hypothesis_states,
    hypothesis_variance,
    udu_entry_name,
)
from observers.tuning import Tuning, tuning_with_tolerances
from reference_rig import (
    RigTyre,
    constant_friction,
    free_path,
    friction_step,
    make_recording,
    make_steering_recording,
    plant_effect,
    simulate_ground,
)
from symbolic import Model, Rig, Tolerances, simulate
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.factories import LONG, acquiring_ekf, found_model, wrong_and_usable


def test_a_hypothesis_is_linear_least_squares() -> None:
    rng = np.random.default_rng(1)
    expected, variance = rng.normal(0, 3, 40), 0.02**2
    slid = expected + rng.normal(0, 2, 40)
    measured = 0.7 * expected + 0.4 * slid + 0.2 + 0.02 * rng.standard_normal(40)
    prior = {"log_likelihood": 0.0, "gain": 1.0, "zero": 0.0}
    prior |= {"D_gain": 100.0, "D_zero": 0.04, "D_twist": 0.25}
    part: Any = [prior.get(name, 0.0) for name in hypothesis_fields(gear=False)]
    for g, other, y in zip(expected, slid, measured, strict=True):
        part = build_one_hypothesis_update()(part, g, other, y, variance, 0.0)
    found = dict(zip(hypothesis_fields(gear=False), np.array(part).ravel(), strict=True))

    order = hypothesis_states(gear=False)
    H = np.column_stack([slid - expected, np.ones(40), expected])
    information = H.T @ H / variance + np.diag([1 / 0.25, 1 / 0.04, 1 / 100.0])
    covariance = np.linalg.inv(information)
    mean = covariance @ (H.T @ measured / variance + np.array([0.0, 0.0, 1 / 100.0]))
    factor = np.array([[found.get(udu_entry_name(one, other), 0.0) for other in order] for one in order])
    np.testing.assert_allclose([found[name] for name in order], mean, rtol=1e-9)
    np.testing.assert_allclose(covariance_of(factor), covariance, rtol=1e-9)
    variances = [hypothesis_variance(found, name) for name in order]
    np.testing.assert_allclose(variances, np.diag(covariance), rtol=1e-9)
    given_gain = np.linalg.inv(information[:2, :2])[1, 1]
    assert hypothesis_variance(found, "zero", given=("gain",)) == pytest.approx(given_gain, rel=1e-9)


def test_a_twist_that_moves_no_torque_any_more_leaves_the_zero_known() -> None:
    names = hypothesis_fields(gear=False)
    of = {"gain": 1.0, "D_gain": 0.01, "D_zero": 1.0, "D_twist": 0.25}
    part: Any = [of.get(name, 0.0) for name in names]
    for sign in (1, -1) * 500:
        part = build_one_hypothesis_update()(part, 5.0 * sign, 5.0 * sign + 2e-3, 5.0 * sign, 0.1, 1.0)
    found = dict(zip(names, np.array(part).ravel(), strict=True))

    assert hypothesis_variance(found, "zero") < 0.1
    assert found["left"] < 0.1


def path() -> Array:
    """Angles with reversals inside reversals, no more turning points than are remembered [rad]."""
    ends = [0.0, 0.3, -0.25, 0.1, 0.35, -0.1]
    legs = [np.linspace(a, b, 40)[1:] for a, b in pairwise(ends)]
    return np.concatenate([[0.0], *legs])


def bristle_torque(psi: Array, mu: float | Array, count: int = 400) -> Array:
    """Torque of 400 N along a path [N m], by the rig's bristles, free of torque at its first angle."""
    drive = free_path(0.01 * np.arange(psi.size), psi, rate=100.0)
    return simulate_ground(drive, np.broadcast_to(mu, psi.shape), RigTyre(k=K), bristles=count)


@pytest.mark.parametrize("before", [0.0, 1.0, -1.0])
def test_branches_add_up_to_fine_bristles(before: float) -> None:
    """On a path of a patch free of torque, and on one of a patch that slid to either side."""
    mu, load, psi = 0.7, 400.0, path()
    torques = bristle_torque(np.append(-before, psi), mu, count=8000)[1:]

    track: Any = np.zeros(len(TRACK))
    track[[TRACK.index("count"), TRACK.index("count_slid")]] = 1
    points: Any = np.zeros((POINTS, PATHS))
    order, found = np.arange(POINTS), []
    for angle, torque in zip(psi, torques, strict=True):
        track, points, turns, _ = build_all_branches_update()(track, points, angle, torque, 1.0, 1e-9, 1)
        tyres, turned = np.tile([[K], [0.045], [0.009]], POINTS), turns[:, int(before != 0)].T
        branches = build_branch_torque().map(POINTS)(turned, order[None], mu, load, tyres)
        found.append(float(np.sum(branches.full())))
    np.testing.assert_allclose(found, torques, atol=2e-3 * np.ptp(torques))


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=LONG)])
@pytest.mark.parametrize("mu", [0.03, 0.08, 0.3, 1.5])
@pytest.mark.parametrize("prior", [0.05, pytest.param(2.0, marks=LONG)])
def test_any_friction_is_found_from_any_prior(kind: Any, mu: float, prior: float) -> None:
    made = make_recording(31, mu=mu, k=K, bristles=500, duration=8.0)
    observer = kind(model=Model(), values={"k": K}, rig=RIG, tuning=Tuning(mu=prior, mu_std=prior / 2))
    estimates = run(observer, made.t, made.psi, made.F_N, made.M_z)

    normal = np.abs(estimates.mu - mu) / estimates.mu_std
    assert estimates.usable[-200:].all()
    assert normal[estimates.usable].max() < 3
    assert estimates.mu_std[-1] < 0.15 * mu
    assert not (estimates.usable & (estimates.status != 0)).any()


@pytest.mark.parametrize(
    ("factor", "said"), [(14.8, "1[45] times"), (1 / 9.81, r"0\.1 times"), (0.6, r"0\.6.? times")]
)
def test_a_torque_of_another_scale_is_never_usable(factor: float, said: str) -> None:
    made = make_recording(32, mu=0.7, k=K, bristles=500, duration=5.0)
    loop, usable = Loop(acquiring_ekf()), []
    for psi, F_N, M_z in zip(made.psi, made.F_N, factor * made.M_z, strict=True):
        usable.append(loop(Sample(psi=psi, psi_dot=np.nan, F_N=F_N, M_z=M_z, dt=0.01)).usable)

    (suspicion,) = loop.suspicions
    assert not any(usable)
    assert re.search(said, suspicion), suspicion


def test_a_tolerance_of_k_admits_another_scale() -> None:
    made = make_recording(33, mu=0.7, k=1.5 * K, bristles=500, duration=8.0)
    tolerant = replace(RIG, tolerances=Tolerances(k=0.6 * K))
    estimates = [
        run(Ekf(model=Model(), values={"k": K}, rig=rig), made.t, made.psi, made.F_N, made.M_z)
        for rig in (RIG, tolerant)
    ]
    assert not estimates[0].usable.any()
    assert estimates[1].usable[-1]
    assert abs(estimates[1].mu[-1] - 0.7) < 2 * estimates[1].mu_std[-1]


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=LONG)])
def test_friction_stays_usable_on_the_steering_torque(kind: Any) -> None:
    made = make_steering_recording(5, constant_friction(0.3), tyre=RigTyre(k=K, mu=0.3), rate=500.0)
    observer = kind(model=Model(), values={"k": K}, rig=RIG, measurement_model=SteeringTorque())
    estimates = run(observer, made.t, made.psi, made.F_N, M=made.M)

    at = int(np.argmax(estimates.usable))
    assert 0 < made.t[at] < 2.5
    assert np.mean(estimates.usable[at:]) > 0.95
    assert abs(estimates.mu[-1] - 0.3) < 2 * estimates.mu_std[-1]


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=LONG)])
def test_an_estimated_angle_that_is_lost_begins_anew(kind: Any) -> None:
    observer = kind(model=Model(), values={"k": K}, rig=RIG, measurement_model=SteeringTorque())
    sample = Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01, M=0.0)
    state = observer.step(observer.init(sample), sample)
    lost = state.values.copy()
    angle = observer.states.index("psi")
    at, (rows, _) = state.layout.places["x"]
    lost[at][angle::rows] = 1e6
    if kind is Mhe:
        lost[state.layout.places["mean"][0]][angle] = 1e6
    state = replace(state, values=lost)
    statuses = []
    for _ in range(2 * observer.tuning.reset_after):
        state = observer.step(state, sample)
        statuses.append(Status(observer.estimate(state).status))

    assert all(Status.ACQUIRING in status for status in statuses)
    assert Status.RESET in statuses[observer.tuning.reset_after - 1]
    assert state["x"].reshape(rows, -1, order="F")[angle, -1] == pytest.approx(0.0, abs=1e-3)


@LONG
@pytest.mark.parametrize("mu", [0.8, 0.3])
def test_turns_without_a_steering_torque_count(mu: float) -> None:
    """The wheel turns on and back where the torque is beyond its limit."""
    observer = Ekf(model=Model(), values={"k": ice.K}, rig=ice.RIG, measurement_model=SteeringTorque())
    usable = False
    for seed in range(580_000, 580_003):
        made = make_steering_recording(
            seed, constant_friction(mu), tyre=RigTyre(a=ice.RIG.a, e=ice.RIG.e, k=ice.K, mu=mu),
            load=400.0, duration=14.0, rate=ice.STEERING_RATE,
        )  # fmt: skip
        seen = np.where(np.abs(made.M) < 0.48 * np.abs(made.M).max(), made.M, np.nan)
        estimates = run(observer, made.t, made.psi, made.F_N, M=seen)
        off = np.abs(estimates.mu_eff - mu) > 3 * estimates.mu_eff_std

        assert np.mean(estimates.usable & off) <= 0.01
        usable |= bool(estimates.usable.any())
    assert usable


def test_declared_noise_keeps_ice_from_being_told() -> None:
    made = make_recording(34, mu=0.03, k=K, bristles=500, duration=6.0, noise=0.0)
    M_z = made.M_z + np.random.default_rng(1).normal(0, 1.0, made.M_z.size)
    ekf = Ekf(model=Model(), values={"k": K}, rig=replace(RIG, noise=1.0))
    assert not run(ekf, made.t, made.psi, made.F_N, M_z).usable.any()


def test_a_model_that_is_wrong_is_doubted_after_a_new_ground() -> None:
    """A wheel that rolls: its torque relaxes within 0.3 s, which no patch explains."""
    made = make_recording(9001, mu=0.8, k=K, bristles=500, duration=14.0)
    M_z = relaxed(made.M_z, 0.3)
    estimates = run(acquiring_ekf(), made.t, made.psi, made.F_N, M_z)

    assert np.mean(estimates.usable) < 0.02
    assert np.mean(estimates.status & Status.INCONSISTENT != 0) > 0.3


@pytest.mark.parametrize(
    ("mu", "seed", "time"),
    [
        (0.3, 540_000, 0.3),
        (1.5, 540_002, 0.3),
        (0.8, 540_000, 3.0),
        (0.3, 540_001, 1.0),
        (0.05, 540_007, 1.0),
    ],
)
def test_a_wheel_that_rolls_is_not_trusted_for_a_moment(mu: float, seed: int, time: float) -> None:
    """Before its torque has relaxed by more than the model's error, it bends like one that slides."""
    made = make_recording(seed, mu=mu, k=K, load=400.0, bristles=500, duration=5.0)
    M_z = relaxed(made.M_z, time)
    estimates = run(acquiring_ekf(), made.t, made.psi, made.F_N, M_z)

    assert np.mean(wrong_and_usable(estimates, mu)) < 0.01


@pytest.mark.parametrize(
    ("factor", "mu", "seed"), [(0.8, 0.8, 530_003), (0.8, 0.3, 530_003), (1.2, 0.3, 510_001)]
)
def test_a_torque_scale_that_passes_for_k_is_in_the_band(factor: float, mu: float, seed: int) -> None:
    made = make_recording(seed, mu=mu, k=K, load=400.0, bristles=500, duration=14.0)
    estimates = run(acquiring_ekf(), made.t, made.psi, made.F_N, factor * made.M_z)

    assert estimates.usable.any()
    assert np.mean(wrong_and_usable(estimates, mu)) < 0.01


@LONG
def test_a_torque_scale_beside_a_model_that_was_found_is_in_the_band() -> None:
    """The declared patch that stands for the model hides half of what the scale is off by."""
    tyre = RigTyre(a=RIG.a, e=RIG.e, k=K, mu=0.3)
    made = plant_effect("carcass_torsion", 591_004, tyre=tyre, duration=14.0, share=0.05)
    (k_t,) = made.effects["carcass_torsion"].values()
    observer = Ekf(**found_model({"carcass_torsion.k_t": k_t}), rig=RIG)
    estimates = run(observer, made.t, made.psi, made.F_N, 1.2 * made.M_z)

    assert estimates.usable.any()
    assert np.mean(wrong_and_usable(estimates, tyre.mu)) < 0.01


def slide(a: float, e: float) -> float:
    """Torque of full slide of a parabolic pressure over mu F_N [m]."""
    return quad(lambda x: 0.75 / a * (1 - (x / a) ** 2) * abs(x + e), -a, a, points=[-e])[0]


def test_tolerances_enter_the_band_as_they_move_full_slide() -> None:
    rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(a=0.001, e=0.0, load=0.01, k=0.05 * K))
    tuning = tuning_with_tolerances(Tuning(mu_floor=0.0), rig, K)
    by_a = (slide(0.0451, 0.009) - slide(0.0449, 0.009)) / 2e-4 / slide(0.045, 0.009)

    # Even within its tolerance: the standard deviation is that over the root of 3.
    assert tuning.mu_floor == pytest.approx(np.hypot(by_a * 0.001, 0.01) / np.sqrt(3), rel=1e-3)
    usual = tuning_with_tolerances(Tuning(mu_floor=0.0), Rig(a=0.045, e=0.009), K)
    assert usual.mu_floor > tuning.mu_floor


def test_no_torque_is_weighed_while_a_turn_back_may_be_noise() -> None:
    """On ice a turn of the angle's noise is part of the stick phase, of either branch."""
    tuning = Tuning(psi_noise=2e-4)
    limits: Any = [getattr(tuning, name) for name in SETTINGS]
    search, verdict = build_hypothesis_search_start()(0.0, 1, 10.0, 0, 0.2), np.zeros(len(VERDICT))
    counted = []
    for psi in (0.0, 0.005, 0.01, 0.0099, 0.0101, 0.00995, 0.0095, 0.009):
        given = (14, psi, 400.0, [400.0, 400.0], -0.3, 0.0, [K, 0.045, 0.009], limits)
        search, verdict, _, weighed = build_hypothesis_search_step()(search, verdict, 0, *given)
        counted.append(bool(weighed))
    assert counted == [True, True, True, False, True, False, True, True]


@pytest.mark.parametrize(
    "before", [[-0.02], [0.02], [0.0, -0.02], pytest.param([0.0, -0.3], marks=LONG)]
)
@pytest.mark.parametrize("mu", [0.05, 0.8])
@pytest.mark.parametrize("seed", [61, pytest.param(62, marks=LONG)])
def test_a_patch_may_be_twisted_before_the_first_sample(
    before: list[float], mu: float, seed: int
) -> None:
    """Free of torque at the first of these angles from the path's [rad]; turned once, or to and fro."""
    made = make_recording(seed, mu=mu, k=K, bristles=50, duration=10.0)
    noise = 0.02 * np.random.default_rng(seed).standard_normal(made.t.size)
    psi = np.concatenate([made.psi[0] + before, made.psi])
    M_z = bristle_torque(psi, mu)[len(before) :] + noise
    estimates = run(acquiring_ekf(), made.t, made.psi, np.full(made.t.size, 400.0), M_z)

    assert np.mean(wrong_and_usable(estimates, mu)) < 0.01
    # A twist by a single turn may stay a doubt.
    assert len(before) == 1 or estimates.usable.mean() > 0.15


@pytest.mark.parametrize(("before", "after", "when"), [(0.05, 0.8, 0.35), (0.8, 0.3, 0.3)])
def test_the_ground_may_change_in_an_acquisition(before: float, after: float, when: float) -> None:
    t = np.arange(0, 15, 0.01)
    psi, mu = 0.25 * np.sin(1.2 * t), np.where(t < when, before, after)
    M_z = bristle_torque(psi, mu) + 0.02 * np.random.default_rng(7).standard_normal(t.size)
    estimates = run(acquiring_ekf(), t, psi, np.full(t.size, 400.0), M_z)

    assert estimates.usable[t > 10].all()
    assert np.mean(wrong_and_usable(estimates, mu)) < 0.01


@pytest.mark.parametrize(
    ("before", "after"), [(0.8, 0.1), (0.8, 0.5), pytest.param(0.5, 0.05, marks=LONG)]
)
@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=LONG)])
def test_a_fall_of_the_ground_is_known_by_steering(kind: Any, before: float, after: float) -> None:
    """The innovation is that of the angle, which friction moves little: the torque has to tell."""
    made = make_steering_recording(5, friction_step(4.0, before, after), tyre=RigTyre(k=K), rate=500.0)
    observer = kind(model=Model(), values={"k": K}, rig=RIG, measurement_model=SteeringTorque())
    estimates = run(observer, made.t, made.psi, made.F_N, M=made.M + 0.1)

    mu = np.where(made.t < 4.0, before, after)
    assert np.mean(wrong_and_usable(estimates, mu)) < 0.03
    assert (estimates.status & Status.RESET).any()
    assert estimates.usable[-1]
    assert abs(estimates.mu[-1] - after) < 2 * estimates.mu_std[-1]


def test_a_parked_wheel_is_not_suspected() -> None:
    """An encoder that toggles one step of 14 bits turns no wheel."""
    rng, n = np.random.default_rng(3), 3000
    psi = rng.integers(0, 2, n) * 2 * np.pi / 2**14
    M_z = 0.03 * rng.standard_normal(n)
    estimates = run(acquiring_ekf(), np.arange(n) * 0.01, psi, np.full(n, 400.0), M_z)

    assert not (estimates.status & Status.SUSPECT).any()
    assert not estimates.usable.any()


def test_a_scale_of_the_torque_is_one_of_friction_and_stiffness() -> None:
    """As s M(mu, k) = M(s mu, s k), and mu F_N alone enters, no observer can tell these apart."""
    signals = np.vstack([path(), np.zeros_like(path()), np.full(path().size, 400.0)])
    signals = np.vstack([signals, np.full(path().size, 0.01)])

    def torque(mu: float, k: float, load: float = 400.0) -> Array:
        signals[2] = load
        theta = Model().theta({"mu": mu, "k": k}).full().ravel()
        return np.asarray(simulate(Model(), signals, theta, np.array([0.045, 0.009])).M_z)

    for scale in (0.67, 0.8, 1.25):
        np.testing.assert_allclose(scale * torque(0.7, K), torque(0.7 * scale, K * scale), rtol=1e-12)
        np.testing.assert_allclose(torque(0.7, K), torque(0.7 / scale, K, 400 * scale), rtol=1e-12)


@pytest.mark.parametrize("fault", ["drifts", pytest.param("rolls", marks=LONG)])
def test_a_torque_that_depends_on_time_is_no_friction(fault: str) -> None:
    """On ice the noise of a sample hides it; smoothed, it is more than the model's error."""
    made = make_recording(5001, mu=0.05, a=0.045, k=K, load=400.0, duration=5.0, bristles=500)
    M_z = made.M_z + 0.1 * made.t
    if fault == "rolls":
        M_z = relaxed(made.M_z, 0.3)
    estimates = run(acquiring_ekf(), made.t, made.psi, made.F_N, M_z)

    assert np.mean(wrong_and_usable(estimates, 0.05)) < 0.01
    assert (estimates.status & Status.INCONSISTENT != 0).any()


@pytest.mark.parametrize(
    ("fault", "seed", "mu"),
    [("drifts", 595001, 0.05), ("rolls", 595000, 0.8), ("drifts more", 595001, 0.8)],
)
def test_a_steering_torque_that_depends_on_time_is_no_friction(fault: str, seed: int, mu: float) -> None:
    """It is told by what lasts of the torques computed from it; a zero that moves is no new ground."""
    rate, duration = (0.5, 14.0) if fault == "drifts more" else (0.1, 5.0)
    made = make_steering_recording(seed, tyre=RigTyre(k=K, mu=mu), duration=duration, rate=500.0)
    M = made.M + rate * made.t
    if fault == "rolls":
        M = made.M + made.M_z_true - relaxed(made.M_z_true, 1.0, 0.002)
    observer = Ekf(model=Model(), values={"k": K}, rig=RIG, measurement_model=SteeringTorque())
    honest, estimates = (run(observer, made.t, made.psi, made.F_N, M=torque) for torque in (made.M, M))

    assert np.mean(wrong_and_usable(estimates, mu)) < 0.01
    assert (estimates.status & Status.INCONSISTENT != 0).any()
    assert honest.usable.mean() > 0.3
    assert not wrong_and_usable(honest, mu).any()


@pytest.mark.parametrize("off", [0.8, pytest.param(1.2, marks=LONG)])
def test_the_tolerance_of_k_is_no_error_of_a_model_that_was_found(off: float) -> None:
    effect = {"rate_friction": {"c": 0.02}}
    made = make_recording(3, effect, a=0.045, k=off * K, mu=0.9, load=400.0, duration=10.0, bristles=300)
    tuning = Tuning(error=0.02, noise=0.005, explained=2.5, error_travel=0.15)
    observer = Ekf(**found_model({"rate_friction.c": 0.02}), rig=RIG, tuning=tuning)
    estimates = run(observer, made.t, made.psi, made.F_N, made.M_z)

    assert not (estimates.status & Status.INCONSISTENT).any()
    assert estimates.usable.mean() > 0.5
    assert np.abs(estimates.mu - 0.9)[estimates.usable].max() < 0.2
