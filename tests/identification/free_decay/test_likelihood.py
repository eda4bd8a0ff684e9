"""The likelihood of free vibrations: what depends on what, and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from identification.free_decay.likelihood import Likelihood, misfit
from identification.free_decay.onset import find_vibration
from reference_rig import FOURTEEN_BIT_STEP as STEP
from reference_rig import make_impacts
from tests.identification.factories import as_decay


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

    told = misfit(cells, np.array(0.123 * STEP), STEP, scale)

    assert np.exp(-told.cost).sum() == pytest.approx(1, abs=1e-9)


def test_limits_of_the_misfit() -> None:
    """The hard limits of the cell without noise, the logistic density without steps."""
    hard = misfit(np.zeros(2), np.array([0.49, 0.51]) * STEP, STEP, 1e-4 * STEP)
    density = misfit(np.array([0.3]), np.array([0.0]), 1e-9, 1.0)

    np.testing.assert_allclose(hard.cost, [0, 100], rtol=1e-6, atol=1e-12)
    # exp(-u) / (s (1 + exp(-u))^2), times the width of the cell.
    assert density.cost[0] == pytest.approx(0.3 + 2 * np.log1p(np.exp(-0.3)) - np.log(1e-9), rel=1e-6)


@pytest.mark.parametrize("scale", [0.02 * STEP, STEP])
def test_derivatives_of_the_misfit(scale: float) -> None:
    read, angle = np.zeros(7), STEP * np.array([-3.0, -0.51, -0.49, 0.1, 0.5, 0.52, 40.0])
    h = 1e-4 * scale
    below, at, above = (misfit(read, angle + d, STEP, scale) for d in (-h, 0, h))

    np.testing.assert_allclose(
        at.slope, (above.cost - below.cost) / (2 * h), rtol=1e-6, atol=1e-6 / scale
    )
    np.testing.assert_allclose(
        at.curvature, (above.slope - below.slope) / (2 * h), rtol=1e-6, atol=1e-6 / scale**2
    )
    assert (at.curvature >= 0).all()
