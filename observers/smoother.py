"""Least squares over a window of random walks, by its structure: one pass forth and one back.

States x_i, i = 1 ... N, walk from x_0 ~ (mean, P), and one number a sample is measured of them:

    min  |x_0 - mean|^2 / P  +  sum_i |x_i - x_{i-1}|^2 / Q_i  +  sum_i weight_i (z_i - H_i' x_i)^2.

The forward pass is the Kalman filter, the backward pass that of Bryson and Frazier, which gives the
solution of Rauch, Tung and Striebel without inverting a covariance: a state that is known exactly, or
that does not walk, needs no care. The work grows with N, not with N^3. There is no tyre in here.

Sources: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445; Bryson, Frazier, Smoothing for linear and
nonlinear dynamic systems, Proc. Optimum System Synthesis Conf. (1963).
"""

import casadi as ca


def build_update(states: int) -> ca.Function:
    """One walk and one measurement: a step of the Kalman filter, covariance in Joseph's form.

    (mean, P, Q, z, H, weight) -> (mean, P, K, score), named so; mean, Q, H and K have shape (states,), Q
    being the variances of the walk. weight is the inverse variance of z, 0 where z is missing; score is
    the innovation over its variance.
    """
    mean, P = ca.SX.sym("mean", states), ca.SX.sym("P", states, states)
    Q, H = ca.SX.sym("Q", states), ca.SX.sym("H", states)
    z, weight = ca.SX.sym("z"), ca.SX.sym("weight")
    P_walked = P + ca.diag(Q)
    spread = P_walked @ H
    share = weight / (1 + weight * ca.dot(H, spread))
    K, score = share * spread, share * (z - ca.dot(H, mean))
    keep = ca.SX.eye(states) - K @ H.T
    # K K' / weight, without the division by a weight that may be 0.
    heard = share * spread @ spread.T / (1 + weight * ca.dot(H, spread))
    return ca.Function(
        "kalman_update",
        [mean, P, Q, z, H, weight],
        [mean + spread * score, keep @ P_walked @ keep.T + heard, K, score],
        ["mean", "P", "Q", "z", "H", "weight"],
        ["mean_next", "P_next", "K", "score"],
    )


def build_smoother(states: int, window: int) -> ca.Function:
    """The minimiser over a window, and the covariance of its newest state.

    (mean, P, Q, z, H, weight) -> (x, P_newest), named so; mean (states,) and P (states, states) as in
    the cost, Q and H (states, window), z and weight (1, window), x (states, window).
    """
    update = build_update(states)
    symbols = {name: ca.MX.sym(name, *update.size_in(name)) for name in ("mean", "P")}
    symbols |= {
        name: ca.MX.sym(name, update.size1_in(name), window) for name in ("Q", "z", "H", "weight")
    }
    forth = update.mapaccum("kalman_forth", window, 2, {})
    mean, P, K, score = forth(*symbols.values())
    latest_first = list(range(window - 1, -1, -1))
    blocks = [states * i + j for i in latest_first for j in range(states)]
    back = _build_back(states).mapaccum("smoother_back", window, 1, {})
    _, x = back(
        ca.DM.zeros(states),
        mean[:, latest_first],
        P[:, blocks],
        symbols["H"][:, latest_first],
        K[:, latest_first],
        score[:, latest_first],
    )
    return ca.Function(
        "smoother",
        list(symbols.values()),
        [x[:, latest_first], P[:, -states:]],
        list(symbols),
        ["x", "P_newest"],
    )


def _build_back(states: int) -> ca.Function:
    """(costate after, filtered mean, P, H, K, score) -> (costate before, smoothed state)."""
    costate, mean = ca.SX.sym("costate", states), ca.SX.sym("mean", states)
    P, H = ca.SX.sym("P", states, states), ca.SX.sym("H", states)
    K, score = ca.SX.sym("K", states), ca.SX.sym("score")
    before = costate - H * (ca.dot(K, costate) + score)
    return ca.Function("back", [costate, mean, P, H, K, score], [before, mean - P @ costate])
