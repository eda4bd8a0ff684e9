"""The smoother of a chain against dense and textbook solutions; windows that move along it."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from observers.estimators.mhe_terms import build_backward_pass, build_window_update
from tests.observers.chains import Chain, dense, textbook

Array = NDArray[np.float64]


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
    N, n = chain.size
    x, P = (np.asarray(made) for made in build_smoother(n, N)(*chain.arguments))
    return x.T, P


def build_smoother(n: int, N: int) -> Callable[..., tuple[Array, Array]]:
    """Forward elimination and back substitution along a chain: x (n, N) and P of its newest state."""
    forward = build_window_update(n).mapaccum("forward", N, 2, {})
    backward = build_backward_pass(n).mapaccum("backward", N, 1, {})

    def smoother(mean: Array, factor: Array, *terms: Array) -> tuple[Array, Array]:
        _, _, *filtered = (np.asarray(part) for part in forward(mean, factor, *terms))
        x, P, K, score = (reverse(part, N) for part in filtered)
        H, A = (reverse(part, N) for part in (terms[1], terms[3]))
        smoothed = np.asarray(backward(np.zeros(n), x, P, H, K, score, A)[1])
        return reverse(smoothed, N), P[:, :n]

    return smoother


def reverse(blocks: Array, N: int) -> Array:
    """N blocks of columns, the last one first."""
    return np.hstack(np.hsplit(np.asarray(blocks), N)[::-1])


def close(made: Array, expected: Array, within: float) -> None:
    np.testing.assert_allclose(made, expected, rtol=0, atol=within * max(1.0, np.abs(expected).max()))


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
    x, P = solved(chain)
    x_dense, P_dense = dense(chain)

    close(x, x_dense, 1e-11)
    close(P, P_dense, 1e-11)


@pytest.mark.parametrize("window", [1, 2, 7, 60])
@pytest.mark.parametrize("n", [1, 3])
def test_every_window_moving_along_a_linear_chain_is_the_kalman_filter(window: int, n: int) -> None:
    whole = random_chain(5, n, N=60, still=0.3)
    mean, factor = whole.arguments[:2]
    for newest in range(window - 1, 60):
        first = newest - window + 1
        mean, factor = (np.asarray(part) for part in (mean, factor))
        if first > 0:
            mean, factor, *_ = build_window_update(n)(mean, factor, *terms(whole, first - 1, first))
        x, P = build_smoother(n, window)(mean, factor, *terms(whole, first, newest + 1))
        filtered, covariances, smoothed, _ = textbook(part_of(whole, newest + 1))

        close(np.asarray(x)[:, -1], filtered[-1], 1e-9)
        close(np.asarray(P), covariances[-1], 1e-9)
        close(np.asarray(x).T, smoothed[first:], 1e-9)


def part_of(chain: Chain, stop: int) -> Chain:
    later = {name: getattr(chain, name)[:stop] for name in ("z", "H", "weight", "A", "b", "Q")}
    return Chain(mean=chain.mean, root=chain.root, **later)


def terms(chain: Chain, start: int, stop: int) -> tuple[Array, ...]:
    """Some samples, z to Q as the Functions take them."""
    rows = {name: getattr(chain, name)[start:stop] for name in ("z", "H", "weight", "A", "b", "Q")}
    return Chain(mean=chain.mean, root=chain.root, **rows).arguments[2:]
