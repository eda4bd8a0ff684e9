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

from observers.layout import symbols
from observers.udu import covariance, predict_covariance, update_covariance
from symbolic.functions import named_function


@cache
def build_window_update(states: int) -> ca.Function:
    """One measurement and the motion to the next sample.

    (mean, factor, z, H, weight, A, b, Q) -> (mean_next, factor_next, x, P, K, score): mean and factor at
    the next sample; filtered mean x (n,) and covariance P (n, n) at this one; the gain, and the
    innovation over its variance. weight is the inverse variance of z, 0 where z is missing.
    """
    n = states
    inputs = symbols(ca.SX, mean=n, factor=(n, n), z=1, H=n, weight=1, A=(n, n), b=n, Q=n)
    mean, factor, z, H, weight, A, b, Q = inputs.values()
    updated, K, share = update_covariance(factor, H, weight)
    innovation = z - ca.dot(H, mean)
    x = mean + K * innovation
    outputs = {
        "mean_next": A @ x + b,
        "factor_next": predict_covariance(updated, A, Q),
        "x": x,
        "P": covariance(updated),
        "K": K,
        "score": share * innovation,
    }
    return named_function("kalman_update", inputs, outputs, cse=True)


@cache
def build_backward_pass(states: int) -> ca.Function:
    """(costate, x, P, H, K, score, A) -> (costate_before, smoothed).

    costate (n,) is that of the next sample, 0 at the newest; x to A as of `build_window_update` at this
    sample.
    """
    n = states
    inputs = symbols(ca.SX, costate=n, x=n, P=(n, n), H=n, K=n, score=1, A=(n, n))
    costate, x, P, H, K, score, A = inputs.values()
    propagated = A.T @ costate
    before = propagated - H * (ca.dot(K, propagated) + score)
    outputs = {"costate_before": before, "smoothed": x - P @ propagated}
    return named_function("back_substitution", inputs, outputs)
