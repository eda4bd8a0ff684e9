"""The likelihood of free vibrations as a nonlinear programme of CasADi, as a reference for `solve`.

Single shooting: the angles at the samples are functions of the unknowns of
`identification.free_decay.likelihood`, CasADi differentiates the objective twice, and IPOPT takes
Newton steps with that Hessian, curvature of the angles included. `solve` leaves that out, shares no
solver with this, and is many times as quick; this one is meant for tests.

Source: Waechter and Biegler, On the implementation of an interior-point filter line-search algorithm for
large-scale nonlinear programming, Math. Programming 106 (2006) 25.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from identification.free_decay.likelihood import Likelihood, contact_of, sample_grid
from identification.free_decay.vibration import UNKNOWNS, vibration_of
from symbolic import Expression

Array = NDArray[np.float64]
_OWN = 3
"""Angle, rate and centre, the last of `UNKNOWNS`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceSolution:
    """The minimum as IPOPT finds it.

    Attributes:
        x: unknowns in units of the likelihood's scales, shape (n,).
        cost: objective there.
        hessian: its exact Hessian there, shape (n, n).
        converged: False where the solver gave up; x is then where it did.
        status: the solver's own word.
        iterations: of the solver.
    """

    x: Array
    cost: float
    hessian: Array
    converged: bool
    status: str
    iterations: int


def solve_reference(likelihood: Likelihood, noise: float, max_iter: int = 100) -> ReferenceSolution:
    """Minimise the objective for one scale of the noise, from the likelihood's own start.

    Args:
        likelihood: of the recordings.
        noise: scale of the noise besides the encoder's step [rad], greater than 0.
        max_iter: iterations allowed.
    """
    x = ca.MX.sym("x", likelihood.scales.size)
    cost = ca.MX(0)
    for recording in range(len(likelihood.vibrations)):
        cost = cost + _cost(likelihood, recording, x, noise)
    options: dict[str, Any] = {
        "print_time": False,
        "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10, "max_iter": max_iter},
    }
    solver = ca.nlpsol("free_decay", "ipopt", {"x": x, "f": cost}, options)
    solution = solver(x0=likelihood.start())
    stats = solver.stats()
    hessian = ca.Function("hessian", [x], [ca.hessian(cost, x)[0]])
    return ReferenceSolution(
        x=solution["x"].full().ravel(),
        cost=float(solution["f"]),
        hessian=hessian(solution["x"]).full(),
        converged=bool(stats["success"]),
        status=str(stats["return_status"]),
        iterations=int(stats["iter_count"]),
    )


def _cost(likelihood: Likelihood, recording: int, x: ca.MX, noise: float) -> Expression:
    """The sum of -log P of one recording's readings."""
    vibration, at = likelihood.vibrations[recording], likelihood.columns(recording)
    # Without a slip among the unknowns it is 0: the patch sticks.
    places = [*range(len(at) - _OWN), *range(len(UNKNOWNS) - _OWN, len(UNKNOWNS))]
    unknowns = ca.MX(len(UNKNOWNS), 1)
    unknowns[places] = (ca.MX(ca.DM(likelihood.scales)) * x)[at]
    times, samples = sample_grid(vibration)
    geometry = ca.DM([*contact_of(vibration), vibration.decay.inertia])
    angles = vibration_of(np.diff(times))(unknowns, geometry)[samples.tolist()]
    upper, lower = (
        (ca.DM(vibration.psi) + half - angles) / noise
        for half in (vibration.step / 2, -vibration.step / 2)
    )
    width = np.log(-np.expm1(-vibration.step / noise))
    return ca.sum1(_softplus(-upper) + _softplus(lower)) - vibration.psi.size * width


def _softplus(u: Expression) -> Expression:
    """log(1 + exp(u)) without overflow."""
    return ca.fmax(u, 0) + ca.log1p(ca.exp(-ca.fabs(u)))
