"""The covariance of what recordings share, against leaving out, against scatter, and its pieces."""

from dataclasses import replace

import numpy as np
import pytest

from identification.free_decay.jackknife import half_swings, spread_of
from identification.free_decay.likelihood import Programme
from identification.free_decay.noise_continuation import Solution, solve
from identification.free_decay.onset import release
from identification.free_decay.quantisation import misfit
from identification.free_decay.recording import Decay
from identification.free_decay.vibration import swing
from reference_rig import FOURTEEN_BIT_STEP, inertia, make_impact
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from symbolic import Rig, Tyre

RIG = Rig(a=TYRE.a, e=TYRE.e, J_A=inertia(TYRE.e))
SLIP = 1 / (TYRE.mu * 400.0)


def decay(t: np.ndarray, psi: np.ndarray) -> Decay:
    return Decay(name="run", t=t, psi=psi, rig=RIG, tyre=Tyre(k=2e6))


@pytest.fixture(scope="module")
def sticking() -> tuple[Programme, Solution]:
    """One recording, noise enough for a smooth likelihood, k and b_t the only shared unknowns."""
    made = make_impact(5, noise=FOURTEEN_BIT_STEP, tyre=TYRE, swing=0.02)
    programme = Programme([release(decay(made.t, made.psi))], sliding=False)
    return programme, solve(programme)


def test_half_swings() -> None:
    psi = np.array([3.0, 2.0, -1.0, -2.0, -1.5, 0.5, 1.0, 0.9])

    assert half_swings(psi) == [slice(0, 3), slice(3, 6), slice(6, 8)]
    assert half_swings(psi[:3]) == [slice(0, 3)]


def test_half_swings_are_all_of_it(sticking: tuple[Programme, Solution]) -> None:
    psi = sticking[1].look.swings[0].psi
    parts = half_swings(psi)

    np.testing.assert_array_equal(np.concatenate([psi[part] for part in parts]), psi)
    # Two half swings a period.
    of = sticking[0].releases[0]
    assert len(parts) == pytest.approx((of.t[-1] - of.t[0]) * of.omega / np.pi, abs=2)


def test_is_the_jackknifes(sticking: tuple[Programme, Solution]) -> None:
    programme, solution = sticking
    of, made = programme.releases[0], solution.look.swings[0]
    parts = half_swings(made.psi)

    # The step that Newton's method would take without one half swing, one after the other.
    changes = []
    for part in parts:
        kept = np.ones(of.t.size, dtype=bool)
        kept[part] = False
        along = made.sensitivities[kept]
        told = misfit(of.psi[kept], made.psi[kept], of.step, solution.noise)
        hessian = along.T @ (along * told.curvature[:, None])
        changes.append(-np.linalg.solve(hessian, along.T @ told.slope)[:2])
    expected = sum(np.outer(change, change) for change in changes)

    spread = spread_of(programme, solution)
    np.testing.assert_allclose(spread.covariance, expected, rtol=0.05, atol=0.02 * expected.max())
    assert spread.freedom == len(parts) - 2


def test_information_is_that_of_k_and_b_t_alone(sticking: tuple[Programme, Solution]) -> None:
    programme, solution = sticking
    hessian = solution.look.hessian
    own = np.linalg.solve(hessian[2:, 2:], hessian[2:, :2])

    spread = spread_of(programme, solution)

    # The Schur complement: what is left once the recording's own unknowns are eliminated.
    np.testing.assert_allclose(spread.information, hessian[:2, :2] - hessian[:2, 2:] @ own, rtol=1e-6)


def test_a_half_swing_that_carries_everything(sticking: tuple[Programme, Solution]) -> None:
    programme, solution = sticking
    made = solution.look.swings[0]
    monotone = replace(
        solution,
        look=replace(solution.look, swings=(made._replace(psi=np.linspace(0.02, 0.01, made.psi.size)),)),
    )

    spread = spread_of(programme, monotone)

    assert spread.freedom == 1
    assert np.isfinite(spread.covariance).all()


@pytest.mark.parametrize("noise", [0.0, 0.7])
def test_is_the_scatter_of_the_estimates(noise: float) -> None:
    t, rng = np.arange(1100) / 1000, np.random.default_rng(3)
    geometry = np.array([RIG.a, RIG.e, RIG.J_A])
    errors = []
    for _ in range(50):
        reach, zero = rng.uniform(0.006, 0.011), rng.uniform(-0.01, 0.01)
        psi = swing(t, np.array([TYRE.k, B_T, SLIP, zero + reach, 0.0, zero]), geometry).psi
        seen = psi + noise * FOURTEEN_BIT_STEP * rng.normal(size=t.size)
        read = FOURTEEN_BIT_STEP * np.round(seen / FOURTEEN_BIT_STEP)
        programme = Programme([release(decay(t, read))])
        solution = solve(programme)
        std = np.sqrt(np.diag(spread_of(programme, solution).covariance))[:2]
        errors.append((solution.x[:2] - np.array([TYRE.k, B_T]) / programme.scales[:2]) / std)

    # A standard deviation from some ten half swings is uncertain itself, and leans to the large side.
    size = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (size > 0.6).all()
    assert (size < 1.3).all()
