"""Elimination and back substitution along a chain against dense least squares."""

import numpy as np
import pytest

from observers.estimators.mhe_recursions import build_bryson_frazier_step, build_kalman_step
from symbolic.float_array_type import Array
from tests.observers.chains import Chain, dense


def random_chain(
    seed: int, n: int = 2, N: int = 30, *, missing: float = 0.3, still: float = 0.0, known: int = 0
) -> Chain:
    """A random chain, of which some states are not disturbed, and `known` of x_1 known exactly."""
    rng = np.random.default_rng([seed, n])
    A = np.array([np.linalg.qr(rng.standard_normal((n, n)))[0] for _ in range(N)])
    root = np.tril(rng.standard_normal((n, n))) + 0.5 * np.eye(n)
    root[n - known :] = 0.0
    return Chain(
        mean=rng.standard_normal(n),
        root=root,
        z=rng.standard_normal(N),
        H=rng.standard_normal((N, n)),
        weight=np.where(rng.random(N) < missing, 0.0, rng.uniform(0.3, 3, N)),
        A=A * rng.uniform(0.8, 1.2, (N, 1, 1)),
        b=rng.standard_normal((N, n)),
        Q=np.where(rng.random((N, n)) < still, 0.0, rng.uniform(0.05, 1.0, (N, n))),
    )


def solved(chain: Chain) -> tuple[Array, Array]:
    """States (N, n) along a chain and the covariance of the newest."""
    N, n = chain.size
    mean, factor, *terms = chain.arguments
    forward = build_kalman_step(n).mapaccum("forward", N, 2, {})
    backward = build_bryson_frazier_step(n).mapaccum("backward", N, 1, {})
    _, _, *filtered = (np.asarray(part) for part in forward(mean, factor, *terms))
    x, P, K, score = (reverse(part, N) for part in filtered)
    H, A = (reverse(part, N) for part in (terms[1], terms[3]))
    smoothed = np.asarray(backward(np.zeros(n), x, P, H, K, score, A)[1])
    return reverse(smoothed, N).T, P[:, :n]


def reverse(blocks: Array, N: int) -> Array:
    """N blocks of columns, the last one first."""
    return np.hstack(np.hsplit(np.asarray(blocks), N)[::-1])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize(
    ("still", "known", "missing"),
    [(0.0, 0, 0.3), (0.5, 0, 0.3), (1.0, 0, 0.3), (0.5, 1, 0.3), (0.5, 0, 1.1)],
)
def test_solves_the_dense_least_squares(
    seed: int, n: int, still: float, known: int, missing: float
) -> None:
    chain = random_chain(seed, n, still=still, known=known, missing=missing)
    for made, expected in zip(solved(chain), dense(chain), strict=True):
        size = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(made, expected, rtol=0, atol=1e-11 * size)
