"""Steps of an encoder, and the likelihood of its readings."""

import numpy as np
import pytest

from identification.free_decay.quantisation import encoder_step, misfit

STEP = 2 * np.pi / 2**14
T = np.arange(1500) / 1000
ANGLE = 0.0123 + 0.006 * np.exp(-4 * T) * np.cos(33 * T)
RNG = np.random.default_rng(5)


@pytest.mark.parametrize("digits", [6, 8, 12])
def test_step_survives_rounding_in_the_file(digits: int) -> None:
    psi = np.round(np.round(ANGLE / STEP) * STEP, digits)

    assert encoder_step(psi) == pytest.approx(STEP, rel=2 * 10.0**-digits / np.ptp(psi))


def test_step_despite_wrong_readings() -> None:
    psi = np.round(ANGLE / STEP) * STEP
    psi[RNG.choice(psi.size, 20, replace=False)] += RNG.normal(0, 0.01, 20)

    assert encoder_step(psi) == pytest.approx(STEP, rel=1e-9)


def test_few_levels() -> None:
    assert encoder_step(np.array([0.0, 3 * STEP, 2 * STEP])) == pytest.approx(STEP)


def test_no_step() -> None:
    assert encoder_step(ANGLE) == pytest.approx(1e-6 * np.ptp(ANGLE))
    assert encoder_step(ANGLE + RNG.normal(0, 1e-4, T.size)) < 1e-5 * np.ptp(ANGLE)


@pytest.mark.parametrize("scale", [0.01 * STEP, 0.3 * STEP, 3 * STEP])
def test_cells_share_all_probability(scale: float) -> None:
    cells = STEP * np.arange(-400, 401)

    told = misfit(cells, np.array(0.123 * STEP), STEP, scale)

    assert np.exp(-told.cost).sum() == pytest.approx(1, abs=1e-9)


def test_hard_limits_without_noise() -> None:
    inside, outside = misfit(np.zeros(2), np.array([0.49, 0.51]) * STEP, STEP, 1e-4 * STEP).cost

    assert inside == pytest.approx(0, abs=1e-12)
    assert outside == pytest.approx(100, rel=1e-6)


def test_density_without_steps() -> None:
    # The logistic density exp(-u) / (s (1 + exp(-u))^2), times the width of the cell.
    told = misfit(np.array([0.3]), np.array([0.0]), 1e-9, 1.0)

    assert told.cost[0] == pytest.approx(0.3 + 2 * np.log1p(np.exp(-0.3)) - np.log(1e-9), rel=1e-6)


@pytest.mark.parametrize("scale", [0.02 * STEP, STEP])
def test_derivatives(scale: float) -> None:
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
