from dataclasses import replace

import numpy as np
import pytest

from identification import Fit, Recording, fit
from identification.fits.covariance import (
    covariance,
    parameter_correlation,
    scores_variance,
    standard_deviations,
)
from identification.fits.least_squares_problem import torque_range
from symbolic import Model
from tests.identification.factories import (
    autoregressive,
    first_order,
    positions,
    read_campaign,
    with_torque,
)

NOISE = 0.004


@pytest.fixture(scope="module")
def noiseless() -> tuple[Fit, list[Recording]]:
    model = Model(corners=16)
    recordings = read_campaign(None, 1)[1]
    fitted = fit(model, recordings)
    return fitted, [with_torque(r, r.M_z + fitted.residuals[r.name]) for r in recordings]


def noisy(
    recordings: list[Recording], phi: float, seed: int, sizes: tuple[float, float] = (1, 1)
) -> list[Recording]:
    """The recordings with first-order noise of standard deviation `NOISE` times size times range."""
    rng = np.random.default_rng(seed)
    return [
        with_torque(r, r.M_z + NOISE * s * torque_range(r) * first_order(phi, r.t.size, rng))
        for r, s in zip(recordings, sizes, strict=True)
    ]


def test_white_noise_of_one_size_has_the_textbooks_covariance(noiseless) -> None:
    start, recordings = noiseless
    given = noisy(recordings, 0.0, 3)
    fitted = fit(start.model, given, start.values)
    expected = np.linalg.inv(fitted.jacobian.T @ fitted.jacobian) * NOISE**2
    expected = expected * np.outer(fitted.scales, fitted.scales)
    size = np.sqrt(np.diag(expected))

    np.testing.assert_allclose(standard_deviations(fitted, given), size, rtol=0.15)
    share = expected / np.outer(size, size)
    np.testing.assert_allclose(parameter_correlation(fitted, given), share, atol=0.1)


@pytest.mark.parametrize(
    ("phi", "sizes"),
    [(0.9, (1, 4)), *(pytest.param(phi, (1, 1), marks=pytest.mark.long) for phi in (0.0, 0.9, 0.97))],
)
def test_intervals_hold_the_truth(noiseless, phi: float, sizes: tuple[float, float]) -> None:
    start, recordings = noiseless
    truth, apart = positions(start), []
    for seed in range(40):
        given = noisy(recordings, phi, seed, sizes)
        fitted = fit(start.model, given, start.values)
        apart.append((positions(fitted) - truth) / standard_deviations(fitted, given))
    apart = np.array(apart)

    assert 0.9 <= np.mean(np.abs(apart) < 1.96) <= 0.99
    assert (np.mean(np.abs(apart) < 1.96, axis=0) > 0.82).all()


@pytest.mark.parametrize("weights", [[1.0], [1, -0.9], [1, -1.6, 0.8], [1, 0.5]])
def test_variance_of_a_sum_is_the_spectrum_at_zero(weights: list[float]) -> None:
    # The sum of n samples has variance n sigma^2 / A(1)^2.
    n, rng = 4000, np.random.default_rng(6)
    samples = (autoregressive(weights, n, rng) for _ in range(10))
    made = [scores_variance(np.ones((n, 1)), each, 0.0)[0, 0] for each in samples]

    assert np.mean(made) == pytest.approx(n / np.sum(weights) ** 2, rel=0.15)


def test_variance_of_a_sum_with_gaps() -> None:
    rng, n = np.random.default_rng(6), 4000
    whole, holed = [], []
    for _ in range(10):
        series = autoregressive([1, -0.9], n, rng)
        whole.append(scores_variance(np.ones((n, 1)), series, 0.0)[0, 0])
        series[rng.random(n) < 0.2] = np.nan
        series[1000:1300] = np.nan
        present = int(np.isfinite(series).sum())
        holed.append(scores_variance(np.ones((present, 1)), series, 0.0)[0, 0])
    kept = 0.8 * (n - 300) / n

    # Isolated gaps thin out a correlated series; what is left is still the same slow sum.
    lags = 0.9 ** np.arange(1, 200)
    expected = (1 + 2 * 0.8 * lags.sum()) / (1 + 2 * lags.sum())
    assert np.mean(holed) / np.mean(whole) == pytest.approx(kept * expected, rel=0.2)


@pytest.mark.parametrize("n", [40, 80])
def test_variance_where_there_are_few_samples_for_each_parameter(n: int) -> None:
    # Least squares of white noise on a quarter as many columns as samples: the variances are (J' J)^-1.
    rng, ratios = np.random.default_rng(4), []
    for _ in range(100):
        jacobian = rng.standard_normal((n, n // 4))
        inverse = np.linalg.inv(jacobian.T @ jacobian)
        noise = rng.standard_normal(n)
        residual = noise - jacobian @ inverse @ jacobian.T @ noise
        variance = inverse @ scores_variance(jacobian, residual, n / 4) @ inverse
        ratios.append(np.trace(variance) / np.trace(inverse))

    assert np.mean(ratios) == pytest.approx(1, abs=0.15)


@pytest.fixture(scope="module")
def noisy_fit(noiseless) -> tuple[Fit, list[Recording]]:
    start, recordings = noiseless
    given = noisy(recordings, 0.5, 1)
    return fit(start.model, given, start.values), given


def test_what_the_data_say_nothing_about_has_no_deviation(noisy_fit) -> None:
    fitted, given = noisy_fit
    blind = replace(fitted, jacobian=fitted.jacobian * np.array([0.0, 1, 1]))
    spread = covariance(blind, given)

    assert np.isinf(standard_deviations(replace(fitted, jacobian=0 * fitted.jacobian), given)).all()
    assert np.isinf(spread[0, 0])
    assert np.isnan(spread[0, 1:]).all()
    assert np.isfinite(spread[1:, 1:]).all()


@pytest.mark.parametrize("share", [0.0, 0.01])
def test_whatever_takes_part_in_what_cannot_be_told_apart_has_no_deviation(
    noisy_fit, share: float
) -> None:
    # A hundredth of the second column in the copy of the first one leaves all three undetermined.
    fitted, given = noisy_fit
    first, second = fitted.jacobian[:, 0], fitted.jacobian[:, 1]
    mixed = first + share * np.linalg.norm(first) / np.linalg.norm(second) * second
    more = replace(
        fitted,
        jacobian=np.column_stack([fitted.jacobian, mixed]),
        labels=(*fitted.labels, (None, "more")),
        scales=np.append(fitted.scales, 1.0),
        prior_weights=np.append(fitted.prior_weights, 0.0),
    )

    unknown = np.isinf(standard_deviations(more, given))
    np.testing.assert_array_equal(unknown, [True, share > 0, False, True])
