"""The likelihood of free vibrations: what depends on what, and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from identification.free_decay import noise_continuation as solving
from identification.free_decay.likelihood import Likelihood, neg_log_likelihood
from identification.free_decay.noise_continuation import (
    LikelihoodMaximum,
    half_swings,
    jackknife_covariance,
    maximise_likelihood,
)
from identification.free_decay.vibration_detection import find_vibration
from identification.free_decay.vibration_model import simulate_vibration
from reference_rig import FOURTEEN_BIT_STEP, inertia, make_impact, make_impacts
from reference_rig import FOURTEEN_BIT_STEP as STEP
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from rig_recordings import as_decay
from symbolic import Rig
from tests.identification.factories import decay


@pytest.fixture(scope="module")
def likelihood() -> Likelihood:
    """Two contacts, of which the first has two recordings."""
    made = make_impacts(4, lengths=(0.036, 0.050), impacts=2)[:3]
    return Likelihood([find_vibration(as_decay(recording)) for recording in made])


def test_who_depends_on_what(likelihood: Likelihood) -> None:
    assert likelihood.shared == 4
    assert likelihood.columns(0) == [0, 1, 2, 4, 5, 6]
    assert likelihood.columns(1) == [0, 1, 2, 7, 8, 9]
    assert likelihood.columns(2) == [0, 1, 3, 10, 11, 12]
    assert Likelihood(likelihood.vibrations, sliding=False).columns(1) == [0, 1, 5, 6, 7]


def test_derivatives(likelihood: Likelihood) -> None:
    x, noise = likelihood.start(), STEP
    look = likelihood.evaluate(x, noise)

    def difference(direction: np.ndarray) -> float:
        ahead, behind = (likelihood.evaluate(x + step * direction, noise).cost for step in (1e-6, -1e-6))
        return (ahead - behind) / 2e-6

    slopes = [difference(axis) for axis in np.eye(x.size)]
    np.testing.assert_allclose(look.gradient, slopes, rtol=1e-3, atol=1e-3 * np.abs(slopes).max())
    assert (np.linalg.eigvalsh(look.hessian) > 0).all()
    # No recording knows of another one's own unknowns.
    assert not look.hessian[4:7, 7:].any()


def test_a_wheel_that_would_not_vibrate(likelihood: Likelihood) -> None:
    x = likelihood.start()
    x[1] = 100.0

    assert likelihood.evaluate(x, STEP).cost == np.inf


@pytest.mark.parametrize("share", [0.1, 1.0, 5.0])
def test_likeliest_noise(likelihood: Likelihood, share: float) -> None:
    responses = likelihood.evaluate(likelihood.start(), 1.0).responses
    rng = np.random.default_rng(2)
    noisy = []
    for of, made in zip(likelihood.vibrations, responses, strict=True):
        psi = of.decay.psi.copy()
        seen = made.psi + rng.logistic(0, share * of.step, made.psi.size)
        psi[of.first : of.last] = of.step * np.round(seen / of.step)
        noisy.append(replace(of, decay=replace(of.decay, psi=psi)))

    assert Likelihood(noisy).likeliest_noise(responses) == pytest.approx(share * STEP, rel=0.1)


@pytest.mark.parametrize("scale", [0.01 * STEP, 0.3 * STEP, 3 * STEP])
def test_cells_share_all_probability(scale: float) -> None:
    cells = STEP * np.arange(-400, 401)

    told = neg_log_likelihood(cells, np.array(0.123 * STEP), STEP, scale)

    assert np.exp(-told.value).sum() == pytest.approx(1, abs=1e-9)


def test_limits_of_the_misfit() -> None:
    """The hard limits of the cell without noise, the logistic density without steps."""
    hard = neg_log_likelihood(np.zeros(2), np.array([0.49, 0.51]) * STEP, STEP, 1e-4 * STEP)
    density = neg_log_likelihood(np.array([0.3]), np.array([0.0]), 1e-9, 1.0)

    np.testing.assert_allclose(hard.value, [0, 100], rtol=1e-6, atol=1e-12)
    # exp(-u) / (s (1 + exp(-u))^2), times the width of the cell.
    assert density.value[0] == pytest.approx(0.3 + 2 * np.log1p(np.exp(-0.3)) - np.log(1e-9), rel=1e-6)


@pytest.mark.parametrize("scale", [0.02 * STEP, STEP])
def test_derivatives_of_the_misfit(scale: float) -> None:
    read, angle = np.zeros(7), STEP * np.array([-3.0, -0.51, -0.49, 0.1, 0.5, 0.52, 40.0])
    h = 1e-4 * scale
    below, at, above = (neg_log_likelihood(read, angle + d, STEP, scale) for d in (-h, 0, h))

    slope, curvature = ((getattr(above, n) - getattr(below, n)) / (2 * h) for n in ("value", "slope"))
    np.testing.assert_allclose(at.slope, slope, rtol=1e-6, atol=1e-6 / scale)
    np.testing.assert_allclose(at.curvature, curvature, rtol=1e-6, atol=1e-6 / scale**2)
    assert (at.curvature >= 0).all()


RIG = Rig(a=TYRE.a, e=TYRE.e, J_A=inertia(TYRE.e))
SLIP = 1 / (TYRE.mu * 400.0)


@pytest.fixture(scope="module")
def sticking() -> tuple[Likelihood, LikelihoodMaximum]:
    """One recording, noise enough for a smooth likelihood, k and b_t the only shared unknowns."""
    made = make_impact(5, noise=FOURTEEN_BIT_STEP, tyre=TYRE, swing=0.02)
    likelihood = Likelihood([find_vibration(decay(made.t, made.psi, RIG))], sliding=False)
    return likelihood, maximise_likelihood(likelihood)


def test_half_swings_are_all_of_it(sticking: tuple[Likelihood, LikelihoodMaximum]) -> None:
    few = np.array([3.0, 2.0, -1.0, -2.0, -1.5, 0.5, 1.0, 0.9])
    assert half_swings(few) == [slice(0, 3), slice(3, 6), slice(6, 8)]
    assert half_swings(few[:3]) == [slice(0, 3)]
    psi = sticking[1].evaluation.responses[0].psi
    parts = half_swings(psi)

    np.testing.assert_array_equal(np.concatenate([psi[part] for part in parts]), psi)
    # Two half swings a period.
    of = sticking[0].vibrations[0]
    assert len(parts) == pytest.approx((of.t[-1] - of.t[0]) * of.omega / np.pi, abs=2)


def test_covariance_is_the_jackknifes_and_information_that_of_k_and_b_t_alone(
    sticking: tuple[Likelihood, LikelihoodMaximum],
) -> None:
    likelihood, solution = sticking
    of, made = likelihood.vibrations[0], solution.evaluation.responses[0]
    parts = half_swings(made.psi)

    # The step that Newton's method would take without one half swing, one after the other.
    changes = []
    for part in parts:
        kept = np.ones(of.t.size, dtype=bool)
        kept[part] = False
        along = made.sensitivities[kept]
        told = neg_log_likelihood(of.psi[kept], made.psi[kept], of.step, solution.noise)
        hessian = along.T @ (along * told.curvature[:, None])
        changes.append(-np.linalg.solve(hessian, along.T @ told.slope)[:2])
    expected = sum(np.outer(change, change) for change in changes)

    spread = jackknife_covariance(likelihood, solution)
    np.testing.assert_allclose(spread.covariance, expected, rtol=0.05, atol=0.02 * expected.max())
    assert spread.degrees_of_freedom == len(parts) - 2
    hessian = solution.evaluation.hessian
    own = np.linalg.solve(hessian[2:, 2:], hessian[2:, :2])
    # The Schur complement: what is left once the recording's own unknowns are eliminated.
    np.testing.assert_allclose(spread.information, hessian[:2, :2] - hessian[:2, 2:] @ own, rtol=1e-6)


def test_a_half_swing_that_carries_everything(sticking: tuple[Likelihood, LikelihoodMaximum]) -> None:
    likelihood, solution = sticking
    made = solution.evaluation.responses[0]
    risen = made._replace(psi=np.linspace(0.02, 0.01, made.psi.size))
    monotone = replace(solution, evaluation=replace(solution.evaluation, responses=(risen,)))

    spread = jackknife_covariance(likelihood, monotone)

    assert spread.degrees_of_freedom == 1
    assert np.isfinite(spread.covariance).all()


@pytest.mark.parametrize("noise", [pytest.param(0.0, marks=pytest.mark.long), 0.7])
def test_is_the_scatter_of_the_estimates(noise: float) -> None:
    t, rng = np.arange(1100) / 1000, np.random.default_rng(3)
    geometry = np.array([RIG.a, RIG.e, RIG.J_A])
    errors = []
    for _ in range(50):
        reach, zero = rng.uniform(0.006, 0.011), rng.uniform(-0.01, 0.01)
        psi = simulate_vibration(t, np.array([TYRE.k, B_T, SLIP, zero + reach, 0.0, zero]), geometry).psi
        seen = psi + noise * FOURTEEN_BIT_STEP * rng.normal(size=t.size)
        read = FOURTEEN_BIT_STEP * np.round(seen / FOURTEEN_BIT_STEP)
        likelihood = Likelihood([find_vibration(decay(t, read, RIG))])
        solution = maximise_likelihood(likelihood)
        std = np.sqrt(np.diag(jackknife_covariance(likelihood, solution).covariance))[:2]
        errors.append((solution.x[:2] - np.array([TYRE.k, B_T]) / likelihood.scales[:2]) / std)

    # A standard deviation from some ten half swings is uncertain itself, and leans to the large side.
    size = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (size > 0.6).all()
    assert (size < 1.3).all()


def rig_likelihood(noise: float = 0.0) -> Likelihood:
    return Likelihood([find_vibration(as_decay(make_impact(5, noise=noise * FOURTEEN_BIT_STEP)))])


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_nothing_near_is_likelier(noise: float) -> None:
    made = rig_likelihood(noise)
    found = maximise_likelihood(made)
    std = np.sqrt(np.diag(np.linalg.inv(found.evaluation.hessian)))
    rng = np.random.default_rng(1)

    assert found.converged
    assert found.evaluation.cost == made.evaluate(found.x, found.noise).cost
    for reach in np.repeat([0.1, 1.0, 10.0], 20):
        beside = found.x + reach * std * rng.normal(size=std.size)
        assert made.evaluate(beside, found.noise).cost > found.evaluation.cost - 1e-3


@pytest.mark.parametrize("changes", [(0.6, 1.0), (1.6, 4.0), (0.8, 4.0), (2.5, 1.0)])
def test_start_does_not_matter(changes: tuple[float, float], monkeypatch: pytest.MonkeyPatch) -> None:
    made = rig_likelihood()
    usual, start = maximise_likelihood(made), made.start()
    start[:2] *= changes
    monkeypatch.setattr(made, "start", lambda: start)

    found = maximise_likelihood(made)

    std = np.sqrt(np.diag(np.linalg.inv(usual.evaluation.hessian)))
    assert found.converged
    assert (np.abs(found.x - usual.x) < 0.1 * std).all()


@pytest.mark.parametrize(("limit", "value"), [("_MAX_STAGES", 2), ("_SLOPE", 0.0)])
def test_says_when_it_does_not_end(limit: str, value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, limit, value)

    assert not maximise_likelihood(rig_likelihood()).converged


def test_a_start_that_does_not_vibrate(monkeypatch: pytest.MonkeyPatch) -> None:
    made = rig_likelihood()
    start = made.start()
    start[1] = 100.0
    monkeypatch.setattr(made, "start", lambda: start)

    with pytest.raises(np.linalg.LinAlgError, match="do not depend"):
        maximise_likelihood(made)
