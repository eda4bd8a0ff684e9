"""The arrowhead matrix against the full one."""

import numpy as np

from identification.arrow import Arrow, Split

M, N, P = 4, 3, 2
RNG = np.random.default_rng(7)


def example() -> tuple[Arrow, np.ndarray]:
    full = np.zeros((M + N * P, M + N * P))
    for i in range(N):
        columns = np.r_[:M, M + P * i : M + P * (i + 1)]
        rows = RNG.normal(size=(20, M + P))
        full[np.ix_(columns, columns)] += rows.T @ rows
    own = [slice(M + P * i, M + P * (i + 1)) for i in range(N)]
    arrow = Arrow(
        shared=full[:M, :M],
        cross=np.stack([full[:M, at] for at in own]),
        own=np.stack([full[at, at] for at in own]),
    )
    return arrow, full


def test_solves() -> None:
    arrow, full = example()
    right = RNG.normal(size=len(full))

    made = arrow.solve(Split(shared=right[:M], own=right[M:].reshape(N, P)))

    np.testing.assert_allclose(
        np.concatenate([made.shared, made.own.ravel()]), np.linalg.solve(full, right), rtol=1e-9
    )


def test_reduced_is_the_inverse_of_the_inverses_corner() -> None:
    arrow, full = example()

    np.testing.assert_allclose(np.linalg.inv(arrow.reduced()), np.linalg.inv(full)[:M, :M], rtol=1e-9)


def test_damped() -> None:
    arrow, _ = example()
    damped = arrow.damped(0.5)

    np.testing.assert_allclose(np.diag(damped.shared), 1.5 * np.diag(arrow.shared))
    np.testing.assert_allclose(damped.own[1, 0, 0], 1.5 * arrow.own[1, 0, 0])
    np.testing.assert_array_equal(damped.own[1, 0, 1], arrow.own[1, 0, 1])


def test_vectors() -> None:
    one = Split(shared=np.array([1.0, 2.0]), own=np.array([[3.0]]))

    assert (one + one * 2.0).own.tolist() == [[9.0]]
    assert one.dot(one) == 14.0
