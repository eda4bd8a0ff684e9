"""Linear chains of states and their dense least squares."""

from dataclasses import dataclass

import numpy as np

from symbolic.float_array_type import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Chain:
    """Arguments of the smoother, with the covariance P = root root' in place of its factor.

    x_1 ~ (mean, P); z_i = H_i' x_i + error of inverse variance weight_i; x_{i+1} = A_i x_i + b_i + noise
    of variances Q_i. Arrays of shape (N, ...).
    """

    mean: Array
    root: Array
    z: Array
    H: Array
    weight: Array
    A: Array
    b: Array
    Q: Array

    @property
    def size(self) -> tuple[int, int]:
        """N and n."""
        return self.H.shape[0], self.H.shape[1]

    @property
    def P(self) -> Array:
        """Covariance of x_1 before the first measurement."""
        return np.asarray(self.root @ self.root.T)

    @property
    def arguments(self) -> tuple[Array, ...]:
        """mean, factor, z, H, weight, A, b and Q, columns of all samples side by side."""
        N, n = self.size
        rows = (self.z.reshape(1, N), self.H.T, self.weight.reshape(1, N))
        motion = (self.A.transpose(1, 0, 2).reshape(n, n * N), self.b.T, self.Q.T)
        return (self.mean, factor_of(self.P), *rows, *motion)


def factor_of(P: Array) -> Array:
    """U above the diagonal and D on it, P = U D U', the last state first; P may be singular."""
    left, factor = P.copy(), np.zeros_like(P)
    for j in range(len(P) - 1, -1, -1):
        factor[j, j] = left[j, j]
        if left[j, j] > 0:
            factor[:j, j] = left[:j, j] / left[j, j]
            left = left - left[j, j] * np.outer(factor[:, j], factor[:, j])
    return factor


def dense(chain: Chain) -> tuple[Array, Array]:
    """States (N, n) and the covariance of the last, by orthogonal least squares in what is random.

    The unknowns are what drives the chain, x_1 = mean + root u and noise Q^(1/2) v, so that a state
    which nothing disturbs is an equality.
    """
    N, n = chain.size
    centre, spread = chain.mean, np.zeros((n, n * N))
    spread[:, :n] = chain.root
    centres, spreads = [centre], [spread]
    for i in range(N - 1):
        centre, spread = chain.A[i] @ centre + chain.b[i], chain.A[i] @ spread
        spread[:, n * (i + 1) : n * (i + 2)] += np.diag(np.sqrt(chain.Q[i]))
        centres.append(centre)
        spreads.append(spread)
    root = np.sqrt(chain.weight)
    seen = np.array([root[i] * chain.H[i] @ spreads[i] for i in range(N)])
    missed = np.array([root[i] * (chain.z[i] - chain.H[i] @ centres[i]) for i in range(N)])
    stacked = np.vstack([seen, np.eye(n * N)])
    drive = np.linalg.lstsq(stacked, np.concatenate([missed, np.zeros(n * N)]), rcond=None)[0]
    x = np.array([centres[i] + spreads[i] @ drive for i in range(N)])
    half = np.linalg.solve(np.linalg.cholesky(stacked.T @ stacked), spreads[-1].T)
    return x, half.T @ half
