"""k and b_t by the trust region against IPOPT with the exact Hessian, and against a closed form."""

import numpy as np
import pytest

from identification.free_decay.likelihood import Likelihood
from identification.free_decay.onset import find_vibration
from identification.free_decay.reference import ReferenceSolution, solve_reference
from identification.free_decay.solution import Solution, solve
from identification.free_decay.vibration import vibration_of
from reference_rig import CONTACT_HALF_LENGTHS, FOURTEEN_BIT_STEP, make_impact, make_impacts
from reference_rig import THESIS_TYRE as TYRE
from tests.identification.factories import as_decay

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
    assert reference.converged, reference.status
    spread = np.sqrt(np.diag(np.linalg.inv(reference.hessian)))
    np.testing.assert_array_less(np.abs(solution.x - reference.x) / spread, 0.03)
    assert solution.evaluation.cost == pytest.approx(reference.cost, abs=1e-3)
    assert solution.evaluation.cost >= reference.cost - 1e-6
    shared = slice(likelihood.shared)
    curved, gauss = (
        np.linalg.inv(h)[shared, shared] for h in (reference.hessian, solution.evaluation.hessian)
    )
    np.testing.assert_allclose(np.diag(gauss), np.diag(curved), rtol=0.1)


def test_a_sticking_patch_swings_as_the_closed_form_says() -> None:
    k, b_t, a, e, J_A = 2.4e6, 1.1, 0.045, 0.01, 0.16
    t = np.arange(400) * 1e-3
    found = vibration_of(np.diff(t))([k, b_t, 0, 0.004, 0.1, 0.001], [a, e, J_A]).full().ravel()

    K, decay = 2 * a * k * (e**2 + a**2 / 3), b_t / 2 / J_A
    pole = -decay + 1j * np.sqrt(K / J_A - decay**2)
    # Offset and rate at t = 0 are the real parts of z and of pole z.
    z = 0.003 + 1j * (pole.real * 0.003 - 0.1) / pole.imag
    np.testing.assert_allclose(found, 0.001 + (z * np.exp(pole * t)).real, atol=1e-12)


def test_the_objective_is_that_of_the_likelihood(sticking: Pair) -> None:
    likelihood, solution, reference = sticking
    at = likelihood.evaluate(reference.x, solution.noise)

    assert at.cost == pytest.approx(reference.cost, rel=1e-9)
    assert np.linalg.norm(at.gradient) < 1e-4 * np.sqrt(np.diag(at.hessian)).max()
