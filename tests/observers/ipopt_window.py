"""The window of the moving horizon solved to convergence by IPOPT.

Multiple shooting: the states at every sample are unknowns of their own; the motion between two of them
costs what its disturbances cost, and a constant state is an equality constraint. IPOPT minimises the
cost of `observers.estimators.mhe` with exact gradients: the same arrival, the same patch history,
the same loss.

Sources: Bock and Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC World Congress (1984); Waechter and Biegler, Math. Programming 106 (2006) 25.
"""

from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.estimators.mhe import Mhe, layout
from observers.estimators.step_terms import STIFFNESS_BOUNDS
from observers.layout import ObserverState, symbols
from observers.measurement.linearisation import build_measurement, build_motion, state_index
from observers.measurement.measurement_model import CLEAN, ROWS, MeasurementModel
from observers.patch.history import PatchHistory
from observers.patch.patch_protocol import PatchModel, observer_constants_size, split_constants
from observers.udu import covariance_of
from symbolic.functions import named_function

Array = NDArray[np.float64]
# The tolerance asks for more than double precision gives, so steps that vanish are the usual end.
SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level", "Search_Direction_Becomes_Too_Small")


def solve_window(observer: Mhe, state: ObserverState) -> Array:
    """The states (n, N) of least cost of the window that a state holds; IPOPT begins there."""
    n, window = len(observer.states), observer.window
    model, measurement_model = observer.model, observer.measurement_model
    own = layout(model, measurement_model, window).size
    given = [ca.DM(state.values[:own]), ca.DM(observer.constants)]
    start = ca.DM(state["x"].reshape(n, window, order="F"))
    variances = _build_costs(model, measurement_model, window)(start, *given)[2].full()
    arrival = covariance_of(state["factor"].reshape(n, n, order="F"))
    spread = np.concatenate([np.diag(arrival), variances.ravel(order="F")])
    fixed = tuple(np.flatnonzero(spread <= 0).tolist())
    solver = _build_solver(model, measurement_model, window, fixed)
    tuning = observer.tuning
    limits = {"log_mu": np.log([tuning.least, tuning.greatest]), "stiffness": np.array(STIFFNESS_BOUNDS)}
    bounds = np.array([limits.get(name, np.array([-np.inf, np.inf])) for name in observer.states])
    solution = solver(
        x0=ca.vec(start), p=ca.vertcat(*given), lbg=0, ubg=0,
        lbx=np.tile(bounds[:, 0], window), ubx=np.tile(bounds[:, 1], window),
    )  # fmt: skip
    assert solver.stats()["return_status"] in SOLVED
    assert 0 < float(solution["f"]) < np.inf
    return np.asarray(solution["x"]).reshape(n, window, order="F")


@cache
def _build_costs(model: PatchModel, measurement_model: MeasurementModel, window: int) -> ca.Function:
    """(x, state, constants) -> (innovations, weights, variances, defects, huber_scale), by sample."""
    parts = layout(model, measurement_model, window)
    patch = PatchHistory(model=model, measurement_model=measurement_model, window=window)
    inputs = symbols(
        ca.MX, x=(len(measurement_model.states), window), state=parts.size,
        constants=observer_constants_size(model),
    )  # fmt: skip
    x, state, constants = inputs.values()
    kept = parts.split(state)
    theta, rig, tuning = split_constants(model, constants)
    M_z, slopes = patch.torques(kept, x, theta, rig)
    samples = kept["samples"]
    clean = samples[: len(CLEAN), :]
    constant = [ca.repmat(vector, 1, window) for vector in (rig, tuning)]
    measure = build_measurement(measurement_model).map(window)
    move = build_motion(measurement_model).map(window)
    innovations = measure(x, M_z, slopes, clean, *constant)[0]
    # The model's error is a share of the torque: its variance is that at the states of the estimator.
    at = ca.reshape(kept["x"], *x.shape)
    _, _, weights, _, huber_scale, _ = measure(
        at, *patch.torques(kept, at, theta, rig), clean, *constant
    )
    onward = ca.horzcat(clean[:, 1:], clean[:, -1])
    predicted, _, variances, _ = move(x, M_z, slopes, clean, onward, *constant)
    variances = variances[:, :-1]
    variances[state_index(measurement_model), :] += samples[ROWS.index("jump"), 1:]
    weights = weights * samples[ROWS.index("accepted"), :]
    outputs = {
        "innovations": innovations,
        "weights": weights,
        "variances": variances,
        "defects": x[:, 1:] - predicted[:, :-1],
        "huber_scale": huber_scale,
    }
    return named_function("costs", inputs, outputs)


@cache
def _build_solver(
    model: PatchModel,
    measurement_model: MeasurementModel,
    window: int,
    fixed: tuple[int, ...],
) -> ca.Function:
    """The nonlinear programme; `fixed` are the defects, arrival first, that must vanish."""
    n, parts = len(measurement_model.states), layout(model, measurement_model, window)
    x = ca.MX.sym("x", n, window)
    given = ca.MX.sym("given", parts.size + observer_constants_size(model))
    state, constants = given[: parts.size], given[parts.size :]
    kept = parts.split(state)
    innovations, weights, variances, defects, huber_scale = _build_costs(
        model, measurement_model, window
    )(x, state, constants)
    U = ca.triu(kept["factor"], False) + ca.DM.eye(n)
    arrival = ca.solve(U, x[:, 0] - kept["mean"])
    off = ca.vertcat(arrival, ca.vec(defects))
    variance = ca.vertcat(ca.diag(kept["factor"]), ca.vec(variances))
    free = [i for i in range(off.numel()) if i not in fixed]
    squares = innovations**2
    beyond = squares > huber_scale
    # Huber's function: quadratic up to its scale, linear beyond.
    linear = 2 * ca.sqrt(ca.if_else(beyond, huber_scale * squares, 1)) - ca.if_else(
        beyond, huber_scale, 0
    )
    loss = ca.if_else(beyond, linear, squares)
    cost = ca.sum1(off[free] ** 2 / variance[free]) + ca.sum2(weights * loss)
    nlp: dict[str, Any] = {"x": ca.vec(x), "p": given, "f": cost, "g": off[list(fixed)]}
    options: dict[str, Any] = {
        "print_time": False,
        # Nobody asks for the sensitivity to what is given, missing samples (NaN) among it.
        "calc_lam_p": False,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "tol": 1e-12,
            "max_iter": 200,
            "mu_strategy": "adaptive",
        },
    }
    return ca.nlpsol("window", "ipopt", nlp, options)
