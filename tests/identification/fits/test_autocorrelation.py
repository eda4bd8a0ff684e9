"""Serial correlation against what is known of autoregressive processes."""

import numpy as np
import pytest
from scipy.signal import lfilter

from identification.fits.autocorrelation import autocorrelation_time, autoregression, lagged_products
from identification.fits.covariance import scores_variance
from tests.identification.factories import first_order


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.8, 0.95])
def test_autocorrelation_time_of_a_first_order_process(phi: float) -> None:
    # The sum of phi^n over the lags where phi^n > 0.05.
    expected = 1 + 2 * sum(phi**n for n in range(1, 100) if phi**n > 0.05)
    made = autocorrelation_time(first_order(phi, 100_000, np.random.default_rng(1)))

    assert made == pytest.approx(expected, rel=0.1)


def test_autocorrelation_time_counts_the_samples_that_are_there() -> None:
    residual = first_order(0.9, 100_000, np.random.default_rng(1))
    residual[1::2] = np.nan
    assert autocorrelation_time(residual) == pytest.approx((1 + 0.9**2) / (1 - 0.9**2), rel=0.15)


def test_lags_that_hardly_any_two_samples_show_do_not_end_the_sum() -> None:
    # At lag 1 there are two samples, where the first half goes over into the second.
    found = []
    for seed in range(5):
        residual = first_order(0.9, 20_000, np.random.default_rng(seed))
        residual[1:10_000:2] = np.nan
        residual[10_000::2] = np.nan
        found.append(autocorrelation_time(residual))
    np.testing.assert_allclose(found, (1 + 0.9**2) / (1 - 0.9**2), rtol=0.2)


@pytest.mark.parametrize(
    "residual",
    [[1.0, -1.0] * 50, [3.0] * 50, [0.1] * 50, [0.1, np.nan] * 50, [2.0], [np.nan] * 5],
    ids=["alternating", "constant", "rounded", "with gaps", "one sample", "nothing"],
)
def test_autocorrelation_time_is_never_below_one(residual: list[float]) -> None:
    assert autocorrelation_time(np.array(residual)) == 1


def test_products_are_those_of_the_definition() -> None:
    values = np.random.default_rng(2).standard_normal(37)

    made = lagged_products(values)

    expected = [values[: 37 - lag] @ values[lag:] for lag in range(37)]
    np.testing.assert_allclose(made, expected, rtol=0, atol=1e-12)


def test_autoregression_finds_what_made_the_series() -> None:
    made = [1.0, -1.5, 0.7]
    series = lfilter([1.0], made, np.random.default_rng(2).standard_normal(20_000))
    holed = series.copy()
    holed[::50] = np.nan
    for given in (series, holed):
        found = autoregression(given)
        np.testing.assert_allclose(found[:3], made, atol=0.05)
        assert np.abs(found[3:]).max(initial=0) < 0.05


@pytest.mark.parametrize("series", [np.zeros(50), np.full(50, np.nan), np.ones(3)])
def test_autoregression_of_next_to_nothing(series: np.ndarray) -> None:
    assert np.isfinite(autoregression(series)).all()


def test_autoregression_reaches_far_enough_for_an_echo() -> None:
    # 10 log10(1000) = 30 lags.
    echo = np.zeros(26)
    echo[0], echo[25] = 1.0, -0.8
    found = autoregression(lfilter([1.0], echo, np.random.default_rng(1).standard_normal(3000))[2000:])

    assert found[25] == pytest.approx(-0.8, abs=0.1)


def test_the_order_is_that_of_akaikes_criterion() -> None:
    # Of white noise it is 0 with probability exp(-sum P(chi2_j > 2 j) / j) = 0.712, Shibata (1976).
    rng = np.random.default_rng(0)
    orders = [autoregression(rng.standard_normal(1000)).size - 1 for _ in range(400)]

    assert np.mean(np.equal(orders, 0)) == pytest.approx(0.712, abs=0.07)


def test_few_samples_do_not_determine_many_weights() -> None:
    # Of twenty white samples the variance of the sum is 20; overfitted weights would make it small.
    variances = [
        scores_variance(np.ones((20, 1)), np.random.default_rng(seed).standard_normal(20), 0.0)[0, 0]
        for seed in range(300)
    ]

    assert np.quantile(variances, 0.1) > 0.5 * 20
    assert np.median(variances) == pytest.approx(20, rel=0.1)
