"""The linear least-squares problem of a window, solved along its chain.

Minimise over x_1 ... x_N

    |x_1 - mean|^2 / P  +  sum_i w_i (z_i - H_i' x_i)^2  +  sum_i |x_{i+1} - A_i x_i - b_i|^2 / Q_i

The forward pass is the Kalman filter on factors of the covariance, the backward pass that of Bryson and
Frazier, which gives the solution of Rauch, Tung and Striebel without inverting a covariance: a state
that is known exactly, or that does not walk, needs no care. The work grows with N, not with N^3. There
is no tyre in here.

Sources: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445; Bryson, Frazier, Smoothing for linear and
nonlinear dynamic systems, Proc. Optimum System Synthesis Conf. (1963).
"""

from functools import cache

import casadi as ca

from observers.udu import covariance, measured, moved


@cache
def build_update(states: int) -> ca.Function:
    """One measurement and the motion to the next sample.

    (mean, factor, z, H, weight, A, b, Q) -> (mean, factor, x, spread, K, score), named so: mean and
    factor at the next sample; filtered mean x (n,) and covariance `spread` (n, n) at this one; the gain,
    and the innovation over its variance. weight is the inverse variance of z, 0 where z is missing.
    """
    mean, factor = ca.SX.sym("mean", states), ca.SX.sym("factor", states, states)
    z, weight, H = ca.SX.sym("z"), ca.SX.sym("weight"), ca.SX.sym("H", states)
    A, b, Q = ca.SX.sym("A", states, states), ca.SX.sym("b", states), ca.SX.sym("Q", states)
    after, K, share = measured(factor, H, weight)
    innovation = z - ca.dot(H, mean)
    x = mean + K * innovation
    return ca.Function(
        "kalman_update",
        [mean, factor, z, H, weight, A, b, Q],
        [A @ x + b, moved(after, A, Q), x, covariance(after), K, share * innovation],
        ["mean", "factor", "z", "H", "weight", "A", "b", "Q"],
        ["mean_next", "factor_next", "x", "spread", "K", "score"],
        {"cse": True},
    )


@cache
def build_smoother(states: int, window: int) -> ca.Function:
    """The minimiser over a window, and the covariance of its newest state.

    (mean, factor, z, H, weight, A, b, Q) -> (x, P_newest), named so: z and weight (1, N), H, b and Q
    (n, N), A (n, n N); the last A, b and Q lead out of the window and do not matter. x is (n, N).
    """
    update = build_update(states)
    names = update.name_in()
    symbols = [ca.MX.sym(name, *update.size_in(name)) for name in names[:2]]
    symbols += [ca.MX.sym(n, update.size1_in(n), update.size2_in(n) * window) for n in names[2:]]
    terms = dict(zip(names, symbols, strict=True))
    forth = update.mapaccum("kalman_forth", window, 2, {})
    _, _, x, spread, K, score = forth(*symbols)
    latest_first = list(range(window - 1, -1, -1))
    blocks = [states * i + j for i in latest_first for j in range(states)]
    # The costate comes back through the motion out of a sample, which the newest does not have.
    motion = ca.horzcat(terms["A"][:, : states * (window - 1)], ca.DM(states, states))
    back = build_back(states).mapaccum("smoother_back", window, 1, {})
    _, smoothed = back(
        ca.DM.zeros(states), x[:, latest_first], spread[:, blocks], terms["H"][:, latest_first],
        K[:, latest_first], score[:, latest_first], ca.densify(motion)[:, blocks],
    )  # fmt: skip
    return ca.Function(
        "smoother", symbols, [smoothed[:, latest_first], spread[:, -states:]], names, ["x", "P_newest"]
    )


def build_back(states: int) -> ca.Function:
    """(costate of the next, filtered x, P, H, K, score, A) -> (costate of this one, smoothed x)."""
    costate, x, P = ca.SX.sym("costate", states), ca.SX.sym("x", states), ca.SX.sym("P", states, states)
    H, K, score = ca.SX.sym("H", states), ca.SX.sym("K", states), ca.SX.sym("score")
    A = ca.SX.sym("A", states, states)
    after = A.T @ costate
    before = after - H * (ca.dot(K, after) + score)
    names = ["costate", "x", "P", "H", "K", "score", "A"]
    return ca.Function(
        "back", [costate, x, P, H, K, score, A], [before, x - P @ after], names, ["before", "smoothed"]
    )
