"""The filter against filterpy, against the whole history simulated anew, and at its limits."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from numpy.typing import NDArray

from observers import Ekf, EkfState, Sample, Tuning
from symbolic import InvalidInputError, Model, effects_named, simulate
from tests.observers.conftest import RIG, K
from tests.rig.record import RigRecording

Array = NDArray[np.float64]
Make = Callable[..., Ekf]
GEOMETRY = np.array([RIG.a, RIG.e])
AT_REST: Mapping[str, float] = {"psi": 0.0, "psi_dot": 0.0, "F_N": 400.0, "dt": 0.01}


def samples_of(made: RigRecording, start: int = 0, stop: int | None = None) -> list[Sample]:
    rate = np.gradient(made.psi, made.t)
    rows = np.column_stack([made.psi, rate, made.F_N, made.M_z])[start:stop]
    return [Sample(psi=p, psi_dot=v, F_N=F, dt=0.01, M_z=M) for p, v, F, M in rows]


def states_of(ekf: Ekf, samples: list[Sample]) -> Iterator[EkfState]:
    state = ekf.init(samples[0])
    for sample in samples:
        state = ekf.step(state, sample)
        yield state


def signals_of(samples: list[Sample]) -> Array:
    return np.array([[s.psi, s.psi_dot, s.F_N, s.dt] for s in samples]).T


class Oracle:
    """filterpy's filter, its h and H from the model's step and that step's full Jacobians."""

    def __init__(self, ekf: Ekf, first: Sample) -> None:
        """Begin where the filter under test begins."""
        self.ekf, model = ekf, ekf.model
        self.theta = np.asarray(model.theta({**ekf.values, "mu": ekf.tuning.mu})).ravel()
        self.memory = np.asarray(model.start(self._signals(first), self.theta, GEOMETRY)).ravel()
        self.by_mu = np.zeros(self.memory.size)
        self.jacobian = model.step.jacobian()
        self.filter = ExtendedKalmanFilter(dim_x=2, dim_z=1)
        slide = 0.375 * first.F_N * RIG.a
        self.filter.x = np.array([[ekf.tuning.mu], [0.0]])
        self.filter.P = np.diag([ekf.tuning.mu_std**2, (ekf.tuning.zero_std * slide) ** 2])

    @staticmethod
    def _signals(sample: Sample) -> Array:
        return np.array([sample.psi, sample.psi_dot, sample.F_N, sample.dt])

    def step(self, sample: Sample) -> float:
        """Take a sample; the torque that was expected."""
        tuning, filter_ = self.ekf.tuning, self.filter
        slide = 0.375 * sample.F_N * RIG.a
        walk = np.array([tuning.mu_walk, tuning.zero_walk * slide])
        filter_.Q = np.diag(sample.dt * walk**2)
        filter_.R = np.array([[(tuning.noise * slide) ** 2]])
        filter_.predict()
        mu = float(filter_.x[0, 0])
        theta = np.concatenate([[mu], self.theta[1:]])
        inputs = (self.memory, self._signals(sample), theta, GEOMETRY)
        after, M_z = self.ekf.model.step(*inputs)
        slopes = self.ekf.model.step.jacobian()(*inputs, after, M_z)
        memory_by_memory, memory_by_theta = np.asarray(slopes[0]), np.asarray(slopes[2])
        torque_by_memory, torque_by_theta = np.asarray(slopes[4]), np.asarray(slopes[6])
        slope = (torque_by_memory @ self.by_mu)[0] + torque_by_theta[0, 0]
        self.by_mu = memory_by_memory @ self.by_mu + memory_by_theta[:, 0]
        expected = float(M_z) + float(filter_.x[1, 0])
        if np.isfinite(sample.M_z):
            filter_.update(
                np.array([[sample.M_z]]),
                HJacobian=lambda _: np.array([[slope, 1.0]]),
                Hx=lambda x: np.array([[float(M_z) + x[1, 0]]]),
            )
            filter_.x[0, 0] = np.clip(filter_.x[0, 0], tuning.least, tuning.greatest)
        moved = float(filter_.x[0, 0]) - mu
        self.memory = np.asarray(after).ravel() + moved * self.by_mu
        return expected


@pytest.mark.parametrize(
    ("effects", "values", "close"),
    [
        ((), {}, 1e-9),
        (("sensor_delay",), {"sensor_delay.delay": 0.013}, 1e-9),
        # A compliant wheel at rest turns by rounding alone; that leaves deep corners, which round again.
        (("carcass_torsion",), {"carcass_torsion.k_t": 400}, 1e-4),
        (("rate_friction",), {"rate_friction.c": 0.04}, 1e-9),
    ],
    ids=["declared", "delay", "carcass", "bristles"],
)
@pytest.mark.parametrize("noise", [0.3, 0.01])
def test_equals_filterpy(
    recording: RigRecording,
    effects: tuple[str, ...],
    values: dict[str, float],
    close: float,
    noise: float,
) -> None:
    model = Model(effects=effects_named(effects))
    ekf = Ekf(model=model, values={"k": K, **values}, rig=RIG, tuning=Tuning(noise=noise))
    samples = samples_of(recording, stop=300)
    samples[::7] = [replace(sample, M_z=float("nan")) for sample in samples[::7]]
    oracle = Oracle(ekf, samples[0])

    for sample, state in zip(samples, states_of(ekf, samples), strict=True):
        expected = oracle.step(sample)
        assert state.M_z_predicted == pytest.approx(expected, abs=close)
        np.testing.assert_allclose(state.x, oracle.filter.x.ravel(), rtol=0, atol=close)
        np.testing.assert_allclose(state.P, oracle.filter.P, rtol=close, atol=1e-12)
    assert abs(state.x[0] - 1) > 0.05, "the comparison saw no correction"


def test_prediction_is_the_whole_history_at_the_present_mu(recording: RigRecording, ekf: Make) -> None:
    observer, samples = ekf(noise=0.01), samples_of(recording)
    signals = signals_of(samples)
    x = np.array([observer.tuning.mu, 0.0])
    for number, state in enumerate(states_of(observer, samples), start=1):
        if number % 100 == 0:
            theta = np.array([x[0], K])
            again = simulate(observer.model, signals[:, :number], theta, GEOMETRY).M_z[-1] + x[1]
            assert state.M_z_predicted == pytest.approx(again, abs=1e-9)
        x = state.x


def test_bristles_forget_the_first_guess_of_mu(recording: RigRecording) -> None:
    # Their memory depends on mu: without its derivative the first guess would stay in it.
    model = Model(discretised=True)
    observer = Ekf(model=model, values={"k": K}, rig=RIG, tuning=Tuning(noise=0.01))
    samples = samples_of(recording, stop=600)
    *_, before, last = states_of(observer, samples)
    theta = np.array([before.x[0], K])
    again = simulate(model, signals_of(samples), theta, GEOMETRY).M_z[-1] + before.x[1]

    assert last.M_z_predicted == pytest.approx(again, abs=5e-3 * np.ptp(recording.M_z))


def test_wheel_at_rest_leaves_the_textbook_filter_of_the_torque_zero(ekf: Make) -> None:
    observer = ekf(noise=0.02)
    tuning, slide = observer.tuning, 0.375 * AT_REST["F_N"] * RIG.a
    noise = 0.02 * slide
    torques = 0.3 + noise * np.random.default_rng(4).standard_normal(400)
    samples = [Sample(**AT_REST, M_z=M_z) for M_z in torques]
    zero, variance = 0.0, (tuning.zero_std * slide) ** 2
    for count, (state, M_z) in enumerate(zip(states_of(observer, samples), torques, strict=True), 1):
        variance += 0.01 * (tuning.zero_walk * slide) ** 2
        gain = variance / (variance + noise**2)
        zero, variance = zero + gain * (M_z - zero), (1 - gain) * variance
        np.testing.assert_allclose(state.x, [tuning.mu, zero], rtol=0, atol=1e-12)
        of_mu = tuning.mu_std**2 + count * 0.01 * tuning.mu_walk**2
        np.testing.assert_allclose(state.P, np.diag([of_mu, variance]), rtol=1e-11, atol=1e-15)
    assert zero == pytest.approx(0.3, abs=0.03)
    assert not observer.estimate(state).informed


def test_covariance_stays_symmetric_and_positive_definite(recording: RigRecording, ekf: Make) -> None:
    samples = samples_of(recording) * 3
    for state in states_of(ekf(noise=1e-3, mu_walk=0.0, zero_walk=0.0), samples):
        assert abs(state.P[0, 1] - state.P[1, 0]) <= 1e-12 * np.sqrt(state.P[0, 0] * state.P[1, 1])
        assert np.linalg.eigvalsh(state.P).min() > 0


@pytest.mark.parametrize(("factor", "bound"), [(30.0, 4.0), (-5.0, 0.02)])
def test_mu_is_held_between_its_bounds(
    recording: RigRecording, ekf: Make, factor: float, bound: float
) -> None:
    observer = ekf(noise=0.01, zero_std=1e-3)
    scaled = [replace(sample, M_z=factor * sample.M_z) for sample in samples_of(recording)]
    seen = [observer.estimate(state).mu for state in states_of(observer, scaled)]

    assert 0.02 <= min(seen) <= max(seen) <= 4.0
    assert bound in seen


def test_step_leaves_the_state_that_it_was_given(recording: RigRecording, ekf: Make) -> None:
    observer, (first, second, *_) = ekf(), samples_of(recording, start=200)
    state = observer.step(observer.init(first), first)
    kept = [np.array(part) for part in (state.memory, state.carried, state.x, state.P)]
    once, twice = observer.step(state, second), observer.step(state, second)

    np.testing.assert_array_equal(once.x, twice.x)
    for part, copy in zip((state.memory, state.carried, state.x, state.P), kept, strict=True):
        np.testing.assert_array_equal(part, copy)


@pytest.mark.parametrize(
    "change",
    [
        {"F_N": 0.0},
        {"F_N": float("nan")},
        {"dt": 0.0},
        {"dt": -0.01},
        {"dt": float("inf")},
        {"F_N": float("inf")},
        {"psi": float("nan")},
        {"psi_dot": float("inf")},
    ],
    ids=str,
)
def test_a_sample_lacks_nothing_but_its_torque(change: dict[str, float]) -> None:
    assert np.isnan(Sample(**AT_REST).M_z)
    with pytest.raises(InvalidInputError, match="only M_z may be missing") as caught:
        Sample(**{**AT_REST, **change})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"mu_std": 0.0}, "mu_std"),
        ({"noise": float("nan")}, "noise"),
        ({"least": 0.0}, "least"),
        ({"mu_walk": -1.0}, "mu_walk"),
        ({"zero_std": -1.0}, "zero_std"),
        ({"zero_walk": float("nan")}, "zero_walk"),
        ({"mu": 4.0}, "between least and greatest"),
        ({"mu": float("nan")}, "between least and greatest"),
    ],
    ids=str,
)
def test_tuning_is_checked(change: dict[str, Any], word: str) -> None:
    with pytest.raises(InvalidInputError, match=word):
        Tuning(**change)


def test_a_missing_parameter_is_named(recording: RigRecording) -> None:
    observer = Ekf(model=Model(), values={}, rig=RIG)
    with pytest.raises(InvalidInputError, match="'k' is missing"):
        observer.init(samples_of(recording)[0])
