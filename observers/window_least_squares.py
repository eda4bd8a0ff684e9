"""One sample of the linear least-squares problem of a window, which is solved along its chain.

Minimise over x_1 ... x_N

    |x_1 - mean|^2 / P  +  sum_i w_i (z_i - H_i' x_i)^2  +  sum_i |x_{i+1} - A_i x_i - b_i|^2 / Q_i

Forward elimination is the Kalman filter on UDU factors of the covariance, back substitution the smoother
of Bryson and Frazier. Together they give the solution of Rauch, Tung and Striebel without inverting a
covariance: states that are known exactly, or that are constant, are no special case. The work grows with
N, not with N^3.

Sources: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445; Bryson, Frazier, Smoothing for linear and
nonlinear dynamic systems, Proc. Optimum System Synthesis Conf. (1963).
"""

from functools import cache

import casadi as ca

from observers.udu import covariance, predict_covariance, update_covariance


@cache
def build_window_update(states: int) -> ca.Function:
    """One measurement and the motion to the next sample.

    (mean, factor, z, H, weight, A, b, Q) -> (mean_next, factor_next, x, P, K, score): mean and factor at
    the next sample; filtered mean x (n,) and covariance P (n, n) at this one; the gain, and the
    innovation over its variance. weight is the inverse variance of z, 0 where z is missing.
    """
    mean, factor = ca.SX.sym("mean", states), ca.SX.sym("factor", states, states)
    z, weight, H = ca.SX.sym("z"), ca.SX.sym("weight"), ca.SX.sym("H", states)
    A, b, Q = ca.SX.sym("A", states, states), ca.SX.sym("b", states), ca.SX.sym("Q", states)
    after, K, share = update_covariance(factor, H, weight)
    innovation = z - ca.dot(H, mean)
    x = mean + K * innovation
    return ca.Function(
        "kalman_update",
        [mean, factor, z, H, weight, A, b, Q],
        [A @ x + b, predict_covariance(after, A, Q), x, covariance(after), K, share * innovation],
        ["mean", "factor", "z", "H", "weight", "A", "b", "Q"],
        ["mean_next", "factor_next", "x", "P", "K", "score"],
        {"cse": True},
    )


@cache
def build_back_substitution(states: int) -> ca.Function:
    """(costate, x, P, H, K, score, A) -> (costate_before, smoothed).

    costate (n,) is that of the next sample, 0 at the newest; x to A as of `build_window_update` at this
    sample.
    """
    costate, x, P = ca.SX.sym("costate", states), ca.SX.sym("x", states), ca.SX.sym("P", states, states)
    H, K, score = ca.SX.sym("H", states), ca.SX.sym("K", states), ca.SX.sym("score")
    A = ca.SX.sym("A", states, states)
    after = A.T @ costate
    return ca.Function(
        "back_substitution",
        [costate, x, P, H, K, score, A],
        [after - H * (ca.dot(K, after) + score), x - P @ after],
        ["costate", "x", "P", "H", "K", "score", "A"],
        ["costate_before", "smoothed"],
    )
