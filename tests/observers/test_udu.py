"""Factored covariances against the dense formulas, and where those fail."""

import casadi as ca
import numpy as np
import pytest

from observers import covariance_of
from observers.udu import (
    add_variance,
    build_udu_prediction,
    build_udu_update,
    factor_of,
    symbolic_covariance_from_udu,
)
from symbolic.float_array_type import Array

SIZES = range(1, 6)


def random_factor(rng: np.random.Generator, n: int, known: int = 0) -> Array:
    """U above the diagonal, D on it; the last `known` states known exactly."""
    D = 10 ** rng.uniform(-3, 3, n)
    D[n - known :] = 0.0
    return np.triu(rng.standard_normal((n, n)), 1) + np.diag(D)


def multiplied(factor: Array) -> Array:
    """P = U D U', written out."""
    U, D = np.triu(factor, 1), np.zeros_like(factor)
    np.fill_diagonal(U, 1.0)
    np.fill_diagonal(D, np.diagonal(factor))
    return np.asarray(U.dot(D).dot(U.T))


def close(made: Array, expected: Array) -> None:
    np.testing.assert_allclose(made, expected, rtol=0, atol=1e-12 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("weight", [0.0, 1e-3, 1.0, 1e5])
@pytest.mark.parametrize("known", [0, 1])
def test_measurement_is_the_textbook_update(n: int, weight: float, known: int) -> None:
    rng = np.random.default_rng([n, known])
    for _ in range(20):
        factor, H = random_factor(rng, n, known), rng.standard_normal(n)
        P = multiplied(factor)
        after, K, share = (np.asarray(made) for made in build_udu_update(n)(factor, H, weight))

        inverse = weight / (1 + weight * H @ P @ H)
        close(K.ravel(), P @ H * inverse)
        assert share.item() == pytest.approx(inverse, rel=1e-12)
        close(multiplied(after), P - np.outer(P @ H, P @ H) * inverse)
        assert (np.diagonal(after)[: n - known] > 0).all()
        assert (np.diagonal(after)[n - known :] == 0).all()
        assert (np.tril(after, -1) == 0).all()


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("known", [0, 1])
@pytest.mark.parametrize("still", ["none", "some", "all"])
@pytest.mark.parametrize("rank", ["full", "one less"])
def test_motion_is_the_textbook_prediction(n: int, known: int, still: str, rank: str) -> None:
    rng = np.random.default_rng([n, known])
    for _ in range(20):
        factor, A = random_factor(rng, n, known), rng.standard_normal((n, n))
        if rank == "one less":
            A[:, 0] = 0.0
        Q = rng.uniform(0.1, 1.0, n) * {"none": 1.0, "some": rng.random(n) < 0.5, "all": 0.0}[still]
        after = np.asarray(build_udu_prediction(n)(factor, A, Q))

        close(multiplied(after), A @ multiplied(factor) @ A.T + np.diag(Q))
        assert np.isfinite(after).all()
        assert (np.diagonal(after) >= 0).all()
        assert (np.diagonal(after) > 0).all() or still != "none"
        assert (np.tril(after, -1) == 0).all()


def test_variances_stay_positive_where_the_textbook_formula_goes_negative() -> None:
    rng = np.random.default_rng(3)
    factor = np.diag([1e6, 1e6, 1e6])
    P = multiplied(factor)
    A = np.eye(3) + 0.1 * rng.standard_normal((3, 3))
    least = np.inf
    for _ in range(300):
        H, weight = np.array([1.0, 1.0, 1.0]) + 1e-6 * rng.standard_normal(3), 1e12
        factor = np.asarray(build_udu_update(3)(factor, H, weight)[0])
        assert (np.diagonal(factor) > 0).all()
        gain = P @ H * weight / (1 + weight * H @ P @ H)
        P = P - np.outer(gain, H @ P)
        least = min(least, np.linalg.eigvalsh((P + P.T) / 2).min())
        factor = np.asarray(build_udu_prediction(3)(factor, A, np.zeros(3)))
        P = A @ P @ A.T
        assert (np.diagonal(factor) > 0).all()
    assert least < 0, "the textbook formula was not tried hard enough"


@pytest.mark.parametrize("n", SIZES)
def test_covariance_in_numpy_and_in_casadi(n: int) -> None:
    rng = np.random.default_rng(n)
    factor = random_factor(rng, n)
    # What lies below the diagonal belongs to nothing.
    dirty = factor + np.tril(rng.standard_normal((n, n)), -1)
    symbol = ca.MX.sym("factor", n, n)
    as_casadi = np.asarray(ca.Function("P", [symbol], [symbolic_covariance_from_udu(symbol)])(dirty))

    close(covariance_of(dirty), multiplied(factor))
    close(as_casadi, multiplied(factor))
    close(covariance_of(dirty), covariance_of(dirty).T)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("known", [0, 1])
@pytest.mark.parametrize("variance", [0.0, 1e-6, 2.0, 1e6])
def test_added_variance_is_that_of_the_dense_matrix(n: int, known: int, variance: float) -> None:
    rng = np.random.default_rng([n, known])
    symbol, added = ca.SX.sym("factor", n, n), ca.SX.sym("added")
    for at in range(n):
        build = ca.Function("add", [symbol, added], [add_variance(symbol, at, added)])
        factor, expected = random_factor(rng, n, known), np.zeros((n, n))
        expected[at, at] = variance
        after = np.asarray(build(factor, variance))

        close(multiplied(after), multiplied(factor) + expected)
        assert (np.diagonal(after) >= 0).all()
        assert at > 0 or after[0, 0] == factor[0, 0] + variance
        np.testing.assert_array_equal(after[:, at + 1 :], factor[:, at + 1 :])


def test_the_factor_of_a_covariance() -> None:
    root = np.random.default_rng(5).standard_normal((4, 4))
    P = root @ root.T
    factor = ca.Function("factor", [symbol := ca.SX.sym("P", 4, 4)], [factor_of(symbol)])(P).full()

    assert covariance_of(factor) == pytest.approx(P)
    assert np.tril(factor, -1) == pytest.approx(0)
