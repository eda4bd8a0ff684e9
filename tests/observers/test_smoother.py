"""The smoother against the dense normal equations, and against filterpy's filter and smoother."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from observers.smoother import build_smoother, build_update
from tests.observers.oracles import Problem, dense

Array = NDArray[np.float64]


def random_problem(seed: int, states: int = 2, window: int = 30, missing: float = 0.3) -> Problem:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((states, states))
    weight = np.where(rng.random(window) < missing, 0.0, rng.uniform(0.3, 3, window))
    return Problem(
        mean=rng.standard_normal(states),
        P=root @ root.T + 0.1 * np.eye(states),
        Q=rng.uniform(0.05, 1.0, (states, window)),
        z=rng.standard_normal((1, window)),
        H=rng.standard_normal((states, window)),
        weight=weight.reshape(1, -1),
    )


def textbook(problem: Problem) -> tuple[Array, Array]:
    """The Kalman filter of filterpy and its Rauch-Tung-Striebel smoother."""
    states, window = problem.H.shape
    filter_ = KalmanFilter(dim_x=states, dim_z=1)
    filter_.x, filter_.P = problem.mean.reshape(-1, 1), problem.P.copy()
    means, covariances, walks = [], [], []
    for i in range(window):
        filter_.predict(Q=np.diag(problem.Q[:, i]))
        if (weight := problem.weight[0, i]) > 0:
            filter_.update(problem.z[:, i], R=1 / weight, H=problem.H[:, i : i + 1].T)
        means.append(filter_.x.copy())
        covariances.append(filter_.P.copy())
        walks.append(np.diag(problem.Q[:, i]))
    x, P, _, _ = filter_.rts_smoother(np.array(means), np.array(covariances), Qs=walks)
    return x[:, :, 0].T, P[-1]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("states", [1, 2, 3])
def test_solves_the_normal_equations(seed: int, states: int) -> None:
    problem = random_problem(seed, states)
    x, P = build_smoother(states, 30)(*problem.all)
    x_dense, P_dense = dense(problem)

    np.testing.assert_allclose(x, x_dense, rtol=0, atol=1e-12)
    np.testing.assert_allclose(P, P_dense, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_equals_the_textbook_filter_and_smoother(seed: int) -> None:
    problem = random_problem(seed, window=200)
    x, P = build_smoother(2, 200)(*problem.all)
    x_textbook, P_textbook = textbook(problem)

    np.testing.assert_allclose(x, x_textbook, rtol=0, atol=1e-9)
    np.testing.assert_allclose(P, P_textbook, rtol=0, atol=1e-9)


def test_without_measurements_the_prior_stays() -> None:
    problem = random_problem(7, missing=1.1)
    x, P = build_smoother(2, 30)(*problem.all)

    np.testing.assert_array_equal(x, np.tile(problem.mean.reshape(-1, 1), 30))
    np.testing.assert_allclose(P, problem.P + np.diag(problem.Q.sum(axis=1)), rtol=1e-14)


def test_a_state_known_exactly_stays() -> None:
    problem = random_problem(8)
    problem.P[:, 1], problem.P[1, :], problem.Q[1] = 0.0, 0.0, 0.0
    x, P = (np.asarray(made) for made in build_smoother(2, 30)(*problem.all))

    assert np.isfinite(x).all()
    np.testing.assert_array_equal(x[1], problem.mean[1])
    np.testing.assert_array_equal(P[1], 0.0)


def test_update_is_the_smoother_of_one_sample() -> None:
    problem = random_problem(9, window=1, missing=0.0)
    mean, P, *_ = build_update(2)(*problem.all)
    x, P_newest = build_smoother(2, 1)(*problem.all)

    np.testing.assert_allclose(mean, x, rtol=0, atol=1e-14)
    np.testing.assert_allclose(P, P_newest, rtol=0, atol=1e-14)
