"""k and b_t by the trust region against IPOPT with the exact Hessian.

The reference is single shooting: the angles at the samples are functions of the unknowns, and CasADi
differentiates the objective twice, curvature of the angles included, which `solve` leaves out.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from identification.free_decay.likelihood import Likelihood, contact_of, integration_grid
from identification.free_decay.onset import find_vibration
from identification.free_decay.solution import Solution, solve
from identification.free_decay.vibration import PARAMETERS, UNKNOWNS, initial_state, vibration_step
from reference_rig import CONTACT_HALF_LENGTHS, FOURTEEN_BIT_STEP, make_impact, make_impacts
from reference_rig import THESIS_TYRE as TYRE
from tests.identification.factories import as_decay

OWN = 3
"""Angle, rate and centre, the last of `UNKNOWNS`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceSolution:
    """The minimum as IPOPT finds it; x in units of the likelihood's scales."""

    x: np.ndarray
    cost: float
    hessian: np.ndarray
    status: str


def vibration_of(steps: np.ndarray) -> ca.Function:
    """(unknowns, geometry) -> psi, at the first sample and after each of these steps [s]."""
    unknowns, geometry = ca.MX.sym("unknowns", len(UNKNOWNS)), ca.MX.sym("geometry", 3)
    state, theta = ca.SX.sym("state", 6), ca.SX.sym("theta", len(PARAMETERS))
    rig, dt = ca.SX.sym("geometry", 3), ca.SX.sym("dt")
    step = ca.Function("step", [state, dt, theta, rig], [vibration_step(state, theta, rig, dt)])
    first = initial_state(unknowns, geometry)
    chosen = unknowns[[UNKNOWNS.index(name) for name in PARAMETERS]]
    constant = (ca.repmat(vector, 1, steps.size) for vector in (chosen, geometry))
    states = step.mapaccum(steps.size)(first, ca.DM(steps).T, *constant)
    return ca.Function("vibration", [unknowns, geometry], [ca.vertcat(first[0], states[0, :].T)])


def solve_reference(likelihood: Likelihood, noise: float) -> ReferenceSolution:
    """Minimise the objective for one scale of the noise [rad], from the likelihood's own start."""
    x = ca.MX.sym("x", likelihood.scales.size)
    cost = sum(_cost(likelihood, i, x, noise) for i in range(len(likelihood.vibrations)))
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10}}
    solver = ca.nlpsol("free_decay", "ipopt", {"x": x, "f": cost}, options)
    solution = solver(x0=likelihood.start())
    hessian = ca.Function("hessian", [x], [ca.hessian(cost, x)[0]])
    return ReferenceSolution(
        x=solution["x"].full().ravel(),
        cost=float(solution["f"]),
        hessian=hessian(solution["x"]).full(),
        status=solver.stats()["return_status"],
    )


def _cost(likelihood: Likelihood, recording: int, x: ca.MX, noise: float) -> ca.MX:
    """The sum of -log P of one recording's readings."""
    vibration, at = likelihood.vibrations[recording], likelihood.columns(recording)
    unknowns = ca.MX(len(UNKNOWNS), 1)
    places = [*range(len(at) - OWN), *range(len(UNKNOWNS) - OWN, len(UNKNOWNS))]
    unknowns[places] = (ca.MX(ca.DM(likelihood.scales)) * x)[at]
    times, samples = integration_grid(vibration)
    geometry = ca.DM([*contact_of(vibration), vibration.decay.inertia])
    angles = vibration_of(np.diff(times))(unknowns, geometry)[samples.tolist()]
    upper, lower = (
        (ca.DM(vibration.psi) + half - angles) / noise
        for half in (vibration.step / 2, -vibration.step / 2)
    )
    width = np.log(-np.expm1(-vibration.step / noise))
    return ca.sum1(_softplus(-upper) + _softplus(lower)) - vibration.psi.size * width


def _softplus(u: ca.MX) -> ca.MX:
    """log(1 + exp(u)) without overflow."""
    return ca.fmax(u, 0) + ca.log1p(ca.exp(-ca.fabs(u)))


Pair = tuple[Likelihood, Solution, ReferenceSolution]


def solved(likelihood: Likelihood) -> Pair:
    solution = solve(likelihood)
    return likelihood, solution, solve_reference(likelihood, solution.noise)


@pytest.fixture(scope="module")
def sticking() -> Pair:
    made = make_impact(5, noise=FOURTEEN_BIT_STEP, tyre=TYRE, swing=0.02)
    return solved(Likelihood([find_vibration(as_decay(made))], sliding=False))


def test_the_programme_agrees_where_the_patch_sticks(sticking: Pair) -> None:
    agrees(*sticking)


@pytest.mark.long
def test_the_programme_agrees_where_the_ends_slide() -> None:
    made = make_impacts(4, lengths=CONTACT_HALF_LENGTHS[::3], impacts=1)
    agrees(*solved(Likelihood([find_vibration(as_decay(one)) for one in made])))


def agrees(likelihood: Likelihood, solution: Solution, reference: ReferenceSolution) -> None:
    """Far less apart than the readings determine either."""
    assert solution.converged
    assert reference.status == "Solve_Succeeded"
    spread = np.sqrt(np.diag(np.linalg.inv(reference.hessian)))
    np.testing.assert_array_less(np.abs(solution.x - reference.x) / spread, 0.03)
    assert solution.evaluation.cost == pytest.approx(reference.cost, abs=1e-3)
    assert solution.evaluation.cost >= reference.cost - 1e-6
    shared = slice(likelihood.shared)
    curved, gauss = (
        np.linalg.inv(h)[shared, shared] for h in (reference.hessian, solution.evaluation.hessian)
    )
    np.testing.assert_allclose(np.diag(gauss), np.diag(curved), rtol=0.1)


def test_the_objective_is_that_of_the_likelihood(sticking: Pair) -> None:
    likelihood, solution, reference = sticking
    at = likelihood.evaluate(reference.x, solution.noise)

    assert at.cost == pytest.approx(reference.cost, rel=1e-9)
    assert np.linalg.norm(at.gradient) < 1e-4 * np.sqrt(np.diag(at.hessian)).max()
