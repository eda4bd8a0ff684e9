"""Covariances as UDU factors, P = U D U': positive definite under rounding in single precision too.

U is upper triangular with ones on its diagonal, D diagonal; one matrix holds both, D on the diagonal.
No covariance is subtracted from another: every new D is a product or a sum of positive numbers.

Sources: Bierman, Factorization Methods for Discrete Sequential Estimation (1977), for the measurement;
Thornton, Triangular covariance factorizations for Kalman filtering, thesis UCLA (1976), for the motion.
"""

from functools import cache

import casadi as ca
import numpy as np

from observers.layout import Expression, symbols
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import named_function

LEAST_SHARE = 1e-6
"""Least D of a factor of a covariance, as a share of the variance [1]."""
MAX_VARIANCE = 1e12
"""Upper limit of D after a prediction, against overflow where a sensor fails for long."""


def symbolic_covariance_from_udu(factor: Expression) -> Expression:
    """P of a factor, both casadi and of shape (n, n)."""
    U, D = ca.triu(factor, False) + ca.DM.eye(factor.shape[0]), ca.diag(ca.diag(factor))
    return U @ D @ U.T


def factor_of(P: ca.SX) -> ca.SX:
    """The factor of a covariance of shape (n, n), as far as rounding leaves it positive."""
    n, factor = P.shape[0], ca.SX.zeros(*P.shape)
    for j in range(n - 1, -1, -1):
        later = range(j + 1, n)
        D = P[j, j] - sum((factor[j, k] ** 2 * factor[k, k] for k in later), ca.SX(0))
        # Mixtures of many hypotheses are rounded: what they leave is no less than a share of it.
        factor[j, j] = D = ca.fmax(D, LEAST_SHARE * P[j, j])
        for i in range(j):
            left = P[i, j] - sum((factor[i, k] * factor[j, k] * factor[k, k] for k in later), ca.SX(0))
            factor[i, j] = ca.if_else(D > 0, left / ca.if_else(D > 0, D, 1), 0)
    return factor


def covariance_of(factor: Array) -> Array:
    """P of a factor, both NumPy and of shape (n, n)."""
    U = np.triu(factor, 1) + np.eye(len(factor))
    return np.asarray((U * np.diag(factor)) @ U.T)


def update_covariance(factor: ca.SX, H: ca.SX, weight: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """The factor (n, n) after one scalar measurement of derivative H (n,), the gain K, 1 / (R + H P H').

    weight is the inverse variance of the measurement; it and the last result are 0 where there is none.
    """
    n = H.numel()
    U = ca.triu(factor, False) + ca.SX.eye(n)
    f = U.T @ H
    v = ca.diag(factor) * f
    factor_next = ca.SX(factor)
    # Bierman's recursion times weight, so that a weight of 0 needs no infinite variance.
    share = ca.SX(1)
    gain = ca.SX.zeros(n)
    for j in range(n):
        scaled = weight * f[j]
        grown = share + scaled * v[j]
        factor_next[j, j] = factor[j, j] * (share / grown)
        for i in range(j):
            factor_next[i, j] = factor[i, j] - gain[i] * (scaled / share)
            gain[i] += factor[i, j] * v[j]
        gain[j] = v[j]
        share = grown
    left = weight / share
    return factor_next, gain * left, left


def add_variance(factor: Expression, at: int, variance: Expression) -> Expression:
    """The factor of P + variance e e', with e the unit vector of index `at`; variance >= 0.

    [Bierman 1977], section III.4, the rank-one update of Agee and Turner. At index 0 it adds to one
    element of D, as there is no column of U before it; elsewhere U changes too.
    """
    factor_next, rest = type(factor)(factor), variance
    # What is left of e, after the columns from `at` down to j.
    vector: list[Expression] = [0] * at + [1]
    for j in range(at, -1, -1):
        D = factor[j, j] + rest * vector[j] ** 2
        factor_next[j, j] = D
        # A state that is known exactly has D = 0 and no correlation.
        share = ca.if_else(D > 0, rest / ca.if_else(D > 0, D, 1), 0)
        for i in range(j):
            vector[i] = vector[i] - vector[j] * factor[i, j]
            factor_next[i, j] = factor[i, j] + share * vector[j] * vector[i]
        rest = ca.if_else(D > 0, share * factor[j, j], rest)
    return factor_next


def predict_covariance(factor: ca.SX, A: ca.SX, Q: ca.SX) -> ca.SX:
    """The factor of A P A' + diag(Q), by weighted Gram-Schmidt from the last row up; Q >= 0, (n,).

    D stops at `MAX_VARIANCE`: while a sensor fails, an unstable motion would let it overflow.
    """
    n = Q.numel()
    rows = ca.horzcat(A @ (ca.triu(factor, False) + ca.SX.eye(n)), ca.SX.eye(n))
    weights = ca.vertcat(ca.diag(factor), Q)
    work = [rows[i, :].T for i in range(n)]
    factor_next = ca.SX.zeros(n, n)
    for j in range(n - 1, -1, -1):
        weighted = work[j] * weights
        D = ca.dot(work[j], weighted)
        factor_next[j, j] = ca.fmin(D, MAX_VARIANCE)
        for i in range(j):
            # A state that is known exactly has D = 0 and no correlation.
            share = ca.if_else(D > 0, ca.dot(work[i], weighted) / ca.if_else(D > 0, D, 1), 0)
            factor_next[i, j] = share
            work[i] = work[i] - share * work[j]
    return factor_next


@cache
def build_udu_prediction(states: int) -> ca.Function:
    """(factor, A, Q) -> factor of A P A' + diag(Q)."""
    inputs = symbols(ca.SX, factor=(states, states), A=(states, states), Q=states)
    outputs = {"factor_next": predict_covariance(*inputs.values())}
    return named_function("predict_covariance", inputs, outputs)


@cache
def build_udu_update(states: int) -> ca.Function:
    """(factor, H, weight) -> (factor_next, K, share), share = 1 / (R + H P H'), 0 if missing."""
    inputs = symbols(ca.SX, factor=(states, states), H=states, weight=1)
    results = update_covariance(*inputs.values())
    outputs = dict(zip(("factor_next", "K", "share"), results, strict=True))
    return named_function("update_covariance", inputs, outputs)
